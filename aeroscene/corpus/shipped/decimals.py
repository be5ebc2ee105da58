"""Doubles as decimal integers: what was rounded takes few bits, and nothing is lost.

A double x becomes the integer nearest to x * 10^digits and the number of doubles that lie between
that decimal and x: none for a number that was rounded to as many digits. Integer arithmetic and one
division by a power of ten, which IEEE 754 defines to the last bit, give x back on every machine.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from jaxtyping import Float64, Int64

_EXACT_INTEGERS = float(2**53)
"""Integers below this are doubles, all of them."""


class Decimals(NamedTuple):
    """Doubles, split."""

    units: Int64[np.ndarray, " n"]
    """Multiples of 10^-digits."""
    steps: Int64[np.ndarray, " n"]
    """Doubles from there to the value, upwards."""


def split_doubles(values: Float64[np.ndarray, " n"], digits: int) -> Decimals:
    """Split finite doubles.

    Args:
        values: Anything finite; minus zero too.
        digits: Decimals to which most of them are rounded.
    """
    is_small = np.abs(values) < _EXACT_INTEGERS / float(10**digits)
    units = np.rint(np.where(is_small, values, 0.0) * float(10**digits)).astype(np.int64)
    return Decimals(units, _rank(values) - _rank(units / float(10**digits)))


def join_doubles(decimals: Decimals, digits: int) -> Float64[np.ndarray, " n"]:
    """The doubles that were split."""
    return _unrank(_rank(decimals.units / float(10**digits)) + decimals.steps)


def _rank(values: Float64[np.ndarray, " n"]) -> Int64[np.ndarray, " n"]:
    """Place of doubles among all doubles: neighbours differ by one, 0 is 0 and minus zero -1."""
    bits = np.ascontiguousarray(values).view(np.int64)
    return np.where(bits < 0, ~(bits & np.iinfo(np.int64).max), bits)


def _unrank(ranks: Int64[np.ndarray, " n"]) -> Float64[np.ndarray, " n"]:
    bits = np.where(ranks < 0, ~ranks | np.iinfo(np.int64).min, ranks)
    return bits.view(np.float64)
