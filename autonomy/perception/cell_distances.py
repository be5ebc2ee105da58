"""Distances to static surfaces, cached by cells of space.

An exact distance costs microseconds a point, and an image has tens of thousands of points, many of
them where earlier images had some. A hash table with open addressing finds the cells; its hash is
Teschner's for cells of space.

Source: Teschner et al. 2003, "Optimized spatial hashing for collision detection of deformable
objects".
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from jaxtyping import Float, Int

from autonomy.jit import kernel

StaticDistance = Callable[[Float[np.ndarray, "n 3"]], Float[np.ndarray, " n"]]
"""Function from points, ENU (n, 3), to the signed distance to the nearest surface known to stand,
m."""

# A power of two, so that a mask replaces the remainder. At half full, chains stay short.
_N_SLOTS = 1 << 18
_MOST_FILLED = _N_SLOTS // 2
_BITS = 21  # of each coordinate in a key: a million cells either way
_LOW_BITS = (1 << _BITS) - 1
_EMPTY = -1


class CellDistances:
    """Distances at the middles of cells, computed once and kept for a while.

    The error is at most half the diagonal of a cell.
    """

    def __init__(self, cell_m: float, remember_s: float) -> None:
        """Create an empty cache; entries are dropped after `remember_s`, because a map may grow."""
        self._cell_m = cell_m
        self._remember_s = remember_s
        self._keys = np.full(_N_SLOTS, _EMPTY, dtype=np.int64)
        self._distance_m = np.zeros(_N_SLOTS)
        self._n_filled = 0
        self._since_s = -np.inf

    def forget_old(self, time_s: float) -> None:
        """Drop all entries if they are too old or too many."""
        if time_s - self._since_s >= self._remember_s or self._n_filled > _MOST_FILLED:
            self._keys[:] = _EMPTY
            self._n_filled = 0
            self._since_s = time_s

    def at(
        self, points_enu_m: Float[np.ndarray, "n 3"], static_distance_m: StaticDistance
    ) -> Float[np.ndarray, " n"]:
        """Distance at the middle of the cell that holds each point, m.

        Args:
            points_enu_m: Points.
            static_distance_m: Function for the cells that are not cached yet.
        """
        # A full table would make the search for a free slot endless; points beyond it are computed
        # exactly.
        points = points_enu_m[: _N_SLOTS - 1 - self._n_filled]
        slot, new_slot, new_middles = find_cells(points, self._cell_m, self._keys)
        if len(new_slot):
            self._distance_m[new_slot] = static_distance_m(new_middles)
            self._n_filled += len(new_slot)
        distance_m = self._distance_m[slot]
        if len(points) == len(points_enu_m):
            return distance_m
        return np.concatenate([distance_m, static_distance_m(points_enu_m[len(points) :])])


@kernel
def find_cells(
    points: Float[np.ndarray, "n 3"], cell: float, keys: Int[np.ndarray, " s"]
) -> tuple[Int[np.ndarray, " n"], Int[np.ndarray, " k"], Float[np.ndarray, "k 3"]]:
    """Slots of the cells of points, the new slots among them, and the middles of the new cells.

    The new cells are added to the table of keys, one for each slot. The table must not become full.
    """
    n = len(points)
    slots = np.empty(n, dtype=np.int64)
    new_slots = np.empty(n, dtype=np.int64)
    middles = np.empty((n, 3))
    n_new = 0
    mask = len(keys) - 1
    for i in range(n):
        x, y, z = (
            math.floor(points[i, 0] / cell),
            math.floor(points[i, 1] / cell),
            math.floor(points[i, 2] / cell),
        )
        a, b, c = x & _LOW_BITS, y & _LOW_BITS, z & _LOW_BITS
        key = (a << (2 * _BITS)) | (b << _BITS) | c
        slot = ((a * 73856093) ^ (b * 19349663) ^ (c * 83492791)) & mask
        while keys[slot] != key and keys[slot] != _EMPTY:
            slot = (slot + 1) & mask
        if keys[slot] == _EMPTY:
            keys[slot] = key
            new_slots[n_new] = slot
            middles[n_new, 0] = (x + 0.5) * cell
            middles[n_new, 1] = (y + 0.5) * cell
            middles[n_new, 2] = (z + 0.5) * cell
            n_new += 1
        slots[i] = slot
    return slots, new_slots[:n_new], middles[:n_new]
