"""Values at the extremes of every type of field, and messages made of them."""

from __future__ import annotations

import math
import random
import re
import struct
from dataclasses import dataclass
from typing import Any

from flightsim.mavlink.dialect import LAYOUTS, dialect

FLOATS = (
    *(0.0, -0.0, 1.0, -1.0, 2.0, 3.0, 0.5, 47.4, 8.5, 90.1, 180.1, 255.0, 256.0, 65535.0, 65536.5),
    *(math.nan, math.inf, -math.inf, 1e30, -1e30, 5e9, -5e9, 2147483648.0, -2147483649.0, 1e-40),
    *(3.4028234663852886e38, -3.4028234663852886e38, 20000.0, 21196.0, 1e6),
)
_TEXTS = (
    *(b"", b"\xff" * 250, b"A" * 250, b"%s%n/../"),
    *(b"_HASH_CHECK", b"SYS_AUTOSTART", b"MPC_XY_CRUISE"),
)
_BITS = {"b": 8, "h": 16, "i": 32, "q": 64}
_V2_IDS = 256
"""Least number of a message that MAVLink 1 cannot carry."""
VEHICLE = (1, 1)
_SENDERS = ((255, 190), (255, 190), (254, 1), (1, 191), (0, 0), (1, 1), (255, 255))


def chance(rng: random.Random, share: float) -> bool:
    """True in a share of the calls."""
    return rng.random() < share


@dataclass(frozen=True)
class Field:
    """A field of a message: its name, the letter of its type and how many values it has."""

    name: str
    letter: str
    count: int


class MessageType:
    """A message type with its fields in wire order."""

    def __init__(self, message_class: Any) -> None:
        self.name: str = message_class.msgname
        self.layout = LAYOUTS[self.name]
        self._struct: struct.Struct = message_class.unpacker
        parts = re.findall(r"(\d*)(\D)", self._struct.format[1:])
        names = message_class.ordered_fieldnames
        self.fields = [
            Field(name, letter, int(count or 1))
            for name, (count, letter) in zip(names, parts, strict=True)
        ]

    def payload(self, rng: random.Random, given: dict[str, Any]) -> bytes:
        """A payload of drawn values, but for the given ones."""
        values: list[Any] = []
        for field in self.fields:
            if field.name in given:
                value = given[field.name]
                values += value if isinstance(value, (list, tuple)) else [value]
            else:
                values += drawn(rng, field)
        return self._struct.pack(*values)


def drawn(rng: random.Random, field: Field) -> list[Any]:
    """Values of a field, mostly at its extremes."""
    if field.letter == "s":
        return [rng.choice(_TEXTS) if chance(rng, 0.7) else rng.randbytes(field.count)]
    if field.count > 1 and chance(rng, 0.5):
        return [_number(rng, field.letter)] * field.count
    return [_number(rng, field.letter) for _ in range(field.count)]


def _number(rng: random.Random, letter: str) -> float:
    if letter in "fd":
        return rng.choice(FLOATS)
    bits, is_signed = _BITS[letter.lower()], letter.islower()
    low, high = (-(1 << bits - 1), (1 << bits - 1) - 1) if is_signed else (0, (1 << bits) - 1)
    if chance(rng, 0.3):
        return rng.randint(low, high)
    return rng.choice((low, high, 0, 1, 2, 3, 5, high - 1, min(high, 190)))


TYPES = {c.msgname: MessageType(c) for c in dialect.mavlink_map.values()}


def frame(rng: random.Random, name: str, /, **given: Any) -> bytes:
    """A frame of a message whose other fields are drawn; mostly meant for the vehicle."""
    kind = TYPES[name]
    if chance(rng, 0.8):
        for field, number in zip(("target_system", "target_component"), VEHICLE, strict=True):
            if any(known.name == field for known in kind.fields):
                given.setdefault(field, number)
    payload = kind.payload(rng, given)
    is_version_1 = kind.layout.message_id < _V2_IDS and chance(rng, 0.1)
    build = kind.layout.frame_v1 if is_version_1 else kind.layout.frame_v2
    return build(payload, rng.randrange(256), *rng.choice(_SENDERS))
