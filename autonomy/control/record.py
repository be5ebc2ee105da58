"""Records of the control kernels: vehicle state, setpoint and the controller's memory.

A kernel takes one record instead of dozens of arguments. Several controllers are then rows of one
array, and the plant can hold a controller's record within its own.
"""

from __future__ import annotations

import math
from dataclasses import fields

import numpy as np

from autonomy.control.cfg import ControllerCfg
from autonomy.control.rotor_loss import spare_allocations
from autonomy.model.layout import inverse_allocation
from autonomy.model.quadrotor import GRAVITY_MPS2, MAX_ROTORS, QuadrotorParams
from autonomy.types import Setpoint

STATE_DTYPE = np.dtype(
    [
        ("position_enu_m", "f8", 3),
        ("velocity_enu_mps", "f8", 3),
        ("quat_wxyz", "f8", 4),
        ("angular_rate_flu_radps", "f8", 3),
        ("acceleration_enu_mps2", "f8", 3),  # mean over the last control tick
        ("rotor_speed_radps", "f8", MAX_ROTORS),
        ("has_rotor_speeds", "i8"),  # whether they are measured
    ],
    align=True,
)
"""State of the vehicle as the controller knows it: the estimate, or the truth if no estimator runs.
"""

SETPOINT_DTYPE = np.dtype(
    [
        ("level", "f8"),
        ("position_enu_m", "f8", 3),
        ("velocity_enu_mps", "f8", 3),
        ("acceleration_enu_mps2", "f8", 3),
        ("jerk_enu_mps3", "f8", 3),
        ("yaw_rad", "f8"),
        ("yaw_rate_radps", "f8"),
        ("quat_wxyz", "f8", 4),
        ("angular_rate_flu_radps", "f8", 3),
        ("thrust", "f8"),
    ]
)
"""Fields of `autonomy.types.Setpoint` in their order; `setpoint_row` depends on it."""

CONTROLLER_DTYPE = np.dtype(
    [
        # Memory.
        ("level", "f8"),
        ("setpoint_age_s", "f8"),
        ("is_direct", "i8"),  # the reference is the trajectory's own point
        ("reference_position_enu_m", "f8", 3),
        ("reference_velocity_enu_mps", "f8", 3),
        ("reference_acceleration_enu_mps2", "f8", 3),
        ("reference_jerk_enu_mps3", "f8", 3),
        ("reference_yaw_rad", "f8"),
        ("reference_yaw_rate_radps", "f8"),
        ("is_free", "i8", 3),  # axes without position and velocity feedback
        ("last_position_enu_m", "f8", 3),  # of the setpoint before, as the next two
        ("last_velocity_enu_mps", "f8", 3),
        ("last_acceleration_enu_mps2", "f8", 3),
        ("setpoint_acceleration_enu_mps2", "f8", 3),  # derived if not given, as is the next
        ("setpoint_jerk_enu_mps3", "f8", 3),
        ("integral_mps2", "f8", 3),
        ("is_limited", "i8", 2),  # the demanded force: horizontally, vertically
        ("is_recovering", "i8"),  # from tumbling, see autonomy.control.recovery
        ("rotor_model_radps", "f8", MAX_ROTORS),  # speeds that the commands should have made
        ("n_lost", "i8"),  # rotors that do not turn, see autonomy.control.rotor_loss
        ("is_lost", "i8", MAX_ROTORS),
        ("n_lost_ticks", "i8", MAX_ROTORS),
        ("given_speed_radps", "f8", MAX_ROTORS),  # of the rotors at the levels OFF and ROTORS
        ("acceleration_enu_mps2", "f8", 3),  # estimated
        ("disturbance_mps2", "f8", 3),  # part that the rotors do not explain
        ("room_below_m", "f8"),  # known to be free under the legs; 0 where that is unknown
        # Commands.
        ("force_enu_mps2", "f8", 3),  # demanded specific thrust
        ("R_cmd", "f8", (3, 3)),
        ("rate_cmd_flu_radps", "f8", 3),
        ("collective_n", "f8"),
        ("torque_flu_nm", "f8", 3),
        ("rotor_thrust_n", "f8", MAX_ROTORS),
        ("rotor_command_radps", "f8", MAX_ROTORS),
        ("thrust_fraction", "f8"),
        # Vehicle.
        ("dt_s", "f8"),
        ("mass_kg", "f8"),
        ("inertia_flu_kgm2", "f8", 3),
        ("n_rotors", "i8"),
        ("allocation", "f8", (MAX_ROTORS, 4)),  # rotor thrusts from (collective, torques)
        ("spare_allocation", "f8", (MAX_ROTORS, MAX_ROTORS, 4)),  # by lost rotor
        ("balance_m", "f8", (MAX_ROTORS, 2)),  # torque over thrust without a rotor
        ("thrust_constant", "f8", MAX_ROTORS),
        ("drag_coefficient", "f8", MAX_ROTORS),
        ("max_rotor_thrust_n", "f8", MAX_ROTORS),
        ("min_rotor_thrust_n", "f8", MAX_ROTORS),
        ("max_rotor_speed_radps", "f8", MAX_ROTORS),
        ("idle_speed_radps", "f8", MAX_ROTORS),
        ("time_constant_s", "f8", (MAX_ROTORS, 2)),  # up, down
        ("max_thrust_n", "f8"),
        ("gravity_mps2", "f8"),
        # Gains and limits, see ControllerCfg.
        ("position_gain", "f8"),
        ("velocity_gain", "f8"),
        ("integral_gain", "f8"),
        ("max_integral_mps2", "f8"),
        ("max_disturbance_mps2", "f8"),
        ("attitude_gain", "f8", 3),
        ("angular_rate_gain", "f8", 3),
        ("rate_level_gain", "f8", 3),
        ("max_tilt_tangent", "f8"),
        ("max_feedback_mps2", "f8"),
        ("max_thrust_mps2", "f8"),
        ("rotor_response_s", "f8"),
        ("approach_gain_radps", "f8"),
        ("velocity_response_radps", "f8"),
        ("max_acceleration_mps2", "f8"),
        ("max_acceleration_vertical_mps2", "f8"),
        ("max_jerk_mps3", "f8"),
        ("max_speed_mps", "f8"),
        ("max_vertical_speed_mps", "f8"),
        ("max_climb_mps", "f8"),
        ("max_descent_mps", "f8"),
        ("leash_m", "f8"),
        ("max_yaw_rate_radps", "f8"),
        ("max_yaw_acceleration_radps2", "f8"),
        ("yaw_gain_radps", "f8"),
        # Scratch.
        ("R", "f8", (3, 3)),
        ("R_error", "f8", (3, 3)),
        ("target_velocity_enu_mps", "f8", 3),  # of the reference's model
        ("position_error_enu_m", "f8", 3),
        ("demanded_jerk_enu_mps3", "f8", 3),  # derivative of the demanded force
        ("attitude_error", "f8", 3),
    ],
    align=True,
)

