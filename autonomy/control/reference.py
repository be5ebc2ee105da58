"""Reference for a quadrotor, derived from setpoints so that it can be followed.

Companions send anything from smooth trajectories to a point far away, and a controller that tracked
a far point directly would tilt to its limits. Points of a trajectory (position and velocity given,
near the reference) are used directly and extrapolated between setpoints by their derivatives. Bare
positions and velocities are targets of a model of limited jerk, acceleration and speed. The state
of that model is the reference, so that a step never tilts the vehicle beyond its limits. An axis
without position and velocity follows its acceleration alone. An axis without any finite value
brakes.
"""

from __future__ import annotations

import math

import numpy as np

from autonomy.jit import kernel
from autonomy.rotation import wrap_angle, yaw_from_quat

MAX_EXTRAPOLATION_S = 0.25
"""Time for which a trajectory's point is extrapolated, enough for a 4 Hz stream. After that the
reference stops."""

# Entering needs closeness to the reference, leaving a great distance to the vehicle: the gap
# between the two limits prevents flicker.
_ENTER_DIRECT_M = 0.2
_ENTER_DIRECT_MPS = 0.5
_LEAVE_DIRECT_M = 4.0
_MAX_YAW_LEAD_RAD = 0.6  # beyond the vehicle's yaw, so that a blocked turn does not wind up


@kernel
def start_reference(c: np.record, x: np.record) -> None:
    """Reset the reference to the vehicle's state, at rest of acceleration and jerk."""
    for i in range(3):
        c.reference_position_enu_m[i] = x.position_enu_m[i]
        c.reference_velocity_enu_mps[i] = x.velocity_enu_mps[i]
        c.reference_acceleration_enu_mps2[i] = 0.0
        c.reference_jerk_enu_mps3[i] = 0.0
        c.integral_mps2[i] = 0.0
        c.disturbance_mps2[i] = 0.0
        c.last_position_enu_m[i] = math.inf  # no setpoint yet
        c.last_velocity_enu_mps[i] = math.nan
        c.setpoint_acceleration_enu_mps2[i] = 0.0
    c.reference_yaw_rad = yaw_from_quat(x.quat_wxyz)
    c.reference_yaw_rate_radps = 0.0
    c.is_direct = 0


@kernel
def update_reference(c: np.record, s: np.record, x: np.record) -> None:
    """Advance the reference by one control tick.

    Args:
        c: Record of the controller; its `reference_...` fields change.
        s: Present setpoint, of the level `TRAJECTORY`.
        x: State of the vehicle as it is known.
    """
    was_direct = c.is_direct == 1
    _choose_direct(c, s, x)
    if c.is_direct == 1:
        _follow_directly(c, s)
    else:
        if was_direct:
            _limit_acceleration(c)
        _aim(c, s)
        _follow_by_model(c, s, x)
        _keep_on_leash(c, x)
    _turn(c, s, x)
    c.setpoint_age_s += c.dt_s


@kernel
def _limit_acceleration(c: np.record) -> None:
    """Reduce a trajectory's acceleration to the model's limits when the model takes over."""
    a, limit = c.reference_acceleration_enu_mps2, c.max_acceleration_vertical_mps2
    factor = _shortening(a[0], a[1], c.max_acceleration_mps2)
    a[0] *= factor
    a[1] *= factor
    a[2] = min(max(a[2], -limit), limit)


@kernel
def _choose_direct(c: np.record, s: np.record, x: np.record) -> None:
    to_reference, to_vehicle, difference = 0.0, 0.0, 0.0
    for i in range(3):
        p, v = s.position_enu_m[i], s.velocity_enu_mps[i]
        to_reference += (p - c.reference_position_enu_m[i]) ** 2
        to_vehicle += (p - x.position_enu_m[i]) ** 2
        difference += (v - c.reference_velocity_enu_mps[i]) ** 2
    # A NaN or infinity in any axis ends up in these sums: such a setpoint is no point of a
    # trajectory.
    if not math.isfinite(to_reference + difference):
        c.is_direct = 0
    elif c.is_direct == 1:
        c.is_direct = 1 if to_vehicle < _LEAVE_DIRECT_M**2 else 0
    elif to_reference < _ENTER_DIRECT_M**2 and difference < _ENTER_DIRECT_MPS**2:
        c.is_direct = 1


