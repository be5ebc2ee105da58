"""Distances in a growing map, renewed only about the cells whose state has changed.

The state of a cell is whether it is not free and whether it is occupied. A change reaches `reach`
cells far, so cells are watched in blocks with that edge: a block that holds a change makes itself
and its 26 neighbours stale. Everything else keeps its distances, and cells that no image ever
showed are never touched.

Distances are exact from the centre of a cell to the surface of the nearest marked one, capped.
Along one axis, cells n apart are (2n - 1) / 2 cells apart from centre to surface, and squares add
up over the axes. Squares are whole numbers in single precision, so the result is the same in
whatever parts it is computed.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Int

from autonomy.jit import kernel

NOT_FREE, OCCUPIED = 1, 2
"""Bits of the state of a cell."""


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
def note_changes(
    evidence: Int[np.ndarray, "nx ny nz"],
    low: Int[np.ndarray, " 3"],
    high: Int[np.ndarray, " 3"],
    free_at: int,
    occupied_at: int,
    states: Int[np.ndarray, "nx ny nz"],
    stale: Int[np.ndarray, "a b c"],
    edge: int,
) -> bool:
    """Bring the states of the cells from `low` to before `high` up to date.

    Sets the bits that changed in the entry of `stale` for the block of the cell.

    Returns:
        Whether any state has changed.
    """
    is_any = False
    for i in range(low[0], high[0]):
        for j in range(low[1], high[1]):
            for k in range(low[2], high[2]):
                each = evidence[i, j, k]
                state = NOT_FREE * (each > free_at) + OCCUPIED * (each >= occupied_at)
                if state != states[i, j, k]:
                    stale[i // edge, j // edge, k // edge] |= state ^ states[i, j, k]
                    states[i, j, k] = state
                    is_any = True
    return is_any


@kernel
def renew(
    states: Int[np.ndarray, "nx ny nz"],
    stale: Int[np.ndarray, "a b c"],
    gauge: Gauge,
    needed: float,
    comfortable: float,
    distances: Distances,
) -> None:
    """Compute the distances anew in and beside all stale blocks, none of which stays stale.

    Args:
        states: State of each cell.
        stale: Bits of the states that changed in each block.
        gauge: What distances are measured by.
        needed: Room that the vehicle needs, in single precision.
        comfortable: Distance that a route is given where that much room was not seen free.
        distances: Changed in place.
    """
    edge = gauge.reach
    nx, ny, nz = states.shape
    for a in range(stale.shape[0]):
        for b in range(stale.shape[1]):
            bits, first, beyond = _stale_span(stale, a, b)
            if bits == 0:
                continue
            low = (a * edge, b * edge, first * edge)
            high = (min((a + 1) * edge, nx), min((b + 1) * edge, ny), min(beyond * edge, nz))
            if bits & OCCUPIED:
                _measure(states, OCCUPIED, low, high, gauge, distances.to_occupied)
            _count_roomy(distances, low, high, needed, -1)
            if bits & NOT_FREE:
                _measure(states, NOT_FREE, low, high, gauge, distances.to_not_free)
                _cut_at_border(distances.to_not_free, low, high, gauge)
            _count_roomy(distances, low, high, needed, 1)
            _find_route(distances, low, high, gauge, needed, comfortable)
    stale[:] = 0


@kernel
def renew_routes(
    gauge: Gauge, needed: float, comfortable: float, distances: Distances
) -> None:
    """Compute all of the route anew, because another room is needed; see `renew`."""
    high = distances.route.shape
    distances.n_roomy[:] = 0
    _count_roomy(distances, (0, 0, 0), high, needed, 1)
    _find_route(distances, (0, 0, 0), high, gauge, needed, comfortable)


@kernel
def _stale_span(stale: np.ndarray, a: int, b: int) -> tuple[int, int, int]:
    """Bits that changed in a column of blocks and those beside it, and the blocks concerned."""
    bits, first, beyond = 0, stale.shape[2], 0
    for i in range(max(a - 1, 0), min(a + 2, stale.shape[0])):
        for j in range(max(b - 1, 0), min(b + 2, stale.shape[1])):
            for k in range(stale.shape[2]):
                if stale[i, j, k]:
                    bits |= stale[i, j, k]
                    first, beyond = min(first, k - 1), max(beyond, k + 2)
    return bits, max(first, 0), min(beyond, stale.shape[2])


@kernel
def _measure(
    states: np.ndarray,
    bit: int,
    low: tuple[int, int, int],
    high: tuple[int, int, int],
    gauge: Gauge,
    distance: np.ndarray,
) -> None:
    """Distance to the nearest cell with a bit for the cells from `low` to before `high`."""
    nx, ny, _ = states.shape
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
            is_far[j - j_low] = _squares_along(
                states, bit, i, j, low[2], high[2], reach, squares, row[j - j_low]
            )
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
        least[k] = total if total < least[k] else least[k]


@kernel
def _squares_along(
    states: np.ndarray,
    bit: int,
    i: int,
    j: int,
    low: int,
    high: int,
    reach: int,
    squares: np.ndarray,
    along: np.ndarray,
) -> bool:
    """Squared distance to the nearest cell of a column with a bit; whether all are beyond reach."""
    most = len(squares) - 1
    nearest = most
    steps = most
    for k in range(max(low - reach, 0), high):
        steps = 0 if states[i, j, k] & bit else min(steps + 1, most)
        if k >= low:
            along[k - low] = squares[steps]
            nearest = min(nearest, steps)
    steps = most
    for k in range(min(high + reach, states.shape[2]) - 1, low - 1, -1):
        steps = 0 if states[i, j, k] & bit else min(steps + 1, most)
        if k < high:
            along[k - low] = min(along[k - low], squares[steps])
            nearest = min(nearest, steps)
    return nearest == most


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


def lengths(shape: tuple[int, ...], edge: int) -> tuple[int, ...]:
    """Number of blocks along each axis."""
    return tuple(-(-n // edge) for n in shape)


def unseen(shape: tuple[int, ...], cap_m: float) -> Distances:
    """Distances in a volume of which nothing was seen, without a route."""
    return Distances(
        to_not_free=np.zeros(shape, dtype=np.float32),
        to_occupied=np.full(shape, cap_m, dtype=np.float32),
        route=np.zeros(shape, dtype=np.float32),
        n_roomy=np.zeros(shape[2], dtype=np.int64),
    )
