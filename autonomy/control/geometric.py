"""Geometric tracking control on SE(3).

    symbol        name                           here
    e_x, e_v      position and velocity error    reference minus estimate (Lee: the opposite)
    R, Omega      attitude, body rates           c.R, f.angular_rate_flu_radps
    R_d, Omega_d  commanded attitude and rates   c.R_cmd, c.rate_cmd_flu_radps
    e_R, e_W      attitude and rate error

Sources: Lee, Leok and McClamroch 2010, "Geometric tracking control of a quadrotor UAV on SE(3)",
eqs. (10), (11), (15), (16); integral action after Goodarzi, Lee and Lee 2013; body rates from jerk
and rotor drag after Faessler, Franchi and Scaramuzza 2018.
"""

from __future__ import annotations

import math

import numpy as np

from autonomy.jit import kernel

_MAX_INTEGRATED_VERTICAL_M = 0.3  # not while a vehicle on the ground lags behind its reference
_LEAST_VERTICAL_FRACTION = 0.35
_MAX_FEEDBACK_JERK_MPS3 = 60.0
_DISTURBANCE_RESPONSE_S = 0.15


@kernel
def demand_force(c: np.record, f: np.record) -> None:
    """Specific thrust (m/s^2, world) that tracks the reference: the bracket of eq. (15) over mass.

    Feedback, integral, tilt and thrust are limited; the vertical part keeps a floor, so that a
    fast descent never asks for a steep tilt.
    """
    force, e_x = c.force_enu_mps2, c.target
    estimate_acceleration(c, f)
    for i in range(3):
        e_x[i] = c.reference_position_enu_m[i] - f.position_enu_m[i]
        e_v = c.reference_velocity_enu_mps[i] - f.velocity_enu_mps[i]
        if c.is_free[i] == 1:
            e_x[i] = e_v = 0.0
        force[i] = c.position_gain * e_x[i] + c.velocity_gain * e_v
    _limit(force, c.max_feedback_mps2, c.max_feedback_mps2)
    _integrate(c, e_x)
    drag, along = rotor_drag(c), _along_thrust(c, c.reference_velocity_enu_mps)
    for i in range(3):
        v_perp = c.reference_velocity_enu_mps[i] - along * c.R[i, 2]
        held = c.integral_mps2[i] - c.disturbance_mps2[i]
        force[i] += c.reference_acceleration_enu_mps2[i] + drag * v_perp + held
    force[2] += c.gravity_mps2
    _limit_force(c)


@kernel
def estimate_acceleration(c: np.record, f: np.record) -> None:
    """Acceleration by the modelled rotors and what the IMU sees beyond them, such as wind.

    The first part has no delay and no noise, the second is low-passed and limited, since the ground
    is no disturbance to fly against.
    """
    thrust = 0.0
    for i in range(4):
        thrust += c.thrust_constant[i] * c.rotor_model_radps[i] * c.rotor_model_radps[i]
    drag, along = rotor_drag(c), _along_thrust(c, f.velocity_enu_mps)
    share = min(c.dt_s / _DISTURBANCE_RESPONSE_S, 1.0)
    for i in range(3):
        v_perp = f.velocity_enu_mps[i] - along * c.R[i, 2]
        model = thrust / c.mass_kg * c.R[i, 2] - drag * v_perp
        if i == 2:
            model -= c.gravity_mps2
        error = f.acceleration_enu_mps2[i] - model - c.disturbance_mps2[i]
        c.disturbance_mps2[i] += share * error
        c.acceleration_enu_mps2[i] = model + c.disturbance_mps2[i]
    _limit(c.disturbance_mps2, c.max_disturbance_mps2, 0.25 * c.max_disturbance_mps2)


@kernel
def _along_thrust(c: np.record, vector: np.ndarray) -> float:
    return c.R[0, 2] * vector[0] + c.R[1, 2] * vector[1] + c.R[2, 2] * vector[2]


@kernel
def rotor_drag(c: np.record) -> float:
    """Deceleration by the rotors' drag per speed across their axis, 1/s, at modelled speeds."""
    total = 0.0
    for i in range(4):
        total += c.drag_coefficient[i] * c.rotor_model_radps[i]
    return total / c.mass_kg


@kernel
def _limit_horizontal(vector: np.ndarray, limit: float) -> float:
    """Shorten the horizontal part to `limit`; returns its factor."""
    norm = math.sqrt(vector[0] * vector[0] + vector[1] * vector[1])
    factor = 1.0 if norm <= limit else limit / norm
    vector[0] *= factor
    vector[1] *= factor
    return factor


@kernel
def _limit(vector: np.ndarray, horizontal: float, vertical: float) -> None:
    _limit_horizontal(vector, horizontal)
    vector[2] = min(max(vector[2], -vertical), vertical)


@kernel
def _integrate(c: np.record, e_x: np.ndarray) -> None:
    """Integral action, while the demand before was met: what is left by small model errors."""
    if c.is_saturated == 1 or abs(e_x[2]) > _MAX_INTEGRATED_VERTICAL_M:
        return
    for i in range(3):
        c.integral_mps2[i] += c.integral_gain * e_x[i] * c.dt_s
    _limit(c.integral_mps2, c.max_integral_mps2, c.max_integral_mps2)


