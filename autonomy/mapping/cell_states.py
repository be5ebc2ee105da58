"""State of each cell of a growing map, and the blocks of cells whose state has changed.

The state says whether a cell is not free and whether it is occupied. Each column also keeps, for
every cell, the number of steps to the nearest such cell above or below. Distances are measured from
these numbers, so that they must be recomputed only about columns that changed.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Int

from autonomy.jit import kernel
from autonomy.mapping.rays import FREE_AT, MOST_OCCUPIED, OCCUPIED_AT
from autonomy.pages import untouched_zeros

FREE, OCCUPIED = 1, 2
"""Bits of the state of a cell; a cell with neither is unknown."""


class States(NamedTuple):
    """State of each cell, and of its column.

    Zeros stand for a volume of which nothing was seen, because the pages of zeros that nobody
    writes take no memory, however large the volume is.
    """

    bits: np.ndarray
    """Sum of `FREE` and `OCCUPIED`, uint8 (nx, ny, nz)."""
    to_not_free: np.ndarray
    """Number of cells to the nearest one of the same column that is not free, at most reach + 1."""
    near_occupied: np.ndarray
    """The reach plus one, less the number of cells to the nearest occupied one of the column."""
    stale: np.ndarray
    """Bits that changed in each block of reach^3 cells since distances were measured."""


def unseen_states(shape: tuple[int, ...], reach: int) -> States:
    """Return the states of a volume of which nothing was seen.

    Args:
        shape: Number of cells along each axis.
        reach: Number of cells up to which a marked cell matters, and the edge of a block.
    """
    return States(
        untouched_zeros(shape, np.uint8),
        untouched_zeros(shape, np.uint8),
        untouched_zeros(shape, np.uint8),
        np.zeros([-(-n // reach) for n in shape], dtype=np.uint8),
    )


@kernel
def note_changes(
    evidence: Int[np.ndarray, "nx ny nz"],
    low: Int[np.ndarray, " 3"],
    high: Int[np.ndarray, " 3"],
    states: States,
    reach: int,
) -> bool:
    """Bring the states of a block of cells up to date with their evidence.

    Evidence changes with every image, but seldom passes one of the two thresholds. So only the
    columns of cells with another state than before are counted anew.

    Args:
        evidence: Evidence of each cell of the map.
        low: First cell of the block.
        high: Cell beyond the last one.
        states: Changed in place.
        reach: See `unseen_states`.

    Returns:
        True if the state of any cell has changed.
    """
    bits, stale = states.bits, states.stale
    is_any = False
    for i in range(low[0], high[0]):
        for j in range(low[1], high[1]):
            changed = 0
            for k in range(low[2], high[2]):
                each = evidence[i, j, k]
                now = FREE * (each <= FREE_AT) + OCCUPIED * (each >= OCCUPIED_AT)
                # Every block that is listed as stale costs a measurement of itself and 26 others.
                if now != bits[i, j, k]:
                    changed |= now ^ bits[i, j, k]
                    stale[i // reach, j // reach, k // reach] |= now ^ bits[i, j, k]
                    bits[i, j, k] = now
            # Cells as far as the reach above and below may now be nearer to a marked one.
            first, beyond = low[2] - reach, high[2] + reach
            if changed & FREE:
                steps = states.to_not_free[i, j]
                _count_steps(bits[i, j], FREE, 0, first, beyond, reach, steps)
            if changed & OCCUPIED:
                steps = states.near_occupied[i, j]
                _count_steps(bits[i, j], OCCUPIED, OCCUPIED, first, beyond, reach, steps)
                # Kept the other way round, so that zero stands for none.
                for k in range(max(first, 0), min(beyond, len(steps))):
                    steps[k] = reach + 1 - steps[k]
            is_any = is_any or changed != 0
    return is_any


@kernel
def _count_steps(
    bits: np.ndarray,
    bit: int,
    wanted: int,
    first: int,
    beyond: int,
    reach: int,
    steps: np.ndarray,
) -> None:
    """Count the cells to the nearest one of a column whose bit is as wanted, for a part of it.

    Two sweeps do it, up and down. Each begins `reach` cells outside the part, because the nearest
    cell may be there.
    """
    first, beyond, most = max(first, 0), min(beyond, len(bits)), reach + 1
    # Nothing is known before the sweep, so it begins as if the nearest cell were out of reach.
    n = most
    for k in range(max(first - reach, 0), beyond):
        n = 0 if bits[k] & bit == wanted else min(n + 1, most)
        if k >= first:
            steps[k] = n
    n = most
    for k in range(min(beyond + reach, len(bits)) - 1, first - 1, -1):
        n = 0 if bits[k] & bit == wanted else min(n + 1, most)
        if k < beyond:
            steps[k] = min(steps[k], n)


@kernel
def clear_ball(
    evidence: Int[np.ndarray, "nx ny nz"],
    low: Int[np.ndarray, " 3"],
    high: Int[np.ndarray, " 3"],
    centre: Float[np.ndarray, " 3"],
    radius: float,
    least_height: float,
) -> bool:
    """Make the cells that a ball meets free, except those that several images hit.

    Args:
        evidence: Changed in place.
        low: First cell of a block that holds the ball.
        high: Cell beyond the last one.
        centre: Centre of the ball in cells, from the lower corner of cell (0, 0, 0).
        radius: Radius in cells.
        least_height: Least height of a cell's middle over the ball's centre, in cells. The surface
            that a vehicle stands on is below it and stays as it is.

    Returns:
        True if any cell has changed.
    """
    is_any = False
    for i in range(low[0], high[0]):
        # Distances are from the centre to the nearest point of the cell, not to its middle.
        x = max(abs(i + 0.5 - centre[0]) - 0.5, 0.0)
        for j in range(low[1], high[1]):
            y = max(abs(j + 0.5 - centre[1]) - 0.5, 0.0)
            for k in range(low[2], high[2]):
                away = k + 0.5 - centre[2]
                z = max(abs(away) - 0.5, 0.0)
                is_met = away >= least_height and x * x + y * y + z * z < radius * radius
                if is_met and FREE_AT < evidence[i, j, k] < MOST_OCCUPIED:
                    evidence[i, j, k] = FREE_AT
                    is_any = True
    return is_any
