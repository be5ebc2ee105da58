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
from autonomy.mapping.cell_states import FREE, OCCUPIED, States
from autonomy.pages import untouched_zeros


class Gauge(NamedTuple):
    """Constants by which distances are measured, as arrays for kernels."""

    reach: int
    """Number of cells up to which a marked cell matters, and the edge of a block."""
    squares: np.ndarray
    """Square of the distance of cells n apart, in half cells, up to n = reach + 1."""
    metres: np.ndarray
    """Capped distance of each sum of three such squares, m."""
    most: int
    """Least sum of squares whose distance is the cap."""
    border_x: np.ndarray
    """Distance from the cells along each axis to the border of the volume, m."""
    border_y: np.ndarray
    border_z: np.ndarray


class Distances(NamedTuple):
    """Distances from the centre of each cell of a volume."""

    to_not_free: np.ndarray
    """Distance to the nearest cell that is not free, or to the border of the volume, m."""
    near_occupied: np.ndarray
    """Square of the cap less that of the distance to the nearest occupied cell, in half cells.

    It is 0 if no occupied cell is as near as the cap, so that unseen space takes no memory.
    """
    route: np.ndarray
    """Distances for a search that may pass unseen cells at a price, see `SeenMap.route_in`; empty
    in a wide map, which computes them for the block of each search."""
    n_roomy: np.ndarray
    """Number of cells in each layer with enough room that was seen free; 0 in a wide map."""


def gauge_for(shape: tuple[int, ...], resolution_m: float, cap_m: float) -> Gauge:
    """Return the constants for a volume.

    Args:
        shape: Number of cells along each axis.
        resolution_m: Edge of a cell.
        cap_m: Greatest distance that is told from larger ones.
    """
    # A cell n apart is n - 1/2 edges away from centre to surface.
    reach = math.ceil(cap_m / resolution_m + 0.5)
    squares = np.array([max(2 * n - 1, 0) ** 2 for n in range(reach + 2)], dtype=np.float32)
    sums = np.arange(3 * int(squares[-1]) + 1)
    metres = np.minimum(np.sqrt(sums) * 0.5 * resolution_m, cap_m).astype(np.float32)
    # From the centre of each cell to the nearer end of its axis.
    gaps = [(np.minimum(np.arange(n), n - 1 - np.arange(n)) + 0.5) * resolution_m for n in shape]
    x, y, z = (gap.astype(np.float32) for gap in gaps)
    return Gauge(reach, squares, metres, int(np.argmax(metres == metres[-1])), x, y, z)


@kernel
def renew(
    states: States,
    gauge: Gauge,
    needed: float,
    comfortable: float,
    distances: Distances,
) -> None:
    """Compute the distances anew in and beside all stale blocks; afterwards none is stale.

    Blocks above each other that have changed are measured together, because their columns of cells
    are contiguous in memory.

    Args:
        states: State of each cell.
        gauge: What distances are measured by.
        needed: Room that the vehicle needs, m, rounded to single precision like the distances.
        comfortable: Distance of the route, m, in cells where that much room was not seen free.
        distances: Changed in place.
    """
    # A marked cell matters as far as a block is wide, so in the neighbouring blocks and no farther.
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
                # No block of this run has changed: go on behind the one that ended it.
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
    has_route = distances.route.size > 0
    if bits & OCCUPIED:
        _measure(states.near_occupied, True, low, high, gauge, distances)
    if bits & FREE:
        # The cells are taken out of the count before they change, and counted again afterwards.
        if has_route:
            _count_roomy(distances, low, high, needed, -1)
        _measure(states.to_not_free, False, low, high, gauge, distances)
        _cut_at_border(distances.to_not_free, low, high, gauge)
        if has_route:
            _count_roomy(distances, low, high, needed, 1)
    if has_route:
        _find_route(distances, low, high, gauge, needed, comfortable, distances.route, (0, 0, 0))


@kernel
def renew_routes(gauge: Gauge, needed: float, comfortable: float, distances: Distances) -> None:
    """Compute all of the route anew, because the vehicle needs another room; see `renew`."""
    high = distances.route.shape
    distances.n_roomy[:] = 0
    _count_roomy(distances, (0, 0, 0), high, needed, 1)
    first = (0, 0, 0)
    _find_route(distances, first, high, gauge, needed, comfortable, distances.route, first)


@kernel
def route_of_block(
    gauge: Gauge,
    needed: float,
    comfortable: float,
    distances: Distances,
    low: tuple[int, int, int],
    high: tuple[int, int, int],
) -> np.ndarray:
    """Return the route of the cells from `low` to before `high`; see `renew`.

    A wide map uses it for each search instead of a route of the whole volume, which would write to
    every page of it.
    """
    route = np.empty((high[0] - low[0], high[1] - low[1], high[2] - low[2]), dtype=np.float32)
    _find_route(distances, low, high, gauge, needed, comfortable, route, low)
    return route


