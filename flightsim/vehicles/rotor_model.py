"""Rotors and air: from speed commands to the wrench on the body, once per physics step.

    symbol   name                                        unit
    w        rotor speed                                 rad/s
    v        hub velocity relative to the air, FLU       m/s
    v_perp   its part across the rotor axis (body x, y)  m/s

    thrust           kf w^2 (1 - |v_z| / axial_limit) along body z
    drag             -w k_drag v_perp, at the hub
    reaction torque  -spin c thrust about body z
    rolling moment   -w k_roll v_perp
    lag              first order on w, faster up than down
    fuselage         -(rho / 2) CdA_i |v_i| v_i along each body axis i

Sources: Furrer et al. 2016 (RotorS) for all but two; the axial loss is PX4's gazebo-classic
motor model; the fuselage is a box.
"""

from __future__ import annotations

import math

import numpy as np

from autonomy.estimation import DragModel
from autonomy.jit import fields, kernel
from autonomy.model.quadrotor import QuadrotorParams
from autonomy.rotation import matrix_from_quat
from autonomy.types import Vector3
from flightsim.environment.atmosphere import AIR_DENSITY_KGPM3

# Drag coefficient of a box across the wind (Hoerner 1965, Fluid-Dynamic Drag, chapter 3).
_BOX_DRAG_COEFFICIENT = 1.05

_COEFFICIENTS = (
    *("thrust_constant", "torque_per_thrust_m", "drag_coefficient"),
    *("rolling_moment_coefficient", "max_speed_radps"),
)
"""Fields of `RotorParams` that the record has too."""

ROTORS_DTYPE = np.dtype(
    [
        ("effectiveness", "f8", 4),  # 1 sound, 0 failed
        *fields("share_up", "share_down", shape=(4,)),  # of the way to the command in one step
        *fields("speed_radps", "spin", *_COEFFICIENTS, shape=(4,)),
        ("axial_limit_mps", "f8"),
        ("fuselage_drag", "f8", 3),  # rho / 2 CdA, kg/m
        *fields("wind_enu_mps", "air_velocity_flu_mps", shape=(3,)),
        *fields("force_flu_n", "torque_flu_nm", shape=(3,)),
        ("position_flu_m", "f8", (4, 3)),
        ("R", "f8", (3, 3)),
    ],
    align=True,
)


def new_rotors(
    quadrotor: QuadrotorParams, body_size_m: Vector3, *, dt_s: float, axial_limit_mps: float = 25.0
) -> np.ndarray:
    """Create rotors at rest, as one record in an array of shape (1,).

    Args:
        quadrotor: Parameters of the vehicle.
        body_size_m: Box of the fuselage, for its drag.
        dt_s: Length of a physics step.
        axial_limit_mps: Axial speed at which a rotor has no thrust; infinite for no such loss.
    """
    records = np.zeros(1, ROTORS_DTYPE)
    r = records[0]
    rotors = quadrotor.rotors
    r["effectiveness"] = 1.0
    for name in ("position_flu_m", "spin", *_COEFFICIENTS):
        r[name] = [getattr(rotor, name) for rotor in rotors]
    r["share_up"] = [1.0 - math.exp(-dt_s / rotor.time_constant_up_s) for rotor in rotors]
    r["share_down"] = [1.0 - math.exp(-dt_s / rotor.time_constant_down_s) for rotor in rotors]
    r["axial_limit_mps"] = axial_limit_mps
    r["fuselage_drag"] = _fuselage_drag(body_size_m)
    return records


def drag_model(quadrotor: QuadrotorParams, body_size_m: Vector3) -> DragModel:
    """Parameters of air resistance with which an estimator finds the wind."""
    mass = quadrotor.mass_kg
    x, y, _ = (_fuselage_drag(body_size_m) / mass).tolist()
    a, b, c, d = ((r.drag_coefficient / mass, r.thrust_constant / mass) for r in quadrotor.rotors)
    return DragModel(
        rotor_mps_per_rad=(a[0], b[0], c[0], d[0]),
        fuselage_per_m=(x, y),
        thrust_m=(a[1], b[1], c[1], d[1]),
    )


