"""Straight legs, for take-off and landing and where there is no room for more."""

from __future__ import annotations

import math

import numpy as np

from autonomy.model.quadrotor import GRAVITY_MPS2, QuadrotorParams
from autonomy.planning.limits import FlightLimits
from autonomy.planning.planner import bounds_for
from autonomy.planning.trajectory import Trajectory, YawProfile, coefficients_from_nodes
from autonomy.planning.yaw import STEP_S
from autonomy.types import ZERO3, FlatReference, Vector3

_MIN_LEG_S = 0.5  # for a leg of nearly no length


def plan_leg(
    start_enu_m: Vector3,
    goal_enu_m: Vector3,
    yaw_rad: float,
    limits: FlightLimits,
    quadrotor: QuadrotorParams,
) -> Trajectory:
    """Plan a straight line from rest to rest, as fast as the limits allow; not certified.

    It serves take-off and landing, where the vehicle leaves or meets a surface on purpose, so that
    a certificate of clearance could not hold.

    Args:
        start_enu_m: Position at the start.
        goal_enu_m: Position at the end.
        yaw_rad: Heading, constant along the leg.
        limits: Limits of the motion.
        quadrotor: Mass, thrust and drag of the vehicle.

    Raises:
        LimitsError: If the limits contradict themselves.
    """
    bounds = bounds_for(FlatReference(position_enu_m=start_enu_m), limits, quadrotor)
    way = np.subtract(goal_enu_m, start_enu_m)
    across, up = math.hypot(way[0], way[1]), abs(way[2])
    # Rest to rest in degree 5 peaks at 15/8 of the mean speed and at 10/sqrt(3) way/T^2; its jerk
    # is the largest at the ends, 60 way/T^3, where thrust balances weight.
    duration_s = max(
        _MIN_LEG_S,
        15 / 8 * across / bounds.speed_horizontal_mps,
        15 / 8 * up / bounds.speed_vertical_mps,
        math.sqrt(10 / math.sqrt(3) * across / bounds.acceleration_horizontal_mps2),
        math.sqrt(10 / math.sqrt(3) * up / bounds.acceleration_vertical_mps2),
        math.cbrt(60 * across / (GRAVITY_MPS2 * limits.body_rate_radps)),
    )
    nodes = np.array([[start_enu_m, ZERO3, ZERO3], [goal_enu_m, ZERO3, ZERO3]])
    durations_s = np.array([duration_s])
    return Trajectory(
        durations_s=durations_s,
        coefficients=coefficients_from_nodes(nodes, durations_s),
        yaw=YawProfile(step_s=STEP_S, yaw_rad=np.array([yaw_rad])),
    )
