"""Geometric tracking control on SE(3): from a reference to thrust and torque.

The law works on rotation matrices instead of Euler angles, so that it has no singularity at steep
attitudes. The position loop demands a force, the force and the yaw give an attitude, and the
attitude loop gives a torque. The error of the attitude differs from Lee's: it grows up to 180
degrees, so that a vehicle upside down is turned over with full torque.

    symbol        name                           here
    e_x, e_v      position and velocity error    reference minus estimate (Lee: the opposite)
    R, Omega      attitude, body rates           c.R, x.angular_rate_flu_radps
    R_d, Omega_d  commanded attitude and rates   c.R_cmd, c.rate_cmd_flu_radps
    e_R, e_W      attitude and rate error        c.attitude_error

Sources: Lee, Leok and McClamroch 2010, "Geometric tracking control of a quadrotor UAV on SE(3)",
eqs. (10), (11), (15), (16); integral action after Goodarzi, Lee and Lee 2013; body rates from jerk
and rotor drag after Faessler, Franchi and Scaramuzza 2018; tilt before yaw after Brescianini and
D'Andrea 2018, "Tilt-prioritized quadrocopter attitude control", section IV.
"""

from __future__ import annotations

import math

import numpy as np

from autonomy.jit import kernel

_MAX_INTEGRATED_VERTICAL_M = 0.3  # not while a vehicle on the ground lags behind its reference
_LEAST_VERTICAL_FRACTION = 0.35  # of the weight; the tilt is limited further below twice this
_LEAST_TILT_SHARE = 0.05  # of the greatest tilt, which remains at the least thrust
_MAX_FEEDBACK_RATE_RADPS = 6.0  # limit of the body rates that position errors may demand
_DISTURBANCE_RESPONSE_S = 0.1  # time constant of the low pass on the IMU's part
_PRESSING_FRACTION = 0.7  # of the weight: the demand is below it on the ground
_LEANING_M = 0.12  # leaning on the legs of one side it is up to 0.1 m higher than at rest
_UPSIDE_DOWN_COSINE = 1e-4  # of half the tilt: nearer to 180 degrees its axis is rounding error


@kernel
def demand_force(c: np.record, x: np.record) -> None:
    """Demand the specific thrust that tracks the reference: the bracket of eq. (15) over mass.

    The result is `c.force_enu_mps2` in m/s^2, world axes. Feedback, integral, tilt and thrust are
    limited. The vertical part has a floor, so that a fast descent never demands a steep tilt. If
    the thrust is not enough, it carries the weight first.
    """
    force, e_x = c.force_enu_mps2, c.position_error_enu_m
    estimate_acceleration(c, x)
    for i in range(3):
        e_x[i] = c.reference_position_enu_m[i] - x.position_enu_m[i]
        e_v = c.reference_velocity_enu_mps[i] - x.velocity_enu_mps[i]
        if c.is_free[i] == 1:
            e_x[i] = e_v = 0.0
        force[i] = c.position_gain * e_x[i] + c.velocity_gain * e_v
    wanted = force[2]
    factor = _limit(force, c.max_feedback_mps2, c.max_feedback_mps2)
    is_vertical = wanted != force[2]
    _integrate(c, e_x)
    drag, along = rotor_drag(c), _along_thrust(c, c.reference_velocity_enu_mps)
    for i in range(3):
        v_perp = c.reference_velocity_enu_mps[i] - along * c.R[i, 2]
        held = c.integral_mps2[i] - c.disturbance_mps2[i]
        force[i] += c.reference_acceleration_enu_mps2[i] + drag * v_perp + held
    force[2] += c.gravity_mps2
    _limit_force(c, c.gravity_mps2 + c.integral_mps2[2] - c.disturbance_mps2[2])
    # `_limit_force` has set both flags; the limited feedback is added to them, for the integral and
    # the jerk of the next tick.
    if factor < 1.0:
        c.is_limited[0] = 1
    if is_vertical:
        c.is_limited[1] = 1


@kernel
def estimate_acceleration(c: np.record, x: np.record) -> None:
    """Estimate the acceleration by the modelled rotors plus a part that only the IMU sees.

    The rotors' part has no delay and no noise. The rest, such as wind, is low-passed and limited.
    While the vehicle may press down on its legs, nothing is compensated horizontally, because
    leaning against whatever holds the legs would tip it over. Little thrust alone does not mean
    that it stands: in an updraught it may have free space below, so the room below counts too.
    """
    thrust = 0.0
    for i in range(c.n_rotors):
        thrust += c.thrust_constant[i] * c.rotor_model_radps[i] * c.rotor_model_radps[i]
    drag, along = rotor_drag(c), _along_thrust(c, x.velocity_enu_mps)
    has_little = c.force_enu_mps2[2] < _PRESSING_FRACTION * c.gravity_mps2
    is_pressing = has_little and c.room_below_m < _LEANING_M
    share = min(c.dt_s / _DISTURBANCE_RESPONSE_S, 1.0)
    for i in range(3):
        v_perp = x.velocity_enu_mps[i] - along * c.R[i, 2]
        model = thrust / c.mass_kg * c.R[i, 2] - drag * v_perp
        if i == 2:
            model -= c.gravity_mps2
        error = x.acceleration_enu_mps2[i] - model - c.disturbance_mps2[i]
        if is_pressing:
            error = -c.disturbance_mps2[i] if i < 2 else 0.0
        c.disturbance_mps2[i] += share * error
        c.acceleration_enu_mps2[i] = model + c.disturbance_mps2[i]
    _limit_horizontal(c.disturbance_mps2, c.max_disturbance_mps2)
    # Downwards the air costs thrust; upwards the ground may soon carry the vehicle.
    least, most = -0.25 * c.max_disturbance_mps2, 0.125 * c.max_disturbance_mps2
    c.disturbance_mps2[2] = min(max(c.disturbance_mps2[2], least), most)


