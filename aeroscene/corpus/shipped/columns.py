"""Columns of integers as bytes: small numbers in few bytes, bytes of one place side by side.

A column is its length, width in bytes and divisor, then the lowest byte of every number, then the
next; LZMA does the rest. Like everything here it gives the same bytes for the same numbers with the
same version of the compressor, and the same numbers for the same bytes with every version.
"""

from __future__ import annotations

import lzma
import struct
from typing import TypeVar

import msgspec
import numpy as np
from jaxtyping import Int64, UInt64

from aeroscene.corpus.shipped.decimals import Decimals

_HEAD = struct.Struct("<IBQ")
_LENGTH = struct.Struct("<I")
# Bytes of numbers, not text: which byte came before says nothing of the next.
_FILTERS = [
    {
        "id": lzma.FILTER_LZMA2,
        "preset": 9 | lzma.PRESET_EXTREME,
        "lc": 0,
        "lp": 0,
        "pb": 0,
        "dict_size": 1 << 20,  # bytes; a block is a fifth of it
    }
]

_T = TypeVar("_T")


class ColumnWriter:
    """Columns one after another, to be taken in the same order."""

    def __init__(self) -> None:
        self._parts: list[bytes] = []

    def add(self, numbers: Int64[np.ndarray, " n"]) -> None:
        """Append a column of integers."""
        divisor = _common_divisor(numbers)
        folded = _fold(numbers // divisor)
        width = (int(folded.max(initial=0)).bit_length() + 7) // 8
        planes = folded.astype("<u8").view(np.uint8).reshape(-1, 8)[:, :width].T
        self._parts += [_HEAD.pack(len(numbers), width, divisor), planes.tobytes()]

    def add_decimals(self, decimals: Decimals) -> None:
        """Append two columns: decimals, and the steps from there to the values."""
        self.add(decimals.units)
        self.add(decimals.steps)

    def add_plain(self, value: object) -> None:
        """Append anything that JSON holds."""
        data = msgspec.json.encode(value)
        self._parts += [_LENGTH.pack(len(data)), data]

    def to_bytes(self) -> bytes:
        """All that was appended, compressed."""
        return lzma.compress(b"".join(self._parts), format=lzma.FORMAT_RAW, filters=_FILTERS)


class ColumnReader:
    """Takes columns in the order in which they were appended; whether they were, nobody checks."""

    def __init__(self, data: bytes) -> None:
        self._data = lzma.decompress(data, format=lzma.FORMAT_RAW, filters=_FILTERS)
        self._at = 0

    @property
    def is_at_end(self) -> bool:
        """Whether all that was appended has been taken."""
        return self._at == len(self._data)

    def take(self) -> Int64[np.ndarray, " n"]:
        """The next column of integers."""
        count, width, divisor = _HEAD.unpack_from(self._data, self._at)
        start = self._at + _HEAD.size
        self._at = start + count * width
        planes = np.frombuffer(self._data, np.uint8, count * width, start).reshape(width, count)
        folded = np.zeros((count, 8), np.uint8)
        folded[:, :width] = planes.T
        return _unfold(folded.view("<u8").reshape(count)) * divisor

    def take_decimals(self) -> Decimals:
        """The next two columns."""
        return Decimals(self.take(), self.take())

    def take_plain(self, kind: type[_T]) -> _T:
        """The next thing in JSON."""
        (size,) = _LENGTH.unpack_from(self._data, self._at)
        start = self._at + _LENGTH.size
        self._at = start + size
        return msgspec.json.decode(self._data[start : self._at], type=kind)


def _common_divisor(numbers: Int64[np.ndarray, " n"]) -> int:
    magnitudes = np.abs(numbers)
    # The least integer has no magnitude.
    is_defined = magnitudes.min(initial=0) >= 0
    return max(1, int(np.gcd.reduce(magnitudes, initial=0))) if is_defined else 1


def _fold(numbers: Int64[np.ndarray, " n"]) -> UInt64[np.ndarray, " n"]:
    """0, -1, 1, -2, 2 ... as 0, 1, 2, 3, 4 ..."""
    return ((numbers << 1) ^ (numbers >> 63)).view(np.uint64)


def _unfold(folded: UInt64[np.ndarray, " n"]) -> Int64[np.ndarray, " n"]:
    return (folded >> np.uint64(1)).view(np.int64) ^ -(folded & np.uint64(1)).view(np.int64)
