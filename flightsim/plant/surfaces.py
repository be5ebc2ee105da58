"""Ground below and ceiling above the rotors, found by rays in MuJoCo's world at 50 Hz.

Ground effect needs the distance below each rotor, but a ray for each rotor at each step would
dominate the cost of a flight. One ray from the centre along the rotor axis measures the distance to
the surface, and with it the time before which no look is worthwhile. Only near a surface does each
rotor cast a ray of its own, so that a rotor over the edge of a roof has no ground effect.
"""

from __future__ import annotations

import math

import numpy as np

from autonomy.jit import fields, kernel
from autonomy.rotation import matrix_from_quat
from flightsim.environment.effects import Effects
from flightsim.plant.rays import cast_ray_m
from flightsim.vehicles.air.ground import GROUND_REACH, ground_share
from flightsim.vehicles.air.inflow import CEILING_REACH, ceiling_ratio

_FASTEST_MPS = 10.0
"""Speed at which a surface may approach between two looks."""
_LONGEST_WAIT_TICKS = 50
"""Ticks after which even a far surface is searched again, because one may appear from the side."""
_MARGIN_M = 0.5
"""Distance beyond the reach of the effect at which rotors begin to cast rays of their own."""

SURFACES_DTYPE = np.dtype(
    [
        *fields("has_ground", "has_ceiling", kind="i8"),
        *fields("next_ground_tick", "next_ceiling_tick", kind="i8"),
        ("ray", "f8", 6),  # origin and direction in the world
    ],
    align=True,
)


def new_surfaces(effects: Effects) -> np.ndarray:
    """Return a search that begins at once, in an array of shape (1,)."""
    records = np.zeros(1, SURFACES_DTYPE)
    records["has_ground"], records["has_ceiling"] = effects.ground, effects.ceiling
    return records


@kernel
def feel_surfaces(s: np.record, e: np.record, r: np.record, qpos: np.ndarray) -> None:
    """Update the ground and ceiling effects of the rotors if a look is due.

    Args:
        s: `SURFACES_DTYPE`, changed.
        e: Engine of the plant.
        r: Record of the rotors, changed.
        qpos: True pose (7,): position ENU, attitude wxyz.
    """
    matrix_from_quat(qpos[3:7], r.R)
    if s.has_ground == 1 and e.tick >= s.next_ground_tick:
        reach = GROUND_REACH * r.radius_m
        s.next_ground_tick = _look(s, e, r, qpos[0:3], -1.0, reach)
    if s.has_ceiling == 1 and e.tick >= s.next_ceiling_tick:
        reach = CEILING_REACH * r.radius_m
        s.next_ceiling_tick = _look(s, e, r, qpos[0:3], 1.0, reach)


@kernel
def _look(
    s: np.record, e: np.record, r: np.record, position: np.ndarray, sign: float, reach_m: float
) -> int:
    """Look up (sign 1) or down (-1) along the rotor axis; return the tick of the next look."""
    for k in range(3):
        s.ray[k], s.ray[3 + k] = position[k], sign * r.R[k, 2]
    distance_m = _distance_m(s, e)
    is_near = distance_m < reach_m + _MARGIN_M
    for i in range(r.n_rotors):
        hub, height_m = r.position_flu_m[i], math.inf
        if is_near:
            for k in range(3):
                turned = r.R[k, 0] * hub[0] + r.R[k, 1] * hub[1] + r.R[k, 2] * hub[2]
                s.ray[k] = position[k] + turned
            height_m = _distance_m(s, e)
        _set_effect(r, i, sign, height_m, reach_m)
    wait = (distance_m - reach_m - _MARGIN_M) / _FASTEST_MPS * e.tick_hz
    return e.tick + int(min(max(wait, 1.0), float(_LONGEST_WAIT_TICKS)))


@kernel
def _set_effect(r: np.record, i: int, sign: float, distance_m: float, reach_m: float) -> None:
    """Set the effect on rotor i of a surface at a distance along its axis."""
    if sign < 0.0:
        is_felt = distance_m < reach_m
        r.ground_share[i] = (
            ground_share(distance_m, r.radius_m, r.neighbour_m, r.opposite_m) if is_felt else 0.0
        )
    else:
        r.ceiling_ratio[i] = ceiling_ratio(distance_m, r.radius_m)


@kernel
def _distance_m(s: np.record, e: np.record) -> float:
    """Return the distance along the ray to the first surface outside the vehicle, or infinity."""
    distance_m = cast_ray_m(e, s)
    return math.inf if distance_m < 0.0 else distance_m
