"""Wind estimate from the drag of the rotors, which depends on the air speed across their axes.

A multirotor without an airspeed sensor still feels the air: its accelerometer measures the drag
across the rotor axes. With known drag coefficients this gives the air speed, and the ground
velocity is known, so the difference is the wind.

    a_i = -(sum_k d_k w_k + c_i |u_i|) u_i + b_i + noise,   i = body x, y
    u = R^T (velocity - wind)

with rotor speeds w, air speed u, accelerometer bias b, and d, c of `DragModel`.

Sources: Abeywardena, Kodagoda, Dissanayake and Munasinghe 2013, "Improved state estimation in
quadrotor MAVs", eq. (7), for the linear part; PX4's EKF2 fuses both parts (`drag_fusion.cpp`).
"""

from __future__ import annotations

import numpy as np

from autonomy.estimation.error_state import ACCEL_BIAS, ATTITUDE, VELOCITY, WIND
from autonomy.estimation.update import scalar_update
from autonomy.jit import kernel
from autonomy.rotation import matrix_from_quat

_DRAG = 8  # row of MEASUREMENTS
_LEAST_LOAD = 0.5
"""Share of the weight that the rotors must carry. Below it the legs may carry the rest, and their
friction looks like drag."""


@kernel
def fuse_drag(f: np.record, accel_flu_mps2: np.ndarray, rotor_speed_radps: np.ndarray) -> None:
    """Add the specific force (3,) of the present tick; fuse its mean when a use is due.

    The mean since the last use takes out most of the vibration that rotors at these speeds (n,)
    cause. Without a model of drag nothing happens.
    """
    if f.drag_ticks == 0:
        return
    f.n_drag_accel += 1
    for i in range(2):
        f.drag_accel_sum[i] += accel_flu_mps2[i]
    if f.tick % f.drag_ticks == 0:
        _fuse_mean(f, rotor_speed_radps)
        f.n_drag_accel = 0
        f.drag_accel_sum[:] = 0.0


@kernel
def _fuse_mean(f: np.record, rotor_speed_radps: np.ndarray) -> None:
    thrust = linear = 0.0
    for k in range(len(rotor_speed_radps)):
        thrust += f.thrust_m[k] * rotor_speed_radps[k] * rotor_speed_radps[k]
        linear += f.drag_rotor_mps_per_rad[k] * rotor_speed_radps[k]
    if thrust < _LEAST_LOAD * f.gravity_mps2:
        return
    # The wind's random walk advances here and not in `predict`, once for each use.
    for i in range(2):
        f.covariance[WIND + i, WIND + i] += f.wind_variance_rate * f.drag_ticks * f.dt_s
    for i in range(2):
        _fuse_axis(f, i, f.drag_accel_sum[i] / f.n_drag_accel, linear)


@kernel
def _fuse_axis(f: np.record, i: int, accel_mps2: float, linear: float) -> None:
    """Fuse the specific force along body axis i (0 or 1)."""
    R, h, air = f.work_R, f.measurement_row, f.work_vector
    matrix_from_quat(f.quat_wxyz, R)
    for k in range(3):
        air[k] = f.velocity_enu_mps[k] - (f.wind_enu_mps[k] if k < 2 else 0.0)
    u = R[0, i] * air[0] + R[1, i] * air[1] + R[2, i] * air[2]
    quadratic = f.drag_fuselage_per_m[i] * abs(u)
    drag = (linear + quadratic) * u
    slope = linear + 2.0 * quadratic
    h[:] = 0.0
    for k in range(3):
        h[VELOCITY + k] = -slope * R[k, i]
    h[WIND] = slope * R[0, i]
    h[WIND + 1] = slope * R[1, i]
    # u changes by e_i . (air x theta) under an attitude error theta, e_i column i of R
    h[ATTITUDE] = -slope * (R[1, i] * air[2] - R[2, i] * air[1])
    h[ATTITUDE + 1] = -slope * (R[2, i] * air[0] - R[0, i] * air[2])
    h[ATTITUDE + 2] = -slope * (R[0, i] * air[1] - R[1, i] * air[0])
    h[ACCEL_BIAS + i] = 1.0
    # The coefficients are known to a few percent, so a strong drag force is a poorer measurement.
    relative = f.drag_relative_sigma * drag
    innovation = accel_mps2 + drag - f.accel_bias_flu_mps2[i]
    scalar_update(f, _DRAG, innovation, f.drag_variance + relative * relative)