@kernel
def _along_thrust(c: np.record, vector: np.ndarray) -> float:
    return c.R[0, 2] * vector[0] + c.R[1, 2] * vector[1] + c.R[2, 2] * vector[2]


@kernel
def rotor_drag(c: np.record) -> float:
    """Deceleration by rotor drag per speed across the rotors' axis, at modelled speeds, 1/s."""
    total = 0.0
    for i in range(c.n_rotors):
        total += c.drag_coefficient[i] * c.rotor_model_radps[i]
    return total / c.mass_kg


@kernel
def _limit_horizontal(vector: np.ndarray, limit: float) -> float:
    """Shorten the horizontal part to `limit` and return its factor."""
    norm = math.sqrt(vector[0] * vector[0] + vector[1] * vector[1])
    factor = 1.0 if norm <= limit else limit / norm
    vector[0] *= factor
    vector[1] *= factor
    return factor


@kernel
def _limit(vector: np.ndarray, horizontal: float, vertical: float) -> float:
    """Shorten the horizontal and the vertical part; return the factor of the horizontal one."""
    vector[2] = min(max(vector[2], -vertical), vertical)
    return _limit_horizontal(vector, horizontal)


@kernel
def _integrate(c: np.record, e_x: np.ndarray) -> None:
    """Integrate the position error that model errors leave, unless the last demand was limited.

    Otherwise the integral would wind up while the vehicle cannot follow.
    """
    if c.is_limited[0] + c.is_limited[1] > 0 or abs(e_x[2]) > _MAX_INTEGRATED_VERTICAL_M:
        return
    for i in range(3):
        c.integral_mps2[i] += c.integral_gain * e_x[i] * c.dt_s
    _limit(c.integral_mps2, c.max_integral_mps2, c.max_integral_mps2)


@kernel
def _limit_force(c: np.record, weight_mps2: float) -> None:
    """Limit the vertical part of the force, then the tilt and the thrust.

    With little thrust the tilt is limited to a few degrees, so that a vehicle that presses down on
    its legs stays on them. `weight_mps2` is the thrust that neither climbs nor sinks.
    """
    force = c.force_enu_mps2
    least = _LEAST_VERTICAL_FRACTION * c.gravity_mps2
    wanted = force[2]
    force[2] = min(max(wanted, least), c.max_thrust_mps2)
    tangent = c.max_tilt_tangent * min(max(force[2] / least - 1.0, _LEAST_TILT_SHARE), 1.0)
    factor = _limit_horizontal(force, tangent * force[2])
    factor *= _share_thrust(c, min(weight_mps2, force[2]))
    c.is_limited[0] = 1 if factor < 1.0 else 0
    c.is_limited[1] = 1 if wanted != force[2] else 0


@kernel
def _share_thrust(c: np.record, carried_mps2: float) -> float:
    """Shrink the demand beyond the carried weight to the available thrust; return the factor.

    Climbing and holding the place shrink alike, so that neither a climb in a downdraught nor a gust
    takes all the thrust from the other.
    """
    force, most = c.force_enu_mps2, c.max_thrust_mps2
    square = force[0] * force[0] + force[1] * force[1]
    if square + force[2] * force[2] <= most * most:
        return 1.0
    # The root s of |(s x, s y, carried + s climb)| = most.
    climb = force[2] - carried_mps2
    a, half_b = square + climb * climb, carried_mps2 * climb
    room = max(most * most - carried_mps2 * carried_mps2, 0.0)
    share = (math.sqrt(half_b * half_b + a * room) - half_b) / a
    force[2] = carried_mps2 + share * climb
    # Up to 1 m/s^2 of the horizontal demand always stays, even if climbing takes all the thrust.
    least = min(1.0 / math.sqrt(square), 1.0) if square > 0.0 else 1.0
    share = max(share, least)
    force[0] *= share
    force[1] *= share
    return share