@kernel
def _follow_directly(c: np.record, s: np.record) -> None:
    t = min(c.setpoint_age_s, MAX_EXTRAPOLATION_S)
    is_moving = 1.0 if c.setpoint_age_s < MAX_EXTRAPOLATION_S else 0.0
    for i in range(3):
        p, v = s.position_enu_m[i], s.velocity_enu_mps[i]
        a, j = c.setpoint_acceleration_enu_mps2[i], c.setpoint_jerk_enu_mps3[i]
        c.reference_position_enu_m[i] = p + v * t + 0.5 * a * t * t + j * t * t * t / 6.0
        c.reference_velocity_enu_mps[i] = is_moving * (v + a * t + 0.5 * j * t * t)
        c.reference_acceleration_enu_mps2[i] = is_moving * (a + j * t)
        c.reference_jerk_enu_mps3[i] = is_moving * j
        c.is_free[i] = 0


@kernel
def _approach_speed(distance_m: float, gain: float, deceleration: float) -> float:
    """Speed towards a target that allows stopping there within a deceleration.

    Near the target the speed is proportional to the distance, farther away it follows the square
    root; both pieces meet with equal slope.
    """
    linear_m = deceleration / (gain * gain)
    if distance_m <= linear_m:
        return gain * distance_m
    return math.sqrt(2.0 * deceleration * (distance_m - 0.5 * linear_m))


@kernel
def _aim(c: np.record, s: np.record) -> None:
    """Compute the target velocity of the model: towards positions, plus the setpoint's own.

    Horizontal axes share one speed limit, so that the vehicle flies straight at the target.
    """
    target, gain = c.target_velocity_enu_mps, c.approach_gain_radps
    square = 0.0
    for i in range(2):
        left = s.position_enu_m[i] - c.reference_position_enu_m[i]
        square += left * left if math.isfinite(left) else 0.0
    distance = math.sqrt(square)
    # Half of the acceleration is left for turning and for the model's lag.
    speed = min(_approach_speed(distance, gain, 0.5 * c.max_acceleration_mps2), c.max_speed_mps)
    for i in range(3):
        left = s.position_enu_m[i] - c.reference_position_enu_m[i]
        target[i] = 0.0
        if not math.isfinite(left):
            continue
        if i < 2:
            target[i] = left / max(distance, 1e-9) * speed
        else:
            climb = _approach_speed(abs(left), gain, 0.5 * c.max_acceleration_vertical_mps2)
            limit = c.max_climb_mps if left > 0.0 else c.max_descent_mps
            target[i] = math.copysign(min(climb, limit), left)
    _add_velocity(c, s)


@kernel
def _add_velocity(c: np.record, s: np.record) -> None:
    """Add the setpoint's velocity to the target, horizontally as far as the speed limit allows.

    The path to a far setpoint has priority. Otherwise a vehicle left behind by a fast setpoint
    would fly beside it for ever.
    """
    target, limit = c.target_velocity_enu_mps, c.max_speed_mps
    vx, vy = _finite(s.velocity_enu_mps[0]), _finite(s.velocity_enu_mps[1])
    square = vx * vx + vy * vy
    if square > 0.0 and math.hypot(target[0] + vx, target[1] + vy) > limit:
        along = target[0] * vx + target[1] * vy
        room = max(limit * limit - target[0] * target[0] - target[1] * target[1], 0.0)
        share = (math.sqrt(along * along + square * room) - along) / square
        vx *= share
        vy *= share
    target[0] += vx
    target[1] += vy
    limit = c.max_vertical_speed_mps
    target[2] = min(max(target[2] + _finite(s.velocity_enu_mps[2]), -limit), limit)


@kernel
def _finite(value: float) -> float:
    return value if math.isfinite(value) else 0.0


@kernel
def _follow_by_model(c: np.record, s: np.record, x: np.record) -> None:
    dt, jerk = c.dt_s, c.reference_jerk_enu_mps3
    _aim_jerk(c, s)
    for i in range(3):
        c.reference_acceleration_enu_mps2[i] += jerk[i] * dt
        c.reference_velocity_enu_mps[i] += c.reference_acceleration_enu_mps2[i] * dt
        c.reference_position_enu_m[i] += c.reference_velocity_enu_mps[i] * dt
        c.is_free[i] = 1 if _is_acceleration_only(s, i) else 0
        if c.is_free[i] == 1:
            c.reference_acceleration_enu_mps2[i] = s.acceleration_enu_mps2[i]
            c.reference_velocity_enu_mps[i] = x.velocity_enu_mps[i]
            c.reference_position_enu_m[i] = x.position_enu_m[i]
            jerk[i] = 0.0


