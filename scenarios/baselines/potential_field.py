"""Artificial potential field: a goal attracts a point of unit mass, every solid near it repels it.

    x, v    position and velocity of the point, m, m/s
    x_d     goal, m
    rho     distance of the vehicle's sphere about the point to a solid, m

    a = -k_v (v - nu v_d)
        + sum of  eta (1 / rho - 1 / rho_0) / rho^2 grad rho  over the solids with rho < rho_0
    v_d = k_p / k_v (x_d - x),  nu = min(1, v_max / |v_d|)

The first term is a damped spring to the goal, whose pull is limited so that the speed stays below
v_max. The second is minus the gradient of eta / 2 (1 / rho - 1 / rho_0)^2, summed over the solids.
If the two cancel before the goal is reached, the point rests in a local minimum, and nothing in the
method leads out of it. That is the well-known weakness that this baseline stands for.

Source: Khatib 1986, "Real-time obstacle avoidance for manipulators and mobile robots": attraction
with a limit of speed, and the potential that he calls FIRAS about each primitive of the obstacles.
His forces are unlimited; here the acceleration is, because a quadrotor's is.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from autonomy.jit import kernel
from autonomy.planning.solids import Solids, gap_to_sphere, plane_between

_LEAST_RHO_M = 0.02
"""Distance below which the repulsion stops growing, which also avoids a division by zero."""


@dataclass(frozen=True, kw_only=True, slots=True)
class FieldCfg:
    """Gains of the field; docs/campaigns.md explains how they were chosen."""

    stiffness_per_s2: float = 1.0
    """Pull of the goal for each metre of distance, k_p."""
    damping_per_s: float = 2.0
    """Deceleration for each metre per second of the velocity's error, k_v."""
    speed_mps: float = 1.5
    """Greatest demanded speed, v_max."""
    repulsion_m4ps2: float = 0.25
    """Gain of the repulsion, eta."""
    influence_m: float = 1.0
    """Distance below which a solid repels, rho_0."""
    acceleration_mps2: float = 4.0
    """Greatest acceleration of the point."""


def acceleration(
    position_enu_m: Float[np.ndarray, " 3"],
    velocity_enu_mps: Float[np.ndarray, " 3"],
    goal_enu_m: Float[np.ndarray, " 3"],
    solids: Solids,
    radius_m: float,
    cfg: FieldCfg,
) -> Float[np.ndarray, " 3"]:
    """Return the acceleration of the point in the field, ENU, m/s^2.

    Args:
        position_enu_m: Position of the point.
        velocity_enu_mps: Velocity of the point.
        goal_enu_m: Goal that attracts it.
        solids: Obstacles that repel it.
        radius_m: Radius of the vehicle's sphere.
        cfg: Gains.

    Returns:
        The acceleration, whose norm is at most `cfg.acceleration_mps2`.
    """
    pace = cfg.stiffness_per_s2 / cfg.damping_per_s
    wanted = pace * (goal_enu_m - position_enu_m)
    share = min(1.0, cfg.speed_mps / max(float(np.linalg.norm(wanted)), 1e-9))
    attraction = -cfg.damping_per_s * (velocity_enu_mps - share * wanted)
    away = repulsion(position_enu_m, solids, radius_m, cfg.influence_m, cfg.repulsion_m4ps2)
    total = attraction + away
    return total * min(1.0, cfg.acceleration_mps2 / max(float(np.linalg.norm(total)), 1e-9))


@kernel
def repulsion(
    point: Float[np.ndarray, " 3"], solids: Solids, radius: float, influence: float, gain: float
) -> Float[np.ndarray, " 3"]:
    """Return the sum of the accelerations away from all solids within the influence distance.

    Args:
        point: Position of the point, ENU, m.
        solids: Obstacles.
        radius: Radius of the vehicle's sphere, m.
        influence: Distance below which a solid repels, m.
        gain: Gain of the repulsion, m^4/s^2.
    """
    x, y, z = point[0], point[1], point[2]
    total = np.zeros(3)
    for i in range(len(solids.centers)):
        # The bounding sphere first, because the exact distance costs far more.
        if gap_to_sphere(x, y, z, i, solids) - radius >= influence:
            continue
        distance, nx, ny, nz, _ = plane_between(x, y, z, i, solids)
        rho = max(distance - radius, _LEAST_RHO_M)
        if rho < influence:
            size = gain * (1.0 / rho - 1.0 / influence) / (rho * rho)
            total += size * np.array([nx, ny, nz])
    return total
