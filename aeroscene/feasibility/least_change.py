"""Least squares under linear inequalities: how little must change so that all demands are met.

minimise    sum_v weight_v x_v^2 / 2
subject to  A x >= b

| symbol | name | unit |
|---|---|---|
| x | changes: displacements and changes of half extents | m |
| A, b | demands, one a row; rows are of unit scale | -, m |
| lambda | multipliers, one a row | m |

Demands that contradict each other must not drive x away, so each yields to its multiplier by a
compliance: a row may stay short by `compliance * lambda`.

Source: Hildreth 1957, "A quadratic programming procedure": coordinate ascent on the dual.
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Float, Int

from autonomy.jit import kernel

COMPLIANCE = 2e-4
_TOLERANCE_M = 5e-5


def least_change(
    demands: Float[np.ndarray, "k v"],
    bounds: Float[np.ndarray, " k"],
    weights: Float[np.ndarray, " v"],
    sweeps: int,
) -> Float[np.ndarray, " v"]:
    """The least x with `demands @ x >= bounds`; each row is looked at `sweeps` times at most.

    Weights are those of the squares, each above zero.
    """
    rows, columns = np.nonzero(demands)
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
    """Rows in compressed form; see `least_change`."""
    x = np.zeros(len(mobility))
    multiplier = np.zeros(len(bounds))
    stiffness = np.zeros(len(bounds))
    for k in range(len(bounds)):
        for e in range(first[k], first[k + 1]):
            stiffness[k] += values[e] * values[e] * mobility[columns[e]]
    for _ in range(sweeps):
        largest = 0.0
        for k in range(len(bounds)):
            if stiffness[k] == 0.0:
                continue
            short = bounds[k] - COMPLIANCE * multiplier[k]
            for e in range(first[k], first[k + 1]):
                short -= values[e] * x[columns[e]]
            step = max(short / (stiffness[k] + COMPLIANCE), -multiplier[k])
            multiplier[k] += step
            for e in range(first[k], first[k + 1]):
                x[columns[e]] += values[e] * step * mobility[columns[e]]
            largest = max(largest, abs(step) * stiffness[k])
        if largest < _TOLERANCE_M:
            break
    return x
