"""CRC-32 as PX4 computes it over files and parameters: without inversions at either end."""

from __future__ import annotations

import zlib

_INVERTED = 0xFFFFFFFF


def crc32(data: bytes | bytearray, before: int = 0) -> int:
    """Return the checksum of data.

    Args:
        data: The bytes.
        before: Checksum of the bytes before them, to continue it.
    """
    return zlib.crc32(data, before ^ _INVERTED) ^ _INVERTED
