"""Least squares under linear inequalities: the least change that meets all demands.

minimise    sum_v weight_v x_v^2 / 2
subject to  A x >= b

| symbol | name | unit |
|---|---|---|
| x | changes: displacements and changes of half extents | m |
| A, b | demands, one a row; rows are of unit scale | -, m |
| lambda | multipliers, one a row | m |

Demands that contradict each other must not drive x away, so each yields to its multiplier by a
compliance: a row may stay short by `compliance * lambda`. A general QP solver would report such a
problem as infeasible, but the projection needs the best compromise.

Source: Hildreth 1957, "A quadratic programming procedure": coordinate ascent on the dual.
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Float, Int

from autonomy.jit import kernel

COMPLIANCE = 2e-4  # a row may stay short by this for each metre of its multiplier
_TOLERANCE_M = 5e-5  # changes of a sweep below this end the search


def least_change(
    demands: Float[np.ndarray, "k v"],
    bounds: Float[np.ndarray, " k"],
    weights: Float[np.ndarray, " v"],
    sweeps: int,
) -> Float[np.ndarray, " v"]:
    """Find the least x with `demands @ x >= bounds`.

    Args:
        demands: Matrix A; most of its entries are zero.
        bounds: Vector b, m.
        weights: Weights of the squares, each above zero.
        sweeps: Most passes over all rows.

    Returns:
        Changes x. Rows that contradict others may stay short.
    """
    rows, columns = np.nonzero(demands)
    # Rows in compressed form: their entries lie one after another.
    first = np.searchsorted(rows, np.arange(len(demands) + 1))
    return ascend(first, columns, demands[rows, columns], bounds, 1.0 / weights, sweeps)


@kernel
def ascend(
    first: Int[np.ndarray, " k1"],
    columns: Int[np.ndarray, " nz"],
    values: Float[np.ndarray, " nz"],
    bounds: Float[np.ndarray, " k"],
    mobility: Float[np.ndarray, " v"],
    sweeps: int,
) -> Float[np.ndarray, " v"]:
    """Solve with rows in compressed form; see `least_change`."""
    x = np.zeros(len(mobility))
    multiplier = np.zeros(len(bounds))
    stiffness = np.zeros(len(bounds))
    for k in range(len(bounds)):
        for e in range(first[k], first[k + 1]):
            stiffness[k] += values[e] * values[e] * mobility[columns[e]]
    for _ in range(sweeps):
        largest = 0.0
        for k in range(len(bounds)):
            # A row without unknowns cannot be met by any change.
            if stiffness[k] == 0.0:
                continue
            short = bounds[k] - COMPLIANCE * multiplier[k]
            for e in range(first[k], first[k + 1]):
                short -= values[e] * x[columns[e]]
            # Multipliers stay at zero or above: a demand only pushes in its own direction.
            step = max(short / (stiffness[k] + COMPLIANCE), -multiplier[k])
            multiplier[k] += step
            for e in range(first[k], first[k + 1]):
                x[columns[e]] += values[e] * step * mobility[columns[e]]
            largest = max(largest, abs(step) * stiffness[k])
        if largest < _TOLERANCE_M:
            break
    return x