@kernel
def _aim_jerk(c: np.record, s: np.record) -> None:
    """Compute the jerk towards the acceleration that the target velocity demands, both limited.

    The limits apply to horizontal vectors: the acceleration then moves straight from one point of
    its disc to another and never leaves it.
    """
    jerk, limit = c.reference_jerk_enu_mps3, c.max_acceleration_vertical_mps2
    ax, ay = _model_acceleration(c, s, 0), _model_acceleration(c, s, 1)
    az = _model_acceleration(c, s, 2)
    factor = _shortening(ax, ay, c.max_acceleration_mps2)
    jerk[0] = (factor * ax - c.reference_acceleration_enu_mps2[0]) / c.dt_s
    jerk[1] = (factor * ay - c.reference_acceleration_enu_mps2[1]) / c.dt_s
    jerk[2] = (min(max(az, -limit), limit) - c.reference_acceleration_enu_mps2[2]) / c.dt_s
    factor = _shortening(jerk[0], jerk[1], c.max_jerk_mps3)
    jerk[0] *= factor
    jerk[1] *= factor
    jerk[2] = min(max(jerk[2], -c.max_jerk_mps3), c.max_jerk_mps3)


@kernel
def _shortening(x: float, y: float, limit: float) -> float:
    """Factor that shortens (x, y) to the limit if it is longer."""
    length = math.sqrt(x * x + y * y)
    return limit / length if length > limit else 1.0


@kernel
def _is_acceleration_only(s: np.record, i: int) -> bool:
    return (
        not math.isfinite(s.position_enu_m[i])
        and not math.isfinite(s.velocity_enu_mps[i])
        and math.isfinite(s.acceleration_enu_mps2[i])
    )


@kernel
def _model_acceleration(c: np.record, s: np.record, i: int) -> float:
    """Acceleration towards the target velocity, with the setpoint's as feed-forward."""
    wanted = c.velocity_response_radps * (
        c.target_velocity_enu_mps[i] - c.reference_velocity_enu_mps[i]
    )
    forward = s.acceleration_enu_mps2[i]
    return wanted + forward if math.isfinite(forward) else wanted


@kernel
def _keep_on_leash(c: np.record, x: np.record) -> None:
    """Keep the reference near a vehicle that cannot follow, such as a landed one.

    Otherwise the reference would run away and the vehicle would leap when it is free again.
    """
    ex = c.reference_position_enu_m[0] - x.position_enu_m[0]
    ey = c.reference_position_enu_m[1] - x.position_enu_m[1]
    factor = _shortening(ex, ey, c.leash_m)
    c.reference_position_enu_m[0] = x.position_enu_m[0] + factor * ex
    c.reference_position_enu_m[1] = x.position_enu_m[1] + factor * ey
    ez = c.reference_position_enu_m[2] - x.position_enu_m[2]
    limit = 0.5 * c.leash_m
    c.reference_position_enu_m[2] = x.position_enu_m[2] + min(max(ez, -limit), limit)


@kernel
def _turn(c: np.record, s: np.record, x: np.record) -> None:
    """Advance the yaw by a model of limited rate and angular acceleration.

    The reference leads the vehicle's own yaw by at most `_MAX_YAW_LEAD_RAD`.
    """
    dt = c.dt_s
    wanted = s.yaw_rate_radps if math.isfinite(s.yaw_rate_radps) else 0.0
    if math.isfinite(s.yaw_rad):
        ahead = min(c.setpoint_age_s, MAX_EXTRAPOLATION_S) * wanted
        left = wrap_angle(s.yaw_rad + ahead - c.reference_yaw_rad)
        speed = _approach_speed(abs(left), c.yaw_gain_radps, 0.5 * c.max_yaw_acceleration_radps2)
        wanted += math.copysign(speed, left)
    wanted = min(max(wanted, -c.max_yaw_rate_radps), c.max_yaw_rate_radps)
    step = c.max_yaw_acceleration_radps2 * dt
    change = wanted - c.reference_yaw_rate_radps
    c.reference_yaw_rate_radps += min(max(change, -step), step)
    yaw = yaw_from_quat(x.quat_wxyz)
    lead = wrap_angle(c.reference_yaw_rad + c.reference_yaw_rate_radps * dt - yaw)
    lead = min(max(lead, -_MAX_YAW_LEAD_RAD), _MAX_YAW_LEAD_RAD)
    c.reference_yaw_rad = wrap_angle(yaw + lead)