@kernel
def _limit_force(c: np.record) -> None:
    force = c.force_enu_mps2
    least = _LEAST_VERTICAL_FRACTION * c.gravity_mps2
    wanted = force[2]
    force[2] = min(max(wanted, least), c.max_thrust_mps2)
    room = math.sqrt(max(c.max_thrust_mps2 * c.max_thrust_mps2 - force[2] * force[2], 0.0))
    factor = _limit_horizontal(force, min(c.max_tilt_tangent * force[2], max(room, 1.0)))
    c.is_saturated = 1 if factor < 1.0 or wanted != force[2] else 0


@kernel
def command_attitude(c: np.record, f: np.record) -> None:
    """R_d and Omega_d from the demanded force, its derivative and the yaw: eq. (10)."""
    force, Rd = c.force_enu_mps2, c.R_cmd
    norm = math.sqrt(force[0] * force[0] + force[1] * force[1] + force[2] * force[2])
    for i in range(3):
        Rd[i, 2] = force[i] / norm
    cy, sy = math.cos(c.reference_yaw_rad), math.sin(c.reference_yaw_rad)
    # y_B = z_B x x_C over its norm, x_B = y_B x z_B
    yx = -Rd[2, 2] * sy
    yy = Rd[2, 2] * cy
    yz = Rd[0, 2] * sy - Rd[1, 2] * cy
    norm_y = math.sqrt(yx * yx + yy * yy + yz * yz)
    Rd[0, 1], Rd[1, 1], Rd[2, 1] = yx / norm_y, yy / norm_y, yz / norm_y
    Rd[0, 0] = Rd[1, 1] * Rd[2, 2] - Rd[2, 1] * Rd[1, 2]
    Rd[1, 0] = Rd[2, 1] * Rd[0, 2] - Rd[0, 1] * Rd[2, 2]
    Rd[2, 0] = Rd[0, 1] * Rd[1, 2] - Rd[1, 1] * Rd[0, 2]
    _demand_jerk(c, f)
    along_x, along_y = 0.0, 0.0
    for i in range(3):
        along_x += Rd[i, 0] * c.target[i]
        along_y += Rd[i, 1] * c.target[i]
    rate = c.rate_cmd_flu_radps
    rate[0] = -along_y / norm
    rate[1] = along_x / norm
    # from y_B . x_C = 0 at all times; x_B . x_C is norm_y
    y_C_on_y = -sy * Rd[0, 1] + cy * Rd[1, 1]
    x_C_on_z = cy * Rd[0, 2] + sy * Rd[1, 2]
    rate[2] = (c.reference_yaw_rate_radps * y_C_on_y + rate[0] * x_C_on_z) / norm_y


@kernel
def _demand_jerk(c: np.record, f: np.record) -> None:
    """Derivative of the demanded force, into `c.target`.

    Without that of the feedback the attitude lags by 2 zeta / wR behind it and the position loop
    rings.
    """
    drag = rotor_drag(c)
    for i in range(3):
        jerk = 0.0
        if c.is_free[i] == 0:
            e_v = c.reference_velocity_enu_mps[i] - f.velocity_enu_mps[i]
            e_a = c.reference_acceleration_enu_mps2[i] - c.acceleration_enu_mps2[i]
            jerk = c.position_gain * e_v + c.velocity_gain * e_a
            jerk = min(max(jerk, -_MAX_FEEDBACK_JERK_MPS3), _MAX_FEEDBACK_JERK_MPS3)
        drag_jerk = drag * c.reference_acceleration_enu_mps2[i]
        c.target[i] = c.reference_jerk_enu_mps3[i] + drag_jerk + jerk


@kernel
def attitude_torque(c: np.record, rate_flu_radps: np.ndarray) -> None:
    """Torque that turns R to R_d: eq. (16), without the derivative of Omega_d."""
    R, Rd, J = c.R, c.R_cmd, c.inertia_flu_kgm2
    Q = c.R_error
    for i in range(3):
        for j in range(3):
            Q[i, j] = R[0, i] * Rd[0, j] + R[1, i] * Rd[1, j] + R[2, i] * Rd[2, j]
    wd = c.rate_cmd_flu_radps
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        e_R = 0.5 * (Q[j, k] - Q[k, j])
        wd_body = Q[i, 0] * wd[0] + Q[i, 1] * wd[1] + Q[i, 2] * wd[2]
        e_W = rate_flu_radps[i] - wd_body
        turn = -c.attitude_gain[i] * e_R - c.angular_rate_gain[i] * e_W
        gyroscopic = (J[k] - J[j]) * rate_flu_radps[j] * rate_flu_radps[k]
        c.torque_flu_nm[i] = J[i] * turn + gyroscopic


@kernel
def rate_torque(c: np.record, rate_flu_radps: np.ndarray) -> None:
    """Torque that brings the body rates to `c.rate_cmd_flu_radps`."""
    J = c.inertia_flu_kgm2
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        error = c.rate_cmd_flu_radps[i] - rate_flu_radps[i]
        gyroscopic = (J[k] - J[j]) * rate_flu_radps[j] * rate_flu_radps[k]
        c.torque_flu_nm[i] = J[i] * c.rate_level_gain[i] * error + gyroscopic
