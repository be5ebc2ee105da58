"""Satellites that a receiver hears at its place, by rays in MuJoCo's world.

    symbol   name
    h_k      direction to satellite k, ENU, and 1 for the receiver's clock
    Q        inverse of the sum of h_k h_k^T over the satellites heard

Near buildings a receiver loses satellites on one side, and its errors grow in that direction. A
fixed error model cannot show that, so a ray is cast to each satellite: one behind a solid is not
heard. The dilution of precision is sqrt(Q_00 + Q_11) horizontally and sqrt(Q_22) vertically. Both
are taken relative to the whole sky, because the accuracy of a receiver already contains that.

A few rays are cast for each fix, in turn. A satellite that was lost is therefore heard again about
a second later, as a receiver needs time to track it again.

Source: Kaplan and Hegarty 2017, Understanding GPS/GNSS, section 11.2 (dilution of precision).
"""

from __future__ import annotations

import math

import numpy as np

from autonomy.jit import fields, kernel
from flightsim.environment.constellation import (
    LEAST_SATELLITES,
    Constellation,
    satellite_directions_enu,
    time_of_day_s,
)
from flightsim.environment.effects import Effects
from flightsim.plant.rays import cast_ray_m

_MOST_SATELLITES = 40
_RAYS_PER_FIX = 2
_NEAR_M = 40.0
"""Distance within which a solid that hides one satellite also reflects others."""
_WORST_DILUTION = 10.0
"""Bound of the relative dilution, which would be infinite for satellites in one plane."""

SKY_DTYPE = np.dtype(
    [
        *fields("is_on", "has_multipath", "n", "next", "n_heard", "has_looked", kind="i8"),
        *fields("open_horizontal", "open_vertical"),  # dilution under the whole sky
        *fields("horizontal", "vertical"),  # relative dilution here, 1 or more
        ("near_share", "f8"),  # satellites hidden by something near, of all
        ("direction_enu", "f8", (_MOST_SATELLITES, 3)),
        *fields("is_heard", "is_near", kind="i8", shape=(_MOST_SATELLITES,)),
        ("Q", "f8", (4, 8)),  # normal matrix and its inverse
        ("ray", "f8", 6),
    ],
    align=True,
)


def new_sky(
    constellations: tuple[Constellation, ...],
    latitude_deg: float,
    rng: np.random.Generator,
    effects: Effects,
) -> np.ndarray:
    """Return the sky at a random time of day, all of it heard, in an array of shape (1,).

    Args:
        constellations: Satellite systems that the receiver hears.
        latitude_deg: Latitude of the scene.
        rng: Random stream of the time.
        effects: Switches for hiding satellites behind solids and for reflecting others.
    """
    records = np.zeros(1, SKY_DTYPE)
    s = records[0]
    directions = satellite_directions_enu(constellations, latitude_deg, time_of_day_s(rng))
    n = min(len(directions), _MOST_SATELLITES)
    s["is_on"], s["has_multipath"] = effects.sky, effects.multipath
    s["n"] = s["n_heard"] = n
    s["direction_enu"][:n] = directions[:n]
    s["is_heard"][:n] = 1
    h = np.column_stack([directions[:n], np.ones(n)])
    variances = np.diag(np.linalg.inv(h.T @ h))
    s["open_horizontal"] = math.sqrt(variances[0] + variances[1])
    s["open_vertical"] = math.sqrt(variances[2])
    s["horizontal"] = s["vertical"] = 1.0
    return records


@kernel
def look_up(s: np.record, e: np.record, position_enu_m: np.ndarray) -> None:
    """Look for the next satellites from a true position; the first call looks for all of them.

    Satellites take turns, so one that was lost is heard again about a second later.

    Args:
        s: Record of the sky, which takes what is in view.
        e: Record of the index of the world's geoms.
        position_enu_m: Position of the antenna.
    """
    if s.is_on == 0:
        return
    n_rays = _RAYS_PER_FIX if s.has_looked == 1 else s.n
    s.has_looked = 1
    for _ in range(n_rays):
        _look_for(s, e, s.next, position_enu_m)
        s.next = (s.next + 1) % s.n
    s.n_heard = 0
    near = 0
    for k in range(s.n):
        s.n_heard += s.is_heard[k]
        near += s.is_near[k]
    s.near_share = near / s.n
    _dilute(s)


@kernel
def _look_for(s: np.record, e: np.record, k: int, position: np.ndarray) -> None:
    for i in range(3):
        s.ray[i], s.ray[3 + i] = position[i], s.direction_enu[k, i]
    distance_m = cast_ray_m(e, s)
    s.is_heard[k] = 1 if distance_m < 0.0 else 0
    s.is_near[k] = 1 if 0.0 <= distance_m < _NEAR_M else 0


@kernel
def _dilute(s: np.record) -> None:
    """Compute the relative dilution from the satellites that are heard."""
    s.horizontal = s.vertical = 1.0
    if s.n_heard == s.n or s.n_heard < LEAST_SATELLITES:
        return
    Q = s.Q
    Q[:] = 0.0
    for k in range(s.n):
        if s.is_heard[k] == 1:
            d = s.direction_enu[k]
            for i in range(4):
                for j in range(4):
                    Q[i, j] += (d[i] if i < 3 else 1.0) * (d[j] if j < 3 else 1.0)
    for i in range(4):
        Q[i, 4 + i] = 1.0
    _invert(Q)
    worst = _WORST_DILUTION
    horizontal = math.sqrt(max(Q[0, 4] + Q[1, 5], 0.0)) / s.open_horizontal
    vertical = math.sqrt(max(Q[2, 6], 0.0)) / s.open_vertical
    s.horizontal = min(max(horizontal, 1.0), worst)
    s.vertical = min(max(vertical, 1.0), worst)


@kernel
def _invert(Q: np.ndarray) -> None:
    """Invert a positive matrix by Gauss and Jordan.

    Args:
        Q: Shape (4, 8): the matrix on the left and the identity on the right; changed, so that the
            inverse is on the right.
    """
    for i in range(4):
        # The floor keeps a nearly singular geometry finite; `_WORST_DILUTION` then bounds it.
        pivot = max(Q[i, i], 1e-9)
        for j in range(8):
            Q[i, j] /= pivot
        for row in range(4):
            if row != i:
                factor = Q[row, i]
                for j in range(8):
                    Q[row, j] -= factor * Q[i, j]
