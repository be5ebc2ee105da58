"""One advance of the plant: the hot loop of the simulator, compiled as a whole.

Each control tick: controller, physics steps with the rotors' wrench, sensors, estimator, log.
"""

from __future__ import annotations

import numpy as np

from autonomy.control.controller import control
from autonomy.estimation.alignment import align_when_ready
from autonomy.jit import kernel, kernel_without_lock
from flightsim.environment.motion import MOVER_DTYPE, move_traffic
from flightsim.environment.rooms import ROOM_COLUMNS
from flightsim.environment.steel import STEEL_COLUMNS
from flightsim.environment.wind import AIR_NORMALS, move_air
from flightsim.plant.mujoco_calls import (
    call_mj_step,
    doubles,
    integers,
    pointers,
    rows,
    table,
    take_number,
)
from flightsim.plant.record import HISTORY_DTYPE
from flightsim.plant.sensing import sense
from flightsim.plant.surfaces import feel_surfaces
from flightsim.vehicles.rotor_model import step_rotors

_N_ROOM_COLUMNS, _N_STEEL_COLUMNS = len(ROOM_COLUMNS), len(STEEL_COLUMNS)


@kernel_without_lock
def advance(plants: np.ndarray, counter: np.ndarray) -> None:
    """Advance every plant in its own world by the control ticks of one call.

    Several threads may call this with the same arrays at the same time: each plant is advanced by
    the first thread that is free, and none waits for another. Who it was changes no bit.

    Args:
        plants: `PLANT_DTYPE` (n,), at least one.
        counter: Number of plants that are taken (1,), int64; 0 before the call.
    """
    # MuJoCo reads its clock before and after each stage, a fifth of a step's time for us.
    clock = pointers(plants[0].engine.clock_address, 1)
    stage_clock, clock[0] = clock[0], 0
    while True:
        i = take_number(counter)
        if i >= len(plants):
            break
        _advance(plants[i])
    clock[0] = stage_clock


@kernel
def _advance(p: np.record) -> None:
    e = p.engine
    qpos, qvel = doubles(e.qpos_address, 7), doubles(e.qvel_address, 6)
    movers = rows(e.movers_address, e.n_movers, MOVER_DTYPE)
    mover_points = table(e.mover_points_address, e.n_mover_points, 3)
    rooms = table(e.rooms_address, e.n_rooms, _N_ROOM_COLUMNS)
    steel = table(e.steel_address, e.n_steel, _N_STEEL_COLUMNS)
    nx, ny, nz = e.shelter_shape[0], e.shelter_shape[1], e.shelter_shape[2]
    shelter = doubles(e.shelter_address, 3 * nx * ny * nz).reshape(nx, ny, nz, 3)
    normals = doubles(e.normals_address, e.n_normals)
    history = rows(e.history_address, e.ticks_per_advance, HISTORY_DTYPE)
    e.contact_ticks = 0
    feel_surfaces(p.surfaces, e, p.rotors, qpos)
    for i in range(e.ticks_per_advance):
        _tell_state(p.state, e, p.filter, p.rotors, qpos, qvel)
        control(p.controller, p.setpoint, p.state, e.has_new_setpoint == 1)
        e.has_new_setpoint = 0
        _move_world(p, movers, mover_points, rooms, shelter, normals, qpos, qvel)
        is_touching = 0
        if e.is_held == 0:
            is_touching = _step_physics(e, p.rotors, p.controller, qpos, qvel)
        e.contact_ticks += is_touching
        e.tick += 1
        if e.has_sensors == 1:
            sense(p, qpos, qvel, rooms, steel, normals)
            if p.filter.is_aligned == 0:
                align_when_ready(p.filter)
        _log(history[i], p, qpos, qvel, is_touching)