def _fuselage_drag(body_size_m: Vector3) -> np.ndarray:
    """Half the density times CdA of a box along each axis, kg/m."""
    x, y, z = body_size_m
    return np.array([y * z, x * z, x * y]) * (0.5 * AIR_DENSITY_KGPM3 * _BOX_DRAG_COEFFICIENT)


@kernel
def step_rotors(
    r: np.record,
    command_radps: np.ndarray,
    quat_wxyz: np.ndarray,
    velocity_enu_mps: np.ndarray,
    rate_flu_radps: np.ndarray,
    wrench: np.ndarray,
) -> None:
    """Advance the rotor speeds towards their commands by one step and write the resulting wrench.

    Args:
        r: Record of the rotors, changed.
        command_radps: Speed commands (4,), clipped to the rotors' range.
        quat_wxyz: True attitude.
        velocity_enu_mps: True velocity of the centre of mass.
        rate_flu_radps: True body rates.
        wrench: Result (6,): force and torque about the centre of mass, both in the world frame.
    """
    R, v = r.R, r.air_velocity_flu_mps
    matrix_from_quat(quat_wxyz, R)
    vx = velocity_enu_mps[0] - r.wind_enu_mps[0]
    vy = velocity_enu_mps[1] - r.wind_enu_mps[1]
    vz = velocity_enu_mps[2] - r.wind_enu_mps[2]
    for i in range(3):
        v[i] = R[0, i] * vx + R[1, i] * vy + R[2, i] * vz
        r.force_flu_n[i] = -r.fuselage_drag[i] * abs(v[i]) * v[i]
        r.torque_flu_nm[i] = 0.0
    for i in range(4):
        _follow(r, i, command_radps[i])
        _add_rotor(r, i, rate_flu_radps)
    F, M = r.force_flu_n, r.torque_flu_nm
    for i in range(3):
        wrench[i] = R[i, 0] * F[0] + R[i, 1] * F[1] + R[i, 2] * F[2]
        wrench[3 + i] = R[i, 0] * M[0] + R[i, 1] * M[1] + R[i, 2] * M[2]


@kernel
def _follow(r: np.record, i: int, command_radps: float) -> None:
    """First-order lag, exact for a command that is constant over the step."""
    command = min(max(command_radps, 0.0), r.max_speed_radps[i])
    if not math.isfinite(command_radps):
        command = 0.0
    change = command - r.speed_radps[i]
    r.speed_radps[i] += change * (r.share_up[i] if change >= 0.0 else r.share_down[i])


@kernel
def _add_rotor(r: np.record, i: int, rate: np.ndarray) -> None:
    w, v, hub = r.speed_radps[i], r.air_velocity_flu_mps, r.position_flu_m[i]
    vx = v[0] + rate[1] * hub[2] - rate[2] * hub[1]
    vy = v[1] + rate[2] * hub[0] - rate[0] * hub[2]
    vz = v[2] + rate[0] * hub[1] - rate[1] * hub[0]
    loss = min(max(1.0 - abs(vz) / r.axial_limit_mps, 0.0), 1.0)
    thrust = r.thrust_constant[i] * w * w * loss * r.effectiveness[i]
    fx = -w * r.drag_coefficient[i] * vx
    fy = -w * r.drag_coefficient[i] * vy
    roll = -w * r.rolling_moment_coefficient[i]
    F, M = r.force_flu_n, r.torque_flu_nm
    F[0] += fx
    F[1] += fy
    F[2] += thrust
    M[0] += hub[1] * thrust - hub[2] * fy + roll * vx
    M[1] += hub[2] * fx - hub[0] * thrust + roll * vy
    M[2] += hub[0] * fy - hub[1] * fx - r.spin[i] * r.torque_per_thrust_m[i] * thrust