@kernel
def _with_neighbours(stale: np.ndarray) -> np.ndarray:
    """Return the bits that changed in each block or in one of the 26 around it."""
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
    is_occupied: bool,
    low: tuple[int, int, int],
    high: tuple[int, int, int],
    gauge: Gauge,
    distances: Distances,
) -> None:
    """Measure the distance to the nearest marked cell for the cells from `low` to before `high`.

    Squared distances separate by axis: those along z are known from the columns' steps, and for
    each other axis the least sum of a neighbour's square and the square of the way to it is kept.

    Args:
        steps: Number of cells to the nearest marked one of the same column, or by how many it is
            nearer than reach + 1.
        is_occupied: Whether the marked cells are the occupied ones and `steps` the latter, else the
            cells that are not free.
        low: First cell.
        high: Cell beyond the last.
        gauge: What distances are measured by.
        distances: Changed in place.
    """
    nx, ny, _ = steps.shape
    reach, squares = gauge.reach, gauge.squares
    i_low, j_low = max(low[0] - reach, 0), max(low[1] - reach, 0)
    i_high, j_high = min(high[0] + reach, nx), min(high[1] + reach, ny)
    n = high[2] - low[2]
    row = np.empty((j_high - j_low, n), dtype=np.float32)
    is_far = np.empty(j_high - j_low, dtype=np.bool_)
    across = np.empty((i_high - i_low, high[1] - low[1], n), dtype=np.float32)
    is_across_far = np.empty((i_high - i_low, high[1] - low[1]), dtype=np.bool_)
    for i in range(i_low, i_high):
        for j in range(j_low, j_high):
            sign, zero = (-1, reach + 1) if is_occupied else (1, 0)
            nearest = _square(steps[i, j, low[2] : high[2]], sign, zero, row[j - j_low])
            # A column without a marked cell in reach lowers nothing and is passed over.
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
            if is_occupied:
                _keep_nearness(least, gauge, distances.near_occupied[i, j, low[2] : high[2]])
            else:
                _keep_metres(least, gauge, distances.to_not_free[i, j, low[2] : high[2]])


@kernel
def _keep_nearness(squares: np.ndarray, gauge: Gauge, nearness: np.ndarray) -> None:
    for k in range(len(squares)):
        nearness[k] = gauge.most - min(int(squares[k]), gauge.most)


@kernel
def _keep_metres(squares: np.ndarray, gauge: Gauge, metres: np.ndarray) -> None:
    for k in range(len(squares)):
        metres[k] = gauge.metres[int(squares[k])]


@kernel
def _lower(least: np.ndarray, other: np.ndarray, extra: float) -> None:
    """Lower each value to the other one at its place plus a constant, if that is less."""
    for k in range(len(least)):
        total = other[k] + extra
        least[k] = min(least[k], total)


@kernel
def _square(steps: np.ndarray, sign: int, zero: int, squares: np.ndarray) -> np.float32:
    """Compute the squared distance, in half cells, of cells that are `zero + sign * steps` apart.

    Returns:
        The least of all of them.
    """
    least = np.float32(np.inf)
    for k in range(len(steps)):
        halves = np.float32(2) * np.float32(zero + sign * steps[k]) - np.float32(1)
        # Within the marked cell itself the distance is 0, not minus one half.
        halves = max(np.float32(0), halves)
        squares[k] = halves * halves
        least = min(least, squares[k])
    return least


@kernel
def _cut_at_border(
    distance: np.ndarray, low: tuple[int, int, int], high: tuple[int, int, int], gauge: Gauge
) -> None:
    """Limit distances to those of the volume's border, because nothing outside is free."""
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
    route: np.ndarray,
    first: tuple[int, int, int],
) -> None:
    """Write the route from `low` to before `high` to an array whose first cell is `first`.

    The route is the distance to occupied cells. If there is enough room to those but not as much to
    unseen cells, it is less than comfortable, so that a path prefers space that was seen free.
    """
    for i in range(low[0], high[0]):
        for j in range(low[1], high[1]):
            aside = min(gauge.border_x[i], gauge.border_y[j])
            for k in range(low[2], high[2]):
                away = gauge.metres[gauge.most - distances.near_occupied[i, j, k]]
                room = min(away, aside, gauge.border_z[k])
                if room >= needed and distances.to_not_free[i, j, k] < needed:
                    room = min(room, np.float32(comfortable))
                route[i - first[0], j - first[1], k - first[2]] = room


@kernel
def _count_roomy(
    distances: Distances,
    low: tuple[int, int, int],
    high: tuple[int, int, int],
    needed: float,
    sign: int,
) -> None:
    """Add the cells with enough room to the count of their layer, or take them out of it."""
    for i in range(low[0], high[0]):
        for j in range(low[1], high[1]):
            for k in range(low[2], high[2]):
                distances.n_roomy[k] += sign * (distances.to_not_free[i, j, k] >= needed)


def unseen(shape: tuple[int, ...], gauge: Gauge, *, has_route: bool) -> Distances:
    """Return the distances in a volume of which nothing was seen.

    Args:
        shape: Number of cells along each axis.
        gauge: Constants of the volume.
        has_route: True to keep a route, which `renew_routes` must compute before its first use.
    """
    return Distances(
        to_not_free=untouched_zeros(shape, np.float32),
        near_occupied=untouched_zeros(shape, np.min_scalar_type(gauge.most)),
        route=untouched_zeros(shape if has_route else (0, 0, 0), np.float32),
        n_roomy=np.zeros(shape[2], dtype=np.int64),
    )