@kernel
def _tell_state(
    x: np.record, e: np.record, f: np.record, r: np.record, qpos: np.ndarray, qvel: np.ndarray
) -> None:
    """State that the controller may know: the estimate, or the truth for benchmarks of control.

    The rotors' speeds come from the telemetry of their speed controllers.
    """
    is_true = e.knows_truth == 1
    for i in range(3):
        change = (qvel[i] - x.velocity_enu_mps[i]) * e.tick_hz
        x.acceleration_enu_mps2[i] = change if is_true else f.acceleration_enu_mps2[i]
        x.position_enu_m[i] = qpos[i] if is_true else f.position_enu_m[i]
        x.velocity_enu_mps[i] = qvel[i] if is_true else f.velocity_enu_mps[i]
        rate = qvel[3 + i] if is_true else f.angular_rate_flu_radps[i]
        x.angular_rate_flu_radps[i] = rate
    x.has_rotor_speeds = 1
    for i in range(4):
        x.quat_wxyz[i] = qpos[3 + i] if is_true else f.quat_wxyz[i]
    for i in range(r.n_rotors):
        x.rotor_speed_radps[i] = r.speed_radps[i]


@kernel
def _move_world(
    p: np.record,
    movers: np.ndarray,
    mover_points: np.ndarray,
    rooms: np.ndarray,
    shelter: np.ndarray,
    normals: np.ndarray,
    qpos: np.ndarray,
    qvel: np.ndarray,
) -> None:
    """Advance the air and the movers by a control tick."""
    e, air, n = p.engine, p.air, len(movers)
    first = air.first_normal + e.tick % e.tick_hz * AIR_NORMALS
    gusts = normals[first : first + AIR_NORMALS]
    move_air(air, qpos[0:3], qvel[0:3], rooms, shelter, gusts, p.rotors.wind_enu_mps)
    if n > 0:
        move_traffic(
            p.traffic,
            movers,
            mover_points,
            qpos[0:3],
            table(e.mocap_pos_address, n, 3),
            table(e.mocap_quat_address, n, 4),
            integers(e.geom_bits_address, e.n_geoms),
            integers(e.body_bits_address, e.n_bodies),
        )


@kernel
def _step_physics(
    e: np.record, r: np.record, c: np.record, qpos: np.ndarray, qvel: np.ndarray
) -> int:
    """Step to the next control tick; 1 if the vehicle touched something on the way."""
    command = c.rotor_command_radps if e.has_power == 1 else e.no_command
    applied = doubles(e.applied_address, 6)
    constraint = doubles(e.constraint_address, e.n_constraints)
    is_touching = 0
    for _ in range(e.steps_per_tick):
        step_rotors(r, command, qpos[3:7], qvel[0:3], qvel[3:6], applied)
        call_mj_step(e.step_address, e.model_address, e.data_address)
        for k in range(len(constraint)):
            if constraint[k] != 0.0:
                is_touching = 1
    return is_touching


@kernel
def _log(
    row: np.record, p: np.record, qpos: np.ndarray, qvel: np.ndarray, is_touching: int
) -> None:
    e, r, imu, f, c, s = p.engine, p.rotors, p.imu, p.filter, p.controller, p.setpoint
    row.time_us = e.tick * e.tick_us
    row.setpoint_level = s.level
    row.is_touching = is_touching
    for i in range(3):
        row.position_true_enu_m[i] = qpos[i]
        row.velocity_true_enu_mps[i] = qvel[i]
        row.wind_enu_mps[i] = r.wind_enu_mps[i]
        row.angular_rate_true_flu_radps[i] = qvel[3 + i]
        row.position_est_enu_m[i] = f.position_enu_m[i]
        row.velocity_est_enu_mps[i] = f.velocity_enu_mps[i]
        row.angular_rate_est_flu_radps[i] = f.angular_rate_flu_radps[i]
        row.accel_flu_mps2[i] = imu.accel_flu_mps2[i]
        row.gyro_flu_radps[i] = imu.gyro_flu_radps[i]
        row.setpoint_position_enu_m[i] = s.position_enu_m[i]
        row.setpoint_velocity_enu_mps[i] = s.velocity_enu_mps[i]
        row.reference_position_enu_m[i] = c.reference_position_enu_m[i]
        row.reference_velocity_enu_mps[i] = c.reference_velocity_enu_mps[i]
    for i in range(4):
        row.quat_true_wxyz[i] = qpos[3 + i]
        row.quat_est_wxyz[i] = f.quat_wxyz[i]
    for i in range(r.n_rotors):
        row.rotor_command_radps[i] = c.rotor_command_radps[i]
        row.rotor_speed_radps[i] = r.speed_radps[i]