_SAME_NAME = {field.name for field in fields(ControllerCfg)} & set(CONTROLLER_DTYPE.names or ())
"""Gains and limits that the kernels use exactly as they are configured."""


def new_controller(quadrotor: QuadrotorParams, cfg: ControllerCfg, *, dt_s: float) -> np.ndarray:
    """Create a controller with its rotors off, as one record in an array of shape (1,).

    Args:
        quadrotor: Vehicle to control; at most `MAX_ROTORS` rotors.
        cfg: Gains and limits, as of `controller_cfg_for`.
        dt_s: Period of the control ticks.
    """
    controllers = np.zeros(1, CONTROLLER_DTYPE)
    c = controllers[0]
    c["dt_s"] = dt_s
    c["gravity_mps2"] = GRAVITY_MPS2
    _write_vehicle(c, quadrotor, cfg)
    wx, wr, wy = cfg.position_bandwidth_radps, cfg.attitude_bandwidth_radps, cfg.yaw_bandwidth_radps
    c["position_gain"] = wx**2
    c["velocity_gain"] = 2.0 * cfg.position_damping * wx
    c["attitude_gain"] = (wr**2, wr**2, wy**2)
    damping = 2.0 * cfg.attitude_damping
    c["angular_rate_gain"] = (damping * wr, damping * wr, damping * wy)
    rate = cfg.rate_bandwidth_radps
    c["rate_level_gain"] = (rate, rate, 0.5 * rate)
    c["max_tilt_tangent"] = math.tan(cfg.max_tilt_rad)
    c["max_thrust_mps2"] = cfg.max_thrust_fraction * quadrotor.max_thrust_n / quadrotor.mass_kg
    for name in _SAME_NAME:
        c[name] = getattr(cfg, name)
    return controllers


def setpoint_row(setpoint: Setpoint) -> tuple[float, ...]:
    """Return the numbers of a setpoint in the order of `SETPOINT_DTYPE`."""
    return (
        float(setpoint.level),
        *setpoint.position_enu_m,
        *setpoint.velocity_enu_mps,
        *setpoint.acceleration_enu_mps2,
        *setpoint.jerk_enu_mps3,
        setpoint.yaw_rad,
        setpoint.yaw_rate_radps,
        *setpoint.quat_wxyz,
        *setpoint.angular_rate_flu_radps,
        setpoint.thrust,
    )


def _write_vehicle(c: np.void, quadrotor: QuadrotorParams, cfg: ControllerCfg) -> None:
    rotors = quadrotor.rotors
    n = len(rotors)
    speed = np.array([rotor.max_speed_radps for rotor in rotors])
    kf = np.array([rotor.thrust_constant for rotor in rotors])
    idle = cfg.idle_speed_fraction * speed
    c["mass_kg"] = quadrotor.mass_kg
    c["inertia_flu_kgm2"] = quadrotor.inertia_flu_kgm2
    c["n_rotors"] = n
    c["allocation"][:n] = inverse_allocation(quadrotor)
    c["spare_allocation"][:n, :n], c["balance_m"][:n] = spare_allocations(quadrotor)
    c["thrust_constant"][:n] = kf
    c["drag_coefficient"][:n] = [rotor.drag_coefficient for rotor in rotors]
    c["max_rotor_speed_radps"][:n] = speed
    c["idle_speed_radps"][:n] = idle
    c["max_rotor_thrust_n"][:n] = kf * speed**2
    c["min_rotor_thrust_n"][:n] = kf * idle**2
    c["time_constant_s"][:n] = [[r.time_constant_up_s, r.time_constant_down_s] for r in rotors]
    c["max_thrust_n"] = quadrotor.max_thrust_n
