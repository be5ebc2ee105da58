"""Distances in a growing map, recomputed only around cells whose state has changed.

A marked cell matters up to `reach` cells away. Cells are therefore watched in blocks with that edge
(`autonomy.mapping.cell_states`): if a cell of a block changes, the block and its 26 neighbours are
recomputed. All other distances stay valid, and memory that no image reached is never touched.

Distances are exact from the centre of a cell to the surface of the nearest marked cell, capped.
Along one axis, cells n apart are (2n - 1) / 2 cells apart from centre to surface, and squares add
up over the axes. Squares are whole numbers in single precision, so that the result does not depend
on how the volume is divided into parts.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from autonomy.jit import kernel
from autonomy.mapping.cell_states import NOT_FREE, OCCUPIED, States


class Gauge(NamedTuple):
    """What distances are measured by, as arrays for kernels."""

    reach: int
    """Number of cells beyond which a marked cell does not count, and the edge of a block."""
    squares: np.ndarray
    """Square of the distance of cells n apart, in half cells, up to n = reach + 1."""
    metres: np.ndarray
    """Capped distance of each such square and sum of squares, m."""
    border_x: np.ndarray
    """Distance from the cells along each axis to the border of the volume, m."""
    border_y: np.ndarray
    border_z: np.ndarray


class Distances(NamedTuple):
    """Distances from each cell of a volume, m."""

    to_not_free: np.ndarray
    """To the nearest cell that is not free, or to the border of the volume."""
    to_occupied: np.ndarray
    """To the nearest occupied cell."""
    route: np.ndarray
    """What a search goes by that may pass unseen cells at a price; see `SeenMap.route_m`."""
    n_roomy: np.ndarray
    """Number of cells in each layer with enough room that was seen free."""


def gauge_for(shape: tuple[int, ...], resolution_m: float, cap_m: float) -> Gauge:
    """The gauge of a volume."""
    reach = math.ceil(cap_m / resolution_m + 0.5)
    squares = np.array([max(2 * n - 1, 0) ** 2 for n in range(reach + 2)], dtype=np.float32)
    sums = np.arange(3 * int(squares[-1]) + 1)
    metres = np.minimum(np.sqrt(sums) * 0.5 * resolution_m, cap_m).astype(np.float32)
    gaps = [(np.minimum(np.arange(n), n - 1 - np.arange(n)) + 0.5) * resolution_m for n in shape]
    x, y, z = (gap.astype(np.float32) for gap in gaps)
    return Gauge(reach, squares, metres, x, y, z)


@kernel
def renew(
    states: States,
    gauge: Gauge,
    needed: float,
    comfortable: float,
    distances: Distances,
) -> None:
    """Compute the distances anew in and beside all stale blocks, none of which stays stale.

    Args:
        states: State of each cell.
        gauge: What distances are measured by.
        needed: Room that the vehicle needs, in single precision.
        comfortable: Distance that a route is given where that much room was not seen free.
        distances: Changed in place.
    """
    changed = _with_neighbours(states.stale)
    states.stale[:] = 0
    edge = gauge.reach
    nx, ny, nz = states.bits.shape
    for a in range(changed.shape[0]):
        for b in range(changed.shape[1]):
            beyond = 0
            while beyond < changed.shape[2]:
                first, bits = beyond, 0
                while beyond < changed.shape[2] and changed[a, b, beyond]:
                    bits |= changed[a, b, beyond]
                    beyond += 1
                if first == beyond:
                    beyond += 1
                    continue
                low = (a * edge, b * edge, first * edge)
                high = (min((a + 1) * edge, nx), min((b + 1) * edge, ny), min(beyond * edge, nz))
                _renew_cells(states, bits, low, high, gauge, needed, comfortable, distances)


@kernel
def _renew_cells(
    states: States,
    bits: int,
    low: tuple[int, int, int],
    high: tuple[int, int, int],
    gauge: Gauge,
    needed: float,
    comfortable: float,
    distances: Distances,
) -> None:
    if bits & OCCUPIED:
        _measure(states.to_occupied, low, high, gauge, distances.to_occupied)
    if bits & NOT_FREE:
        _count_roomy(distances, low, high, needed, -1)
        _measure(states.to_not_free, low, high, gauge, distances.to_not_free)
        _cut_at_border(distances.to_not_free, low, high, gauge)
        _count_roomy(distances, low, high, needed, 1)
    _find_route(distances, low, high, gauge, needed, comfortable)


@kernel
def renew_routes(gauge: Gauge, needed: float, comfortable: float, distances: Distances) -> None:
    """Compute all of the route anew, because another room is needed; see `renew`."""
    high = distances.route.shape
    distances.n_roomy[:] = 0
    _count_roomy(distances, (0, 0, 0), high, needed, 1)
    _find_route(distances, (0, 0, 0), high, gauge, needed, comfortable)


@kernel
def _with_neighbours(stale: np.ndarray) -> np.ndarray:
    """Bits that changed in each block or in one of the 26 beside it."""
    changed = np.zeros_like(stale)
    for a in range(stale.shape[0]):
        for b in range(stale.shape[1]):
            for c in range(stale.shape[2]):
                if not stale[a, b, c]:
                    continue
                for i in range(max(a - 1, 0), min(a + 2, stale.shape[0])):
                    for j in range(max(b - 1, 0), min(b + 2, stale.shape[1])):
                        for k in range(max(c - 1, 0), min(c + 2, stale.shape[2])):
                            changed[i, j, k] |= stale[a, b, c]
    return changed


@kernel
def _measure(
    steps: np.ndarray,
    low: tuple[int, int, int],
    high: tuple[int, int, int],
    gauge: Gauge,
    distance: np.ndarray,
) -> None:
    """Distance to the nearest marked cell for the cells from `low` to before `high`.

    Args:
        steps: Number of cells to the nearest marked one of the same column.
        low: First cell.
        high: Cell beyond the last.
        gauge: What distances are measured by.
        distance: Changed in place.
    """
    nx, ny, _ = steps.shape
    reach, squares, metres = gauge.reach, gauge.squares, gauge.metres
    i_low, j_low = max(low[0] - reach, 0), max(low[1] - reach, 0)
    i_high, j_high = min(high[0] + reach, nx), min(high[1] + reach, ny)
    n = high[2] - low[2]
    row = np.empty((j_high - j_low, n), dtype=np.float32)
    is_far = np.empty(j_high - j_low, dtype=np.bool_)
    across = np.empty((i_high - i_low, high[1] - low[1], n), dtype=np.float32)
    is_across_far = np.empty((i_high - i_low, high[1] - low[1]), dtype=np.bool_)
    for i in range(i_low, i_high):
        for j in range(j_low, j_high):
            nearest = _square(steps[i, j, low[2] : high[2]], row[j - j_low])
            is_far[j - j_low] = nearest == squares[-1]
        for j in range(low[1], high[1]):
            least = across[i - i_low, j - low[1]]
            least[:] = row[j - j_low]
            is_all_far = is_far[j - j_low]
            for m in range(max(j - reach, j_low), min(j + reach + 1, j_high)):
                if m != j and not is_far[m - j_low]:
                    is_all_far = False
                    _lower(least, row[m - j_low], squares[abs(m - j)])
            is_across_far[i - i_low, j - low[1]] = is_all_far
    least = np.empty(n, dtype=np.float32)
    for i in range(low[0], high[0]):
        for j in range(low[1], high[1]):
            least[:] = across[i - i_low, j - low[1]]
            for m in range(max(i - reach, i_low), min(i + reach + 1, i_high)):
                if m != i and not is_across_far[m - i_low, j - low[1]]:
                    _lower(least, across[m - i_low, j - low[1]], squares[abs(m - i)])
            for k in range(n):
                distance[i, j, low[2] + k] = metres[int(least[k])]


@kernel
def _lower(least: np.ndarray, other: np.ndarray, extra: float) -> None:
    """Replace what is more than the other values and something added to all of them."""
    for k in range(len(least)):
        total = other[k] + extra
        least[k] = min(least[k], total)


@kernel
def _square(steps: np.ndarray, squares: np.ndarray) -> np.float32:
    """Squared distance, in half cells, of cells so many steps apart; the least of all."""
    least = np.float32(np.inf)
    for k in range(len(steps)):
        halves = np.float32(2) * np.float32(steps[k]) - np.float32(1)
        halves = max(np.float32(0), halves)
        squares[k] = halves * halves
        least = min(least, squares[k])
    return least


@kernel
def _cut_at_border(
    distance: np.ndarray, low: tuple[int, int, int], high: tuple[int, int, int], gauge: Gauge
) -> None:
    """Nothing outside the volume is free."""
    for i in range(low[0], high[0]):
        for j in range(low[1], high[1]):
            aside = min(gauge.border_x[i], gauge.border_y[j])
            for k in range(low[2], high[2]):
                distance[i, j, k] = min(distance[i, j, k], aside, gauge.border_z[k])


@kernel
def _find_route(
    distances: Distances,
    low: tuple[int, int, int],
    high: tuple[int, int, int],
    gauge: Gauge,
    needed: float,
    comfortable: float,
) -> None:
    for i in range(low[0], high[0]):
        for j in range(low[1], high[1]):
            aside = min(gauge.border_x[i], gauge.border_y[j])
            for k in range(low[2], high[2]):
                room = min(distances.to_occupied[i, j, k], aside, gauge.border_z[k])
                if room >= needed and distances.to_not_free[i, j, k] < needed:
                    room = min(room, np.float32(comfortable))
                distances.route[i, j, k] = room


@kernel
def _count_roomy(
    distances: Distances,
    low: tuple[int, int, int],
    high: tuple[int, int, int],
    needed: float,
    sign: int,
) -> None:
    for i in range(low[0], high[0]):
        for j in range(low[1], high[1]):
            for k in range(low[2], high[2]):
                distances.n_roomy[k] += sign * (distances.to_not_free[i, j, k] >= needed)


def unseen(shape: tuple[int, ...], cap_m: float) -> Distances:
    """Distances in a volume of which nothing was seen, without a route."""
    return Distances(
        to_not_free=np.zeros(shape, dtype=np.float32),
        to_occupied=np.full(shape, cap_m, dtype=np.float32),
        route=np.zeros(shape, dtype=np.float32),
        n_roomy=np.zeros(shape[2], dtype=np.int64),
    )
