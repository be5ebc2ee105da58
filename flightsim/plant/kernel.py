"""One advance of the plant: the hot loop of the simulator, compiled as a whole.

Each control tick: controller, physics steps with the rotors' wrench, sensors, estimator, log.
"""

from __future__ import annotations

import numpy as np

from autonomy.control.controller import control
from autonomy.estimation.alignment import align_when_ready
from autonomy.jit import kernel
from flightsim.environment.motion import move_traffic
from flightsim.environment.wind import AIR_NORMALS, move_air
from flightsim.plant.mujoco_calls import call_mj_step, doubles, integers, pointers
from flightsim.plant.sensing import sense
from flightsim.plant.surfaces import feel_surfaces
from flightsim.vehicles.rotor_model import step_rotors


@kernel
def advance(
    plants: np.ndarray,
    movers: np.ndarray,
    mover_points: np.ndarray,
    rooms: np.ndarray,
    shelter: np.ndarray,
    steel: np.ndarray,
    normals: np.ndarray,
    history: np.ndarray,
) -> None:
    """Advance by 20 ms.

    Args:
        plants: `PLANT_DTYPE` (1,).
        movers: `MOVER_DTYPE` (n,), a row for each moving obstacle.
        mover_points: Control points of their paths (k, 3).
        rooms: Without satellites and wind (n, 8), `flightsim.environment.rooms`.
        shelter: Flow around buildings (nx, ny, nz, 3), `flightsim.environment.shelter`.
        steel: Near the magnetometer (n, 5), `flightsim.environment.steel`.
        normals: Standard normals for one second, a block for each sensor and one for the air.
        history: `HISTORY_DTYPE`, a row for each control tick, written.
    """
    p = plants[0]
    e, f = p.engine, p.filter
    qpos, qvel = doubles(e.qpos_address, 7), doubles(e.qvel_address, 6)
    e.contact_ticks = 0
    # MuJoCo reads its clock before and after each stage, a fifth of a step's time for us.
    clock = pointers(e.clock_address, 1)
    stage_clock, clock[0] = clock[0], 0
    feel_surfaces(p.surfaces, e, p.rotors, qpos)
    for i in range(e.ticks_per_advance):
        _tell_state(p.state, e, f, qpos, qvel)
        control(p.controller, p.setpoint, p.state, e.has_new_setpoint == 1)
        e.has_new_setpoint = 0
        _move_world(p, movers, mover_points, rooms, shelter, normals, qpos, qvel)
        is_touching = _step_physics(e, p.rotors, p.controller, qpos, qvel)
        e.contact_ticks += is_touching
        e.tick += 1
        sense(p, qpos, qvel, rooms, steel, normals)
        if f.is_aligned == 0:
            align_when_ready(f)
        _log(history[i], p, qpos, qvel, is_touching)
    clock[0] = stage_clock


@kernel
def _tell_state(
    x: np.record, e: np.record, f: np.record, qpos: np.ndarray, qvel: np.ndarray
) -> None:
    """State that the controller may know: the estimate, or the truth for benchmarks of control."""
    is_true = e.knows_truth == 1
    for i in range(3):
        change = (qvel[i] - x.velocity_enu_mps[i]) * e.tick_hz
        x.acceleration_enu_mps2[i] = change if is_true else f.acceleration_enu_mps2[i]
        x.position_enu_m[i] = qpos[i] if is_true else f.position_enu_m[i]
        x.velocity_enu_mps[i] = qvel[i] if is_true else f.velocity_enu_mps[i]
        rate = qvel[3 + i] if is_true else f.angular_rate_flu_radps[i]
        x.angular_rate_flu_radps[i] = rate
    for i in range(4):
        x.quat_wxyz[i] = qpos[3 + i] if is_true else f.quat_wxyz[i]


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
            doubles(e.mocap_pos_address, 3 * n).reshape(n, 3),
            doubles(e.mocap_quat_address, 4 * n).reshape(n, 4),
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
        row.rotor_command_radps[i] = c.rotor_command_radps[i]
        row.rotor_speed_radps[i] = r.speed_radps[i]
