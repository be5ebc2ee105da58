"""All parameters as one file, `@PARAM/param.pck`, which ground stations of ArduPilot read at once.

The format is that of ArduPilot's AP_Filesystem_Param: numbers are little-endian, and each name is
written without the characters that it shares with the one before.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator

from flightsim.mavlink.parameters import NamedParameters

PACKED_PARAMETERS = "@PARAM/param.pck"
_MAGIC = 0x671B
_HEADER = struct.Struct("<HHH")
"""Magic number, parameters in the file, parameters of the vehicle."""
_INT32, _FLOAT = 3, 4
_MOST_SHARED = 15


class PackedParameters:
    """The file, packed anew only after a value has changed: clients read it in many small parts."""

    def __init__(self, named: NamedParameters) -> None:
        """Prepare to pack.

        Args:
            named: Parameters under the names that clients know.
        """
        self._parameters = named
        self._heads = tuple(_heads(named))
        self._values: tuple[float, ...] = ()
        self._packed = b""

    def file(self) -> bytes:
        """Return the bytes of the file as of now."""
        parameters = self._parameters
        # Values are compared, because a name of another flight stack may change its value while the
        # parameter behind it stays: two of its numbers can mean the same.
        values = tuple(parameters[name] for name, _ in self._heads)
        if values != self._values or not self._packed:
            # Both counts are the same: the file always holds all parameters.
            parts = [_HEADER.pack(_MAGIC, len(parameters), len(parameters))]
            for (_, head), value in zip(self._heads, values, strict=True):
                is_integer = head[0] == _INT32
                packed = struct.pack("<i", int(value)) if is_integer else struct.pack("<f", value)
                parts += (head, packed)
            self._values, self._packed = values, b"".join(parts)
        return self._packed


def _heads(parameters: NamedParameters) -> Iterator[tuple[str, bytes]]:
    """Yield each name, and the bytes before its value: its type and the new part of the name."""
    before = ""
    # Sorted names share the longest beginnings.
    for name in sorted(parameters):
        # One character of a name is always written, and four bits hold the shared ones.
        n_shared = min(_n_shared(before, name), len(name) - 1, _MOST_SHARED)
        rest = name[n_shared:].encode()
        kind = _INT32 if parameters.is_integer(name) else _FLOAT
        yield name, bytes((kind, n_shared | (len(rest) - 1) << 4)) + rest
        before = name


def _n_shared(first: str, second: str) -> int:
    """Return the number of characters with which both begin."""
    pairs = enumerate(zip(first, second, strict=False))
    return next((n for n, (a, b) in pairs if a != b), min(len(first), len(second)))
