"""All parameters as one file, `@PARAM/param.pck`, which ground stations of ArduPilot read at once.

ArduPilot's AP_Filesystem_Param names what is in it: numbers little-endian, names without what they
share with the one before.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator

from flightsim.autopilot.parameters import Parameters, ParameterSpec
from flightsim.mavlink.parameters import NamedParameters

PACKED_PARAMETERS = "@PARAM/param.pck"
_MAGIC = 0x671B
_HEADER = struct.Struct("<HHH")
"""Magic number, parameters in the file, parameters of the vehicle."""
_INT32, _FLOAT = 3, 4
_MOST_SHARED = 15


class PackedParameters:
    """The file, packed anew only after a parameter has changed: clients may ask at every tick."""

    def __init__(self, named: NamedParameters, changing: Parameters) -> None:
        """Prepare to pack.

        Args:
            named: Parameters under the names that clients know.
            changing: Those behind them, which tell of changes.
        """
        self._parameters = named
        self._heads = tuple(_heads(named))
        self._packed: bytes | None = None
        changing.add_listener(self._forget)

    def file(self) -> bytes:
        """Bytes of the file as of now."""
        if self._packed is None:
            parameters = self._parameters
            parts = [_HEADER.pack(_MAGIC, len(parameters), len(parameters))]
            for name, head in self._heads:
                value = parameters[name]
                is_integer = head[0] == _INT32
                packed = struct.pack("<i", int(value)) if is_integer else struct.pack("<f", value)
                parts += (head, packed)
            self._packed = b"".join(parts)
        return self._packed

    def _forget(self, _spec: ParameterSpec, _value: float) -> None:
        self._packed = None


def _heads(parameters: NamedParameters) -> Iterator[tuple[str, bytes]]:
    """Each name, and the bytes before its value: its type and what is new in the name."""
    before = ""
    for name in sorted(parameters):
        n_shared = min(_n_shared(before, name), len(name) - 1, _MOST_SHARED)
        rest = name[n_shared:].encode()
        kind = _INT32 if parameters.is_integer(name) else _FLOAT
        yield name, bytes((kind, n_shared | (len(rest) - 1) << 4)) + rest
        before = name


def _n_shared(first: str, second: str) -> int:
    """Number of characters with which both begin."""
    pairs = enumerate(zip(first, second, strict=False))
    return next((n for n, (a, b) in pairs if a != b), min(len(first), len(second)))
