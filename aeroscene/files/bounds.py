"""Bounds on the objects that a foreign file can make us build, checked before anything is built.

A packed file of 60 kB can ask for gigabytes of Python objects. Their number decides, not the number
of bytes. Every value of a JSON text but the first follows a comma, a colon or an opening bracket,
so counting those bytes bounds the objects at the speed of memory.
"""

from __future__ import annotations

MOST_OBJECTS = 5_000
"""Most objects of a scene; `aeroscene generate` makes up to 2,500."""
MOST_PRIMITIVES = 50_000
"""Most parts of all objects of a scene; the fullest that ships has some 5,000."""
MOST_POINTS = 1_000
"""Most corners of one outline."""
MOST_VALUES = 700_000
"""Most numbers, texts, keys and brackets of one JSON text: 140 for each of `MOST_OBJECTS`."""
MOST_JSON_BYTES = 8 << 20
"""Greatest length of one JSON text; a scene with `MOST_OBJECTS` has about 4 MiB."""
MOST_CONFIG_BYTES = 256 << 10
"""Greatest length of a file that a person writes: an airframe, a lidar, a recipe, settings."""
MOST_SEED = 2**63 - 1
"""Largest seed: that of signed 64-bit integers in tables."""
MOST_ID = 2**31 - 1
"""Largest id of an object or an area: that of signed 32-bit integers in pictures."""


def count_values(data: bytes) -> int:
    """Upper bound of the values and keys in a JSON text; bytes within texts count too."""
    return 1 + sum(data.count(mark) for mark in (b",", b":", b"[", b"{"))


def excess(
    data: bytes, most_bytes: int = MOST_JSON_BYTES, most_values: int = MOST_VALUES
) -> str | None:
    """Describe how a JSON text exceeds the bounds, and what would be valid; None if it does not.

    Args:
        data: JSON text.
        most_bytes: Greatest length.
        most_values: Most values and keys.
    """
    if len(data) > most_bytes:
        return f"holds more than {most_bytes >> 20} MiB of JSON; valid: at most that"
    if (count := count_values(data)) > most_values:
        return f"holds up to {count} values; valid: at most {most_values}"
    return None
