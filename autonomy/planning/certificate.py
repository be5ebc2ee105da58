"""Proof that a trajectory is safe: exact distances and limits at samples, bounded in between.

Plans come from optimisers with tolerances, from primitives or from outside, and none of these is
trusted. The proof is a separate piece of code that sees only the trajectory, the obstacles and the
limits. Clearance is proved by marching (see `clearance`), limits from the flatness model (see
`demand`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from autonomy.model.quadrotor import QuadrotorParams
from autonomy.planning.bezier import control_points
from autonomy.planning.clearance import clearance_along
from autonomy.planning.demand import limit_peaks
from autonomy.planning.errors import CertificateError
from autonomy.planning.limits import FlightLimits
from autonomy.planning.moving_obstacles import NOTHING_MOVES, MovingObstacles
from autonomy.planning.obstacles import Obstacles
from autonomy.planning.trajectory import Trajectory, derivative_at

_TOLERANCE = 0.01
"""Share by which a limit may be passed: the optimiser's own tolerance, rounded up."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Certificate:
    """Proved bounds of a trajectory."""

    min_clearance_m: float
    """Lower bound of the distance from the vehicle's sphere to obstacles, along the whole
    trajectory."""
    max_speed_horizontal_mps: float
    max_speed_vertical_mps: float
    max_acceleration_mps2: float
    max_specific_thrust_mps2: float
    max_tilt_rad: float
    max_body_rate_radps: float
    max_yaw_rate_radps: float


def certify(
    trajectory: Trajectory,
    obstacles: Obstacles,
    radius_m: float,
    limits: FlightLimits,
    quadrotor: QuadrotorParams,
    *,
    margin_m: float = 0.0,
    moving: MovingObstacles = NOTHING_MOVES,
) -> Certificate:
    """Prove that a sphere about the trajectory is free of obstacles and that the limits hold.

    Args:
        trajectory: Trajectory to fly.
        obstacles: Static obstacles.
        radius_m: Radius of the vehicle's sphere.
        limits: Limits of the motion; thrust, tilt and body rate include the rotors' drag in still
            air.
        quadrotor: Mass, thrust and drag of the vehicle.
        margin_m: Distance that the sphere must keep.
        moving: Moving obstacles, predicted from the trajectory's beginning on.

    Returns:
        The proved bounds, for example the least clearance.

    Raises:
        CertificateError: If a bound is broken; names the first one, and where.
    """
    if not np.all(np.isfinite(trajectory.coefficients)):
        raise CertificateError("a coefficient is not finite; valid: finite numbers")
    clearance_m = _clearance(trajectory, obstacles, moving, radius_m, margin_m)
    peaks = limit_peaks(trajectory, quadrotor)
    yaw = trajectory.yaw
    # The heading is linear between its entries, so its rate is exact.
    turn_radps = float(np.abs(np.diff(yaw.yaw_rad)).max(initial=0.0)) / yaw.step_s
    certificate = Certificate(min_clearance_m=clearance_m, max_yaw_rate_radps=turn_radps, **peaks)
    most_thrust = limits.max_specific_thrust_mps2(quadrotor)
    for name, value, limit in (
        ("horizontal speed", certificate.max_speed_horizontal_mps, limits.speed_horizontal_mps),
        ("vertical speed", certificate.max_speed_vertical_mps, limits.speed_vertical_mps),
        ("horizontal acceleration", certificate.max_acceleration_mps2, limits.acceleration_mps2),
        ("thrust over mass", certificate.max_specific_thrust_mps2, most_thrust),
        ("tilt", certificate.max_tilt_rad, limits.tilt_rad),
        ("body rate", certificate.max_body_rate_radps, limits.body_rate_radps),
        ("yaw rate", certificate.max_yaw_rate_radps, limits.yaw_rate_radps),
    ):
        # "Not at most" instead of "above", so that NaN fails.
        if not value <= limit * (1 + _TOLERANCE):
            raise CertificateError(f"{name} reaches {value:.2f}; valid: at most {limit:.2f}")
    return certificate


def _clearance(
    trajectory: Trajectory,
    obstacles: Obstacles,
    moving: MovingObstacles,
    radius_m: float,
    margin_m: float,
) -> float:
    distance_m, at_s, index, is_moving = clearance_along(
        np.ascontiguousarray(trajectory.durations_s),
        np.ascontiguousarray(trajectory.coefficients),
        _speed_bounds(trajectory),
        obstacles.solids,
        moving.movers,
        radius_m + margin_m,
    )
    # "Not more" instead of "at most", so that NaN fails.
    if not distance_m > radius_m + margin_m:
        x, y, z = trajectory.positions(np.array([at_s]))[0]
        what = f"{'moving ' if is_moving else ''}obstacle {index}"
        when = f", {at_s:.1f} s ahead" if is_moving else ""
        raise CertificateError(
            f"clearance falls to {distance_m - radius_m:.2f} m beside {what} at "
            f"({x:.1f}, {y:.1f}, {z:.1f}) m{when}; valid: more than {margin_m:.2f} m"
        )
    return float(distance_m - radius_m) if math.isfinite(distance_m) else math.inf


def _speed_bounds(trajectory: Trajectory) -> Float[np.ndarray, " n"]:
    """Upper bound of the speed of each piece: the longest control point of its velocity."""
    t = trajectory.durations_s[:, None]
    ends = []
    for since in (np.zeros(len(t)), trajectory.durations_s):
        pieces = np.arange(len(t))
        place, velocity, acceleration = (
            derivative_at(trajectory.coefficients, pieces, since, n) for n in range(3)
        )
        ends.append((place, velocity, acceleration))
    velocity = control_points(ends[0], ends[1], t)[1]
    return np.max(np.linalg.norm(np.array(velocity), axis=2), axis=0)
