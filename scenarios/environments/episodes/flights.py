"""Flights of episodes: the part of each vehicle's history that verdicts need.

A verdict needs the history at every control tick, but thousands of vehicles fly for minutes. So
only some fields are kept, and only from a second before the first contact on, in one ring that all
vehicles share.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from jaxtyping import Bool

from flightsim.plant import Fleet
from scenarios.trials.limits import LIMITS

_NAMES = (
    *("time_us", "is_touching", "position_true_enu_m", "velocity_true_enu_mps"),
    *("angular_rate_true_flu_radps", "quat_true_wxyz", "rotor_speed_radps"),
)
_WORD = np.dtype(np.uint64)
"""Number of bytes of every number in a history."""
_FREE_S = 2.0 * LIMITS.lift_off_s
"""Time without contact that is kept: it proves that the vehicle has flown."""


class Flights:
    """Rows of control ticks of n vehicles since each one's start, by the names of a history.

    A vehicle's rows begin a second before its first contact. The verdict on a flight does not
    depend on what was before, except for the number of rows.
    """

    def __init__(self, fleet: Fleet, step_s: float) -> None:
        """Watch a fleet.

        Args:
            fleet: The vehicles.
            step_s: Time of an advance.
        """
        history = fleet.history
        n, self._n_ticks = history.shape
        # As plain words, all wanted fields of all vehicles are copied in one call.
        self._words = history.view(_WORD).reshape(n, self._n_ticks, -1)
        self._dtype = np.dtype([(name, history.dtype[name]) for name in _NAMES])
        places: Any = history.dtype.fields
        self._columns = np.concatenate(
            [
                places[name][1] // _WORD.itemsize
                + np.arange(history.dtype[name].itemsize // _WORD.itemsize)
                for name in _NAMES
            ]
        )
        self._n_free = math.ceil(_FREE_S / step_s) + 1
        self._n_taken = 0
        self._begun = np.zeros(n, dtype=int)
        self._n_kept = np.zeros(n, dtype=int)
        self._has_touched = np.zeros(n, dtype=bool)
        # A ring: advance k is in place k % len.
        self._ring = np.empty((self._n_free + 1, n, self._n_ticks, len(self._columns)), _WORD)

    def begin(self, index: int) -> None:
        """Begin a vehicle's flight with the next advance."""
        self._begun[index], self._n_kept[index] = self._n_taken, 0
        self._has_touched[index] = False

    def take(self, is_flying: Bool[np.ndarray, " n"], is_touching: Bool[np.ndarray, " n"]) -> None:
        """Record the last advance of all vehicles.

        Args:
            is_flying: True for vehicles whose flights go on.
            is_touching: True for vehicles that touched something in it.
        """
        place = self._ring[self._n_taken % len(self._ring)]
        np.take(self._words, self._columns, axis=2, out=place, mode="clip")
        self._n_taken += 1
        self._n_kept += is_flying
        self._has_touched |= is_touching
        # Before the first contact, rows older than `_FREE_S` are forgotten.
        np.minimum(self._n_kept, self._n_free, out=self._n_kept, where=~self._has_touched)
        if self._n_kept.max() >= len(self._ring):
            self._enlarge()

    def of(self, index: int, rest: Sequence[np.ndarray] = ()) -> tuple[np.ndarray, int]:
        """Return the rows of a vehicle's flight, and the number of earlier rows that are not kept.

        Args:
            index: Number of the vehicle.
            rest: Results of `last` for advances that followed those of all vehicles.
        """
        n_kept = int(self._n_kept[index])
        kept = np.arange(self._n_taken - n_kept, self._n_taken) % len(self._ring)
        n_dropped = self._n_taken - int(self._begun[index]) - n_kept
        words = self._ring[kept, index].reshape(-1, len(self._columns))
        if rest:
            words = np.concatenate([words, *rest])
        return np.ndarray(len(words), self._dtype, words), n_dropped * self._n_ticks

    def last(self, index: int) -> np.ndarray:
        """Return the rows of a vehicle's last advance without their names, for `of`."""
        return self._words[index].take(self._columns, axis=1)

    def _enlarge(self) -> None:
        """Make room for twice as many advances."""
        n = len(self._ring)
        larger = np.empty((2 * n, *self._ring.shape[1:]), _WORD)
        kept = np.arange(max(0, self._n_taken - n), self._n_taken)
        larger[kept % (2 * n)] = self._ring[kept % n]
        self._ring = larger
