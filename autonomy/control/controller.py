"""One tick of the controller, from setpoint and estimate to rotor speed commands.

A setpoint enters the cascade at its level: a trajectory goes through reference, force and attitude,
an attitude or body rates join further down, and rotor speeds pass unchanged. Two cases replace the
usual cascade for a while: recovery from tumbling (`recovery`) and flight without a rotor
(`rotor_loss`). All of it is one compiled call over records, because it runs at 250 Hz.
"""

from __future__ import annotations

import math

import numpy as np

from autonomy.control.allocation import allocate, lead_command
from autonomy.control.geometric import attitude_torque, command_attitude, demand_force, rate_torque
from autonomy.control.recovery import demand_recovery, watch_recovery
from autonomy.control.reference import start_reference, update_reference
from autonomy.control.rotor_loss import (
    demand_gently,
    fly_without,
    forget_losses,
    watch_rotors,
)
from autonomy.control.setpoint_stream import accept_setpoint
from autonomy.jit import kernel
from autonomy.rotation import matrix_from_quat

# Values of `ControlLevel` as floats: the setpoint's record keeps its level as a float.
_OFF, _IDLE, _TRAJECTORY, _ATTITUDE, _RATE, _ROTORS = 0.0, 1.0, 2.0, 3.0, 4.0, 5.0


@kernel
def control(c: np.record, s: np.record, x: np.record, is_new: bool) -> None:
    """Run one control tick; the result is in `c.rotor_command_radps`.

    Args:
        c: Record of the controller (`CONTROLLER_DTYPE`); changed.
        s: Present setpoint (`SETPOINT_DTYPE`).
        x: State of the vehicle as it is known (`STATE_DTYPE`).
        is_new: True if the setpoint arrived since the last tick.
    """
    if s.level <= _IDLE or s.level == _ROTORS:
        _rest(c, s.level)
        start_reference(c, x)
        if s.level < _IDLE:
            forget_losses(c)
    else:
        _fly(c, s, x, is_new)
    c.level = s.level
    _model_rotors(c)


@kernel
def _rest(c: np.record, level: float) -> None:
    """Control nothing: command idle speed, or the speeds given for the levels OFF and ROTORS."""
    for i in range(c.n_rotors):
        # `given_speed_radps` is zero at the level OFF unless something else wrote speeds there.
        c.rotor_command_radps[i] = (
            c.idle_speed_radps[i] if level == _IDLE else c.given_speed_radps[i]
        )
        c.rotor_thrust_n[i] = c.min_rotor_thrust_n[i] if level == _IDLE else 0.0
    c.collective_n = 0.0
    c.thrust_fraction = 0.0
    c.rate_cmd_flu_radps[:] = 0.0
    c.torque_flu_nm[:] = 0.0


@kernel
def _fly(c: np.record, s: np.record, x: np.record, is_new: bool) -> None:
    # A reference from another level is stale, so it restarts at the vehicle.
    if s.level != c.level or c.level != _TRAJECTORY:
        start_reference(c, x)
        c.is_recovering = 0
    matrix_from_quat(x.quat_wxyz, c.R)
    watch_rotors(c, x)
    if s.level == _TRAJECTORY and is_new:
        accept_setpoint(c, s)
    if c.n_lost > 0:
        _fly_with_a_loss(c, s, x)
    else:
        _fly_whole(c, s, x)
    _command_speeds(c)


@kernel
def _fly_whole(c: np.record, s: np.record, x: np.record) -> None:
    if s.level == _TRAJECTORY:
        watch_recovery(c, x)
        if c.is_recovering == 1:
            demand_recovery(c, x)
        else:
            update_reference(c, s, x)
            demand_force(c, x)
            command_attitude(c, x)
        force, R = c.force_enu_mps2, c.R
        # Only the part of the demanded force along the present thrust axis can act now.
        along = force[0] * R[0, 2] + force[1] * R[1, 2] + force[2] * R[2, 2]
        c.collective_n = c.mass_kg * max(along, 0.0)
        attitude_torque(c, x.angular_rate_flu_radps)
    else:
        c.collective_n = min(max(s.thrust, 0.0), 1.0) * c.max_thrust_n
        for i in range(3):
            c.rate_cmd_flu_radps[i] = s.angular_rate_flu_radps[i]
        if s.level == _ATTITUDE:
            matrix_from_quat(s.quat_wxyz, c.R_cmd)
            attitude_torque(c, x.angular_rate_flu_radps)
        else:
            rate_torque(c, x.angular_rate_flu_radps)
    n = c.n_rotors
    allocate(
        c.allocation,
        c.collective_n,
        c.torque_flu_nm,
        c.min_rotor_thrust_n[:n],
        c.max_rotor_thrust_n[:n],
        c.rotor_thrust_n[:n],
    )


@kernel
def _fly_with_a_loss(c: np.record, s: np.record, x: np.record) -> None:
    """Fly without a rotor: follow a trajectory or an attitude's tilt; for body rates stay level."""
    if s.level == _TRAJECTORY:
        update_reference(c, s, x)
        demand_gently(c, x)
    else:
        c.R_cmd[:] = 0.0
        c.R_cmd[2, 2] = 1.0
        if s.level == _ATTITUDE:
            matrix_from_quat(s.quat_wxyz, c.R_cmd)
        # A force of zero would have no direction to aim at.
        thrust_mps2 = max(min(max(s.thrust, 0.0), 1.0) * c.max_thrust_n / c.mass_kg, 1e-3)
        for i in range(3):
            c.force_enu_mps2[i] = thrust_mps2 * c.R_cmd[i, 2]
    fly_without(c, x)


@kernel
def _command_speeds(c: np.record) -> None:
    """Command the speeds that produce the thrusts of `c.rotor_thrust_n`."""
    total = 0.0
    for i in range(c.n_rotors):
        total += c.rotor_thrust_n[i]
        wanted = math.sqrt(c.rotor_thrust_n[i] / c.thrust_constant[i])
        speed = c.rotor_model_radps[i]
        tau = c.time_constant_s[i, 0 if wanted >= speed else 1]
        command = lead_command(speed, wanted, tau, c.rotor_response_s, c.dt_s)
        least, most = c.idle_speed_radps[i], c.max_rotor_speed_radps[i]
        c.rotor_command_radps[i] = min(max(command, least), most)
    c.thrust_fraction = total / c.max_thrust_n


@kernel
def _model_rotors(c: np.record) -> None:
    """Model the rotor speeds that follow from the commands, since they are not measured."""
    for i in range(c.n_rotors):
        change = c.rotor_command_radps[i] - c.rotor_model_radps[i]
        tau = c.time_constant_s[i, 0 if change >= 0.0 else 1]
        c.rotor_model_radps[i] += change * (1.0 - math.exp(-c.dt_s / tau))