@kernel
def command_attitude(c: np.record, x: np.record) -> None:
    """Compute R_d and Omega_d from the demanded force, its derivative and the yaw: eq. (10).

    The results are `c.R_cmd` and `c.rate_cmd_flu_radps`. Rates come from the derivative of the
    force and not from differences of attitudes, which would amplify noise.
    """
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
    _demand_jerk(c, x, _MAX_FEEDBACK_RATE_RADPS * norm)
    along_x, along_y = 0.0, 0.0
    for i in range(3):
        along_x += Rd[i, 0] * c.demanded_jerk_enu_mps3[i]
        along_y += Rd[i, 1] * c.demanded_jerk_enu_mps3[i]
    rate = c.rate_cmd_flu_radps
    rate[0] = -along_y / norm
    rate[1] = along_x / norm
    # from y_B . x_C = 0 at all times; x_B . x_C is norm_y
    y_C_on_y = -sy * Rd[0, 1] + cy * Rd[1, 1]
    x_C_on_z = cy * Rd[0, 2] + sy * Rd[1, 2]
    rate[2] = (c.reference_yaw_rate_radps * y_C_on_y + rate[0] * x_C_on_z) / norm_y


@kernel
def _demand_jerk(c: np.record, x: np.record, max_feedback_mps3: float) -> None:
    """Write the derivative of the demanded force to `c.demanded_jerk_enu_mps3`.

    It includes the derivative of the feedback. Otherwise the attitude lags behind the feedback by 2
    zeta / wR and the position loop rings.
    """
    drag = rotor_drag(c)
    for i in range(3):
        jerk = 0.0
        if c.is_free[i] == 0 and c.is_limited[i // 2] == 0:  # limited parts are constant
            e_v = c.reference_velocity_enu_mps[i] - x.velocity_enu_mps[i]
            e_a = c.reference_acceleration_enu_mps2[i] - c.acceleration_enu_mps2[i]
            jerk = c.position_gain * e_v + c.velocity_gain * e_a
            jerk = min(max(jerk, -max_feedback_mps3), max_feedback_mps3)
        drag_jerk = drag * c.reference_acceleration_enu_mps2[i]
        c.demanded_jerk_enu_mps3[i] = c.reference_jerk_enu_mps3[i] + drag_jerk + jerk


@kernel
def attitude_torque(c: np.record, rate_flu_radps: np.ndarray) -> None:
    """Write the torque that turns R to R_d to `c.torque_flu_nm`, about the body axes.

    This is eq. (16) with another e_R and without the derivative of Omega_d.
    """
    R, Rd, J = c.R, c.R_cmd, c.inertia_flu_kgm2
    Q = c.R_error
    for i in range(3):
        for j in range(3):
            Q[i, j] = R[0, i] * Rd[0, j] + R[1, i] * Rd[1, j] + R[2, i] * Rd[2, j]
    wd, e_R = c.rate_cmd_flu_radps, c.attitude_error
    _attitude_error(Q, rate_flu_radps, e_R)
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        wd_body = Q[i, 0] * wd[0] + Q[i, 1] * wd[1] + Q[i, 2] * wd[2]
        e_W = rate_flu_radps[i] - wd_body
        turn = -c.attitude_gain[i] * e_R[i] - c.angular_rate_gain[i] * e_W
        gyroscopic = (J[k] - J[j]) * rate_flu_radps[j] * rate_flu_radps[k]
        c.torque_flu_nm[i] = J[i] * turn + gyroscopic


@kernel
def _attitude_error(Q: np.ndarray, rate_flu_radps: np.ndarray, e_R: np.ndarray) -> None:
    """Write the error of the attitude Q = R^T R_d: tilt about body x and y, yaw about body z.

    R^T R_d is a turn by theta about an axis in the body's x-y plane after one by psi about z. The
    tilt error is 2 sin(theta / 2) along that axis: it grows up to 180 degrees, where Lee's
    sin(theta) vanishes. The yaw error is sin(psi) cos^2(theta / 2): zero upside down. Both equal
    Lee's for small angles.
    """
    half = math.sqrt(max(0.5 + 0.5 * Q[2, 2], 0.0))
    e_R[2] = 0.5 * (Q[0, 1] - Q[1, 0])
    if half > _UPSIDE_DOWN_COSINE:
        e_R[0], e_R[1] = Q[1, 2] / half, -Q[0, 2] / half
        return
    # Any axis will do; continue about the axis of the present rotation.
    rate = math.hypot(rate_flu_radps[0], rate_flu_radps[1])
    e_R[0] = -2.0 * (rate_flu_radps[0] / rate if rate > 0.0 else 1.0)
    e_R[1] = -2.0 * (rate_flu_radps[1] / rate if rate > 0.0 else 0.0)


@kernel
def rate_torque(c: np.record, rate_flu_radps: np.ndarray) -> None:
    """Write to `c.torque_flu_nm` what brings the body rates to `c.rate_cmd_flu_radps`."""
    J = c.inertia_flu_kgm2
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        error = c.rate_cmd_flu_radps[i] - rate_flu_radps[i]
        gyroscopic = (J[k] - J[j]) * rate_flu_radps[j] * rate_flu_radps[k]
        c.torque_flu_nm[i] = J[i] * c.rate_level_gain[i] * error + gyroscopic
