"""Fusion of GNSS position and velocity (late), barometric height and magnetic heading.

A fix is compared with the estimate of the time at which it was valid, because it arrives a tenth of
a second late. Three errors are treated as more than white noise: the receiver's slow wander is a
state, gross errors of one axis discredit the whole fix, and a fix that contradicts good odometry
may move the estimate only in small steps.
"""

from __future__ import annotations

import math

import numpy as np

from autonomy.estimation.error_state import (
    ATTITUDE,
    BARO_OFFSET,
    GNSS_WANDER,
    N_STATES,
    POSITION,
    VELOCITY,
)
from autonomy.estimation.past import (
    past_position,
    past_velocity,
    restart_past,
    write_past_position_row,
)
from autonomy.estimation.update import GROSS_RATIO, gate_ratio, scalar_update
from autonomy.jit import kernel
from autonomy.rotation import matrix_from_quat, wrap_angle

_GNSS_POSITION, _GNSS_VELOCITY, _BARO, _HEADING = 0, 1, 2, 3  # rows of MEASUREMENTS
_MOST_REJECTED_STEP_M = 10.0  # from fix to fix: 50 m/s at 5 Hz
# Above this speed the vehicle counts as having moved since its alignment.
_MOVES_MPS = 0.5
# Greatest step of a fix before the vehicle has moved; the setting holds if it is greater.
_STEP_AT_REST_M = 0.03
_FIELD_SMOOTHING = 0.04  # of a sample of the field's strength: half a second at 50 Hz


@kernel
def fuse_gnss(
    f: np.record,
    position_enu_m: np.ndarray,
    velocity_enu_mps: np.ndarray,
    age_ticks: int,
    sigma_m: np.ndarray,
    sigma_mps: np.ndarray,
) -> None:
    """Fuse a fix that was valid `age_ticks` < `N_PAST` ago, against the estimate of that time.

    Vectors have shape (3,). `sigma_m` does not include the slow wander. After `max_gnss_rejections`
    rejected fixes that agree with each other, position and velocity restart from the fix.
    """
    _let_wander(f)
    h = f.measurement_row
    ratio = _worst_ratio(f, position_enu_m, age_ticks, sigma_m)
    # While odometry carries the position, no fix moves it by more than a small step.
    is_gross = f.has_vio == 0 and ratio > GROSS_RATIO
    f.ratio_gnss_position = ratio if is_gross else 0.0
    f.ratio_gnss_velocity = 0.0
    for i in range(0 if is_gross else 3):
        write_past_position_row(f, h, age_ticks, i)
        h[GNSS_WANDER + i] = 1.0
        innovation = position_enu_m[i] - past_position(f, age_ticks, i) - f.gnss_wander_enu_m[i]
        variance = max(sigma_m[i] * sigma_m[i], _variance_of_a_small_step(f, i, innovation))
        ratio = scalar_update(f, _GNSS_POSITION, innovation, variance)
        f.ratio_gnss_position = max(f.ratio_gnss_position, ratio)
        # A correction of the present velocity moves the past one by as much.
        h[:] = 0.0
        h[VELOCITY + i] = 1.0
        innovation = velocity_enu_mps[i] - past_velocity(f, age_ticks, i)
        variance = sigma_mps[i] * sigma_mps[i]
        variance = max(variance, _variance_of_a_small_step(f, i, innovation))
        ratio = scalar_update(f, _GNSS_VELOCITY, innovation, variance)
        f.ratio_gnss_velocity = max(f.ratio_gnss_velocity, ratio)
    if f.ratio_gnss_position <= 1.0:
        f.gnss_rejections = 0
        f.last_gnss_tick = f.last_position_tick = f.tick
        return
    f.gnss_rejections = f.gnss_rejections + 1 if _agrees_with_rejected(f, position_enu_m) else 1
    if f.gnss_rejections >= f.max_gnss_rejections:
        _restart(f, position_enu_m, velocity_enu_mps, age_ticks, sigma_m, sigma_mps)


