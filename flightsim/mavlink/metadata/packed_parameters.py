"""All parameters as one file, `@PARAM/param.pck`, which ground stations of ArduPilot read at once.

ArduPilot's AP_Filesystem_Param names what is in it: numbers little-endian, names without what they
share with the one before.
"""

from __future__ import annotations

import struct

from flightsim.mavlink.parameters import NamedParameters

PACKED_PARAMETERS = "@PARAM/param.pck"
_MAGIC = 0x671B
_HEADER = struct.Struct("<HHH")
"""Magic number, parameters in the file, parameters of the vehicle."""
_INT32, _FLOAT = 3, 4
_MOST_SHARED = 15


def packed_parameters(parameters: NamedParameters) -> bytes:
    """The file, from the parameters of now."""
    packed = _HEADER.pack(_MAGIC, len(parameters), len(parameters))
    before = ""
    for name in sorted(parameters):
        n_shared = min(_n_shared(before, name), len(name) - 1, _MOST_SHARED)
        rest = name[n_shared:].encode()
        is_integer, value = parameters.is_integer(name), parameters[name]
        kind = _INT32 if is_integer else _FLOAT
        packed += bytes((kind, n_shared | (len(rest) - 1) << 4)) + rest
        packed += struct.pack("<i", int(value)) if is_integer else struct.pack("<f", value)
        before = name
    return packed


def _n_shared(first: str, second: str) -> int:
    """Number of characters with which both begin."""
    pairs = enumerate(zip(first, second, strict=False))
    return next((n for n, (a, b) in pairs if a != b), min(len(first), len(second)))
