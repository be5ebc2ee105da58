"""Clearance along a trajectory, proved between samples: march as far as each distance allows.

The vehicle moves at most S m/s, so from a point with distance D the distance is at least D - S s
for s seconds; and between two points with distances D and E that are s seconds apart it is at
least (D + E - S s) / 2. Steps are chosen so that this bound does not fall below the smallest one so
far, and where D is that small, it falls by at most half of `SPACING_M`. In open space a step covers
metres.

Source: conservative advancement, after Mirtich 1996, "Impulse-based dynamic simulation of rigid
body systems".
"""

from __future__ import annotations

import math

import numpy as np
from jaxtyping import Float

from autonomy.jit import kernel
from autonomy.planning.moving_obstacles import Movers, distance_to_movers
from autonomy.planning.solids import Solids, gap_to_sphere, plane_between

SPACING_M = 0.04
"""Shortest step: between two points clearance cannot fall by more than half of it."""
_FAR_M = 1e3


@kernel
def clearance_along(
    durations: Float[np.ndarray, " n"],
    coefficients: Float[np.ndarray, "n 6 3"],
    speeds: Float[np.ndarray, " n"],
    solids: Solids,
    movers: Movers,
    enough: float,
) -> tuple[float, float, int, bool]:
    """Lower bound of the distance from a trajectory to obstacles.

    Args:
        durations: Durations of the pieces, s.
        coefficients: Coefficients of rising powers of time, m.
        speeds: Upper bound of the speed of each piece, m/s.
        solids: Static obstacles.
        movers: Moving obstacles.
        enough: Distance below which the march ends, m.

    Returns:
        The bound in m, the time of it, the obstacle there, and whether that one moves.
    """
    bound, at, nearest, is_moving = np.inf, 0.0, -1, False
    mover_speed = movers.growth
    for i in range(len(movers.positions)):
        v = movers.velocities[i]
        mover_speed = max(mover_speed, movers.growth + math.sqrt(v[0] ** 2 + v[1] ** 2 + v[2] ** 2))
    since = 0.0
    for k in range(len(durations)):
        speed = max(speeds[k], 1e-3) + (mover_speed if len(movers.positions) > 0 else 0.0)
        t = 0.0
        d, i, moves = _distance(coefficients[k], t, since, solids, movers)
        while True:
            if d < bound:
                bound, at, nearest, is_moving = d, since + t, i, moves
            if bound < enough or t >= durations[k]:
                break
            step = min(max(SPACING_M, d - bound) / speed, durations[k] - t)
            t = t + step if t + step < durations[k] - 1e-9 else durations[k]
            e, j, moves_then = _distance(coefficients[k], t, since, solids, movers)
            between = 0.5 * (d + e - speed * step)
            if between < bound:
                bound, at, nearest, is_moving = between, since + t, j, moves_then
            d, i, moves = e, j, moves_then
        if bound < enough:
            break
        since += durations[k]
    return bound, at, nearest, is_moving


@kernel
def _distance(
    c: Float[np.ndarray, "6 3"], t: float, since: float, solids: Solids, movers: Movers
) -> tuple[float, int, bool]:
    x = c[0, 0] + t * (c[1, 0] + t * (c[2, 0] + t * (c[3, 0] + t * (c[4, 0] + t * c[5, 0]))))
    y = c[0, 1] + t * (c[1, 1] + t * (c[2, 1] + t * (c[3, 1] + t * (c[4, 1] + t * c[5, 1]))))
    z = c[0, 2] + t * (c[1, 2] + t * (c[2, 2] + t * (c[3, 2] + t * (c[4, 2] + t * c[5, 2]))))
    best, nearest = _FAR_M, -1
    for i in range(len(solids.centers)):
        if gap_to_sphere(x, y, z, i, solids) < best:
            d = plane_between(x, y, z, i, solids)[0]
            if d < best:
                best, nearest = d, i
    d, i = distance_to_movers(x, y, z, since + t, movers)
    if d < best:
        return d, i, True
    return best, nearest, False