@kernel
def _worst_ratio(
    f: np.record, position_enu_m: np.ndarray, age_ticks: int, sigma_m: np.ndarray
) -> float:
    """Greatest ratio of a fix's three positions to their gates, before any of them is fused.

    If a fix is grossly wrong along one axis, it is right along another only by chance.
    """
    h, worst = f.measurement_row, 0.0
    for i in range(3):
        write_past_position_row(f, h, age_ticks, i)
        h[GNSS_WANDER + i] = 1.0
        innovation = position_enu_m[i] - past_position(f, age_ticks, i) - f.gnss_wander_enu_m[i]
        worst = max(worst, gate_ratio(f, innovation, sigma_m[i] * sigma_m[i]))
    return worst


@kernel
def _agrees_with_rejected(f: np.record, position_enu_m: np.ndarray) -> bool:
    """Return whether a rejected fix lies near the rejected one before it, so that it may be right.

    Fixes that do not even agree with each other are no reason to restart. The fix is remembered for
    the next call.
    """
    square = 0.0
    for i in range(3):
        step = position_enu_m[i] - f.rejected_enu_m[i]
        square += step * step
        f.rejected_enu_m[i] = position_enu_m[i]
    return f.gnss_rejections > 0 and square <= _MOST_REJECTED_STEP_M * _MOST_REJECTED_STEP_M


@kernel
def _let_wander(f: np.record) -> None:
    """Propagate the receiver's slow error, a first-order Gauss-Markov process, to this fix."""
    interval_s = (f.tick - f.last_wander_tick) * f.dt_s
    f.last_wander_tick = f.tick
    decay = math.exp(-interval_s / f.wander_correlation_s)
    P = f.covariance
    for k in range(GNSS_WANDER, GNSS_WANDER + 3):
        f.gnss_wander_enu_m[k - GNSS_WANDER] *= decay
        for j in range(N_STATES):
            P[k, j] *= decay
        for j in range(N_STATES):
            P[j, k] *= decay
        P[k, k] += (1.0 - decay * decay) * f.wander_variance_m2[k - GNSS_WANDER]


@kernel
def _variance_of_a_small_step(f: np.record, i: int, innovation: float) -> float:
    """Least variance with which a measurement moves position i by at most `max_gnss_step_m`.

    It applies only while odometry carries the position: after a flight indoors GNSS then takes over
    in steps that a controller does not notice. Before the vehicle first moves, steps may be larger,
    because nobody steers by them. The weight is that of Huber 1964, bounded on the correction.
    """
    if f.has_vio == 0:
        return 0.0
    v = f.velocity_enu_mps
    if v[0] * v[0] + v[1] * v[1] + v[2] * v[2] > _MOVES_MPS * _MOVES_MPS:
        f.has_moved = 1
    most = f.max_gnss_step_m if f.has_moved == 1 else max(f.max_gnss_step_m, _STEP_AT_REST_M)
    P, h = f.covariance, f.measurement_row
    step = s = 0.0
    for j in range(N_STATES):
        if h[j] != 0.0:
            step += P[i, j] * h[j]
            for k in range(N_STATES):
                s += h[j] * P[j, k] * h[k]
    # The step is gain times innovation, P h / (h P h + variance); solved for the variance. Negative
    # if the step is small anyway.
    return step * abs(innovation) / most - s


@kernel
def _restart(
    f: np.record,
    position_enu_m: np.ndarray,
    velocity_enu_mps: np.ndarray,
    age_ticks: int,
    sigma_m: np.ndarray,
    sigma_mps: np.ndarray,
) -> None:
    """Restart position and velocity from a fix; the other states keep their estimates."""
    age_s = age_ticks * f.dt_s
    P = f.covariance
    for j in range(N_STATES):
        for i in range(6):
            P[i, j] = P[j, i] = 0.0
        for i in range(GNSS_WANDER, GNSS_WANDER + 3):
            P[i, j] = P[j, i] = 0.0
    for i in range(3):
        f.velocity_enu_mps[i] = velocity_enu_mps[i]
        f.position_enu_m[i] = position_enu_m[i] + age_s * velocity_enu_mps[i]
        f.gnss_wander_enu_m[i] = 0.0
        correlate_with_wander(f, i, sigma_m[i] * sigma_m[i])
        P[VELOCITY + i, VELOCITY + i] = sigma_mps[i] * sigma_mps[i]
    restart_past(f)
    # The restart may move the height by metres, so the barometer's offset is no longer known.
    P[BARO_OFFSET, BARO_OFFSET] += sigma_m[2] * sigma_m[2]
    f.has_vio = 0
    f.gnss_rejections = 0
    f.last_gnss_tick = f.last_position_tick = f.tick


