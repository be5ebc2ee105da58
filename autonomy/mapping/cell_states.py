"""State of each cell of a growing map, and the blocks of cells whose state has changed.

The state says whether a cell is not free and whether it is occupied. Each column also keeps, for
every cell, the number of steps to the nearest such cell above or below. Distances are measured from
these numbers, so that they must be recomputed only about columns that changed.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from jaxtyping import Int

from autonomy.jit import kernel
from autonomy.mapping.rays import FREE_AT, MOST_OCCUPIED, OCCUPIED_AT

NOT_FREE, OCCUPIED = 1, 2
"""Bits of the state of a cell."""


class States(NamedTuple):
    """State of each cell, and of its column."""

    bits: np.ndarray
    """`NOT_FREE` and `OCCUPIED`."""
    to_not_free: np.ndarray
    """Number of cells to the nearest one of the same column that is not free, up to reach + 1."""
    to_occupied: np.ndarray
    """The same to the nearest occupied one."""
    stale: np.ndarray
    """Bits that changed in each block of cells since distances were measured."""


def unseen_states(shape: tuple[int, ...], reach: int) -> States:
    """States in a volume of which nothing was seen; a block has an edge of `reach` cells."""
    return States(
        np.full(shape, NOT_FREE, dtype=np.uint8),
        np.zeros(shape, dtype=np.uint8),
        np.full(shape, reach + 1, dtype=np.uint8),
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
    """Bring the states of the cells from `low` to before `high` up to date.

    Returns:
        Whether any has changed.
    """
    bits, stale = states.bits, states.stale
    is_any = False
    for i in range(low[0], high[0]):
        for j in range(low[1], high[1]):
            changed = 0
            for k in range(low[2], high[2]):
                each = evidence[i, j, k]
                now = NOT_FREE * (each > FREE_AT) + OCCUPIED * (each >= OCCUPIED_AT)
                if now != bits[i, j, k]:
                    changed |= now ^ bits[i, j, k]
                    stale[i // reach, j // reach, k // reach] |= now ^ bits[i, j, k]
                    bits[i, j, k] = now
            first, beyond = low[2] - reach, high[2] + reach
            if changed & NOT_FREE:
                _count_steps(bits[i, j], NOT_FREE, first, beyond, reach, states.to_not_free[i, j])
            if changed & OCCUPIED:
                _count_steps(bits[i, j], OCCUPIED, first, beyond, reach, states.to_occupied[i, j])
            is_any = is_any or changed != 0
    return is_any


@kernel
def _count_steps(
    bits: np.ndarray, bit: int, first: int, beyond: int, reach: int, steps: np.ndarray
) -> None:
    """Number of cells to the nearest one of a column with a bit, for a part of the column."""
    first, beyond, most = max(first, 0), min(beyond, len(bits)), reach + 1
    n = most
    for k in range(max(first - reach, 0), beyond):
        n = 0 if bits[k] & bit else min(n + 1, most)
        if k >= first:
            steps[k] = n
    n = most
    for k in range(min(beyond + reach, len(bits)) - 1, first - 1, -1):
        n = 0 if bits[k] & bit else min(n + 1, most)
        if k < beyond:
            steps[k] = min(steps[k], n)


@kernel
def note_freed(
    evidence: Int[np.ndarray, "nx ny nz"],
    low: Int[np.ndarray, " 3"],
    high: Int[np.ndarray, " 3"],
    was_free: Int[np.ndarray, "nx ny nz"],
) -> None:
    """Note which cells from `low` to before `high` are free, and forget those that surely stand."""
    for i in range(low[0], high[0]):
        for j in range(low[1], high[1]):
            for k in range(low[2], high[2]):
                each = evidence[i, j, k]
                is_free = was_free[i, j, k] | (each <= FREE_AT)
                was_free[i, j, k] = is_free & (each < MOST_OCCUPIED)
