"""Proof that a trajectory is safe: exact distances and limits at samples, bounded in between."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from autonomy.model.quadrotor import GRAVITY_MPS2, QuadrotorParams
from autonomy.planning.errors import CertificateError
from autonomy.planning.limits import FlightLimits
from autonomy.planning.obstacles import Obstacles
from autonomy.planning.trajectory import Trajectory

SPACING_M = 0.04
"""Distance between samples: between two of them clearance cannot fall by more than half of it."""
MAX_STEP_S = 0.02
_TOLERANCE = 0.01
"""Share by which a sampled limit may be passed: the optimiser's own tolerance, rounded up."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Certificate:
    """What was proved."""

    min_clearance_m: float
    """Lower bound of the distance from the vehicle's sphere to obstacles, along the whole way."""
    max_speed_horizontal_mps: float
    max_speed_vertical_mps: float
    max_acceleration_mps2: float
    max_specific_thrust_mps2: float
    max_tilt_rad: float


def certify(
    trajectory: Trajectory,
    obstacles: Obstacles,
    radius_m: float,
    limits: FlightLimits,
    quadrotor: QuadrotorParams,
    *,
    margin_m: float = 0.0,
) -> Certificate:
    """Prove that a sphere about the trajectory is free of obstacles and that the limits hold.

    Raises:
        CertificateError: Naming the first thing that is wrong, and where.
    """
    times = _sample_times(trajectory)
    clearance_m = _clearance(trajectory, times, obstacles, radius_m, margin_m)
    velocity = trajectory.derivatives(times, 1)
    acceleration = trajectory.derivatives(times, 2)
    thrust = acceleration + np.array([0.0, 0.0, GRAVITY_MPS2])
    across = np.hypot(thrust[:, 0], thrust[:, 1])
    certificate = Certificate(
        min_clearance_m=clearance_m,
        max_speed_horizontal_mps=float(np.hypot(velocity[:, 0], velocity[:, 1]).max()),
        max_speed_vertical_mps=float(np.abs(velocity[:, 2]).max()),
        max_acceleration_mps2=float(across.max()),
        max_specific_thrust_mps2=float(np.linalg.norm(thrust, axis=1).max()),
        max_tilt_rad=float(np.arctan2(across, thrust[:, 2]).max()),
    )
    for name, value, limit in (
        ("horizontal speed", certificate.max_speed_horizontal_mps, limits.speed_horizontal_mps),
        ("vertical speed", certificate.max_speed_vertical_mps, limits.speed_vertical_mps),
        ("horizontal acceleration", certificate.max_acceleration_mps2, limits.acceleration_mps2),
        (
            "thrust over mass",
            certificate.max_specific_thrust_mps2,
            limits.max_specific_thrust_mps2(quadrotor),
        ),
        ("tilt", certificate.max_tilt_rad, limits.tilt_rad),
    ):
        if value > limit * (1 + _TOLERANCE):
            raise CertificateError(f"{name} reaches {value:.2f}; valid: at most {limit:.2f}")
    return certificate


def _clearance(
    trajectory: Trajectory,
    times: np.ndarray,
    obstacles: Obstacles,
    radius_m: float,
    margin_m: float,
) -> float:
    positions = trajectory.positions(times)
    distance_m, nearest = obstacles.signed_distance(positions)
    gaps_m = np.linalg.norm(np.diff(positions, axis=0), axis=1)
    # Speed times step bounds the way between samples even where the path bends back.
    speeds = np.linalg.norm(trajectory.derivatives(times, 1), axis=1)
    way_m = max(float(gaps_m.max()), float(speeds.max()) * float(np.diff(times).max()))
    clearance_m = distance_m - radius_m - way_m / 2
    worst = int(np.argmin(clearance_m))
    if clearance_m[worst] <= margin_m:
        x, y, z = positions[worst]
        raise CertificateError(
            f"clearance falls to {clearance_m[worst]:.2f} m beside obstacle {nearest[worst]} at "
            f"({x:.1f}, {y:.1f}, {z:.1f}) m; valid: more than {margin_m:.2f} m"
        )
    return float(clearance_m[worst])


def _sample_times(trajectory: Trajectory) -> np.ndarray:
    coarse = np.arange(0.0, trajectory.duration_s, MAX_STEP_S)
    speed = float(np.linalg.norm(trajectory.derivatives(coarse, 1), axis=1).max())
    step_s = min(MAX_STEP_S, SPACING_M / max(speed, 1e-6))
    count = max(2, math.ceil(trajectory.duration_s / step_s) + 1)
    return np.linspace(0.0, trajectory.duration_s, count)