@kernel
def correlate_with_wander(f: np.record, i: int, variance_m2: float) -> None:
    """Set the covariance of a position that equals a fix: it shares the receiver's wander."""
    P, k, wander = f.covariance, GNSS_WANDER + i, f.wander_variance_m2[i]
    P[i, i] = variance_m2 + wander
    P[k, k] = wander
    # Negative: a fix is position plus wander, so what the wander has too much the position lacks.
    P[i, k] = P[k, i] = -wander


@kernel
def fuse_barometer(f: np.record, altitude_m: float) -> None:
    """Fuse a pressure altitude: ENU height plus the barometer's offset."""
    h = f.measurement_row
    h[:] = 0.0
    h[POSITION + 2] = 1.0
    h[BARO_OFFSET] = 1.0
    innovation = altitude_m - f.position_enu_m[2] - f.baro_offset_m
    f.ratio_baro = scalar_update(f, _BARO, innovation, f.baro_variance_m2)


@kernel
def heading_innovation(f: np.record, field_flu_ut: np.ndarray) -> float:
    """Return the magnetometer's heading minus the estimated one, rad; fill the Jacobian row.

    The measured field, turned into the world by the estimate, is compared in azimuth with the
    geomagnetic model's field. A tilt error leaks the vertical field into it. The row uses the
    model's field, because a measured one would correlate the row with the innovation, and noise
    alone would then tilt the estimate (40 mrad/s with an accelerometer off by 0.2 m/s^2).
    """
    R, h, field = f.work_R, f.measurement_row, f.field_enu_ut
    matrix_from_quat(f.quat_wxyz, R)
    mx = R[0, 0] * field_flu_ut[0] + R[0, 1] * field_flu_ut[1] + R[0, 2] * field_flu_ut[2]
    my = R[1, 0] * field_flu_ut[0] + R[1, 1] * field_flu_ut[1] + R[1, 2] * field_flu_ut[2]
    leak = field[2] / (field[0] * field[0] + field[1] * field[1])
    h[:] = 0.0
    h[ATTITUDE] = -leak * field[0]
    h[ATTITUDE + 1] = -leak * field[1]
    h[ATTITUDE + 2] = 1.0
    return wrap_angle(math.atan2(field[1], field[0]) - math.atan2(my, mx))


@kernel
def fuse_magnetometer(f: np.record, field_flu_ut: np.ndarray) -> None:
    """Fuse the heading of a measured field; the tilt stays with gravity and GNSS.

    A field whose strength differs from the Earth's is believed less, because steel or currents
    disturb it.
    """
    excess = relative_field_excess(f, field_flu_ut)
    f.field_excess += _FIELD_SMOOTHING * (excess - f.field_excess)
    slow = f.heading_disturbance_rad * f.heading_disturbance_rad + f.field_excess * f.field_excess
    # Slow disturbances do not average out over their samples, so each sample gets their whole
    # variance.
    variance = f.heading_variance_rad2 + f.heading_disturbance_samples * slow
    innovation = heading_innovation(f, field_flu_ut)
    f.ratio_heading = scalar_update(f, _HEADING, innovation, variance)


@kernel
def relative_field_excess(f: np.record, field_flu_ut: np.ndarray) -> float:
    """Strength of a field (3,) beyond the model's, over the model's horizontal part.

    This is the greatest heading error, in rad, that a disturbance of that strength suggests.
    """
    square = model = 0.0
    for i in range(3):
        square += field_flu_ut[i] * field_flu_ut[i]
        model += f.field_enu_ut[i] * f.field_enu_ut[i]
    return (math.sqrt(square) - math.sqrt(model)) / math.hypot(f.field_enu_ut[0], f.field_enu_ut[1])
