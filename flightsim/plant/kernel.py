"""One advance of the plant: the hot loop of the simulator, compiled as a whole.

Each control tick runs the controller, the physics steps with the rotors' wrench, the sensors, the
estimator and the log. The order is that of a real vehicle: a command acts in the physics before any
sensor sees its effect. Several vehicles in one world take turns in each stage, and one step of the
engine moves them all, so that they can touch.
"""

from __future__ import annotations

import numpy as np

from autonomy.control.controller import control
from autonomy.estimation.alignment import align_when_ready
from autonomy.jit import kernel, kernel_without_lock
from flightsim.environment.motion import MOVER_DTYPE, let_touch, move_traffic
from flightsim.environment.rooms import ROOM_COLUMNS
from flightsim.environment.steel import STEEL_COLUMNS
from flightsim.environment.wind import AIR_NORMALS, move_air
from flightsim.plant.free_flight import is_free, step_free
from flightsim.plant.height_fields import ground_m
from flightsim.plant.mujoco_calls import (
    call_engine,
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

MOST_LATE_S = 1e-3
"""Difference between the engine's clock and ours that still counts as rounding."""
_N_ROOM_COLUMNS, _N_STEEL_COLUMNS = len(ROOM_COLUMNS), len(STEEL_COLUMNS)


@kernel_without_lock
def advance(plants: np.ndarray, counter: np.ndarray) -> None:
    """Advance the plants of every world by the control ticks of one call.

    Several threads may call this with the same arrays at the same time. Each world is advanced by
    the first thread that is free, and none waits for another. The thread makes no difference to any
    bit.

    Args:
        plants: `PLANT_DTYPE` (w, v), the v vehicles of each of w worlds, at least one. Vehicles of
            one world share the engine's model and data. The first one's record holds the rates and
            the movers of the world.
        counter: Number of worlds that are taken (1,), int64; 0 before the call.
    """
    # MuJoCo reads the system's clock before and after each stage, which costs a fifth of our step.
    # A null callback stops that; other users of MuJoCo get it back at the end.
    clock = pointers(plants[0, 0].engine.clock_address, 1)
    stage_clock, clock[0] = clock[0], 0
    while True:
        i = take_number(counter)
        if i >= len(plants):
            break
        _advance(plants[i])
    clock[0] = stage_clock


@kernel
def _advance(plants: np.ndarray) -> None:
    """Advance the vehicles of one world, `PLANT_DTYPE` (v,)."""
    lead = plants[0].engine
    for k in range(len(plants)):
        e = plants[k].engine
        e.contact_ticks = 0
        feel_surfaces(plants[k].surfaces, e, plants[k].rotors, doubles(e.qpos_address, 7))
    for i in range(lead.ticks_per_advance):
        for k in range(len(plants)):
            _command(plants[k])
        is_near_mover = lead.n_movers > 0 and _move_traffic(plants)
        if lead.is_held == 0:
            _step_physics(plants, is_near_mover)
        for k in range(len(plants)):
            _measure(plants[k], i)
    if lead.is_held == 0:
        # MuJoCo resets its state, and with it the clock, when a number becomes infinite or NaN. The
        # clock thus shows the loss, and needs no callback for warnings.
        late_s = doubles(lead.time_address, 1)[0] - lead.tick / lead.tick_hz
        for k in range(len(plants)):
            plants[k].engine.is_lost = abs(late_s) > MOST_LATE_S


@kernel
def _command(p: np.record) -> None:
    """Let the controller command the rotors for a control tick, and advance the air by it."""
    e, air = p.engine, p.air
    qpos, qvel = doubles(e.qpos_address, 7), doubles(e.qvel_address, 6)
    _write_state(p.state, e, p.filter, p.rotors, qpos, qvel)
    control(p.controller, p.setpoint, p.state, e.has_new_setpoint == 1)
    e.has_new_setpoint = 0
    e.is_touching = 0
    rooms = table(e.rooms_address, e.n_rooms, _N_ROOM_COLUMNS)
    nx, ny, nz = e.shelter_shape[0], e.shelter_shape[1], e.shelter_shape[2]
    shelter = doubles(e.shelter_address, 3 * nx * ny * nz).reshape(nx, ny, nz, 3)
    normals = doubles(e.normals_address, e.n_normals)
    first = air.first_normal + e.tick % e.tick_hz * AIR_NORMALS
    gusts = normals[first : first + AIR_NORMALS]
    # Wind shear and turbulence depend on the height above ground, not above the origin.
    height_m = qpos[2] - ground_m(e.rays, qpos[0], qpos[1])
    move_air(air, qpos[0:3], height_m, qvel[0:3], rooms, shelter, gusts, p.rotors.wind_enu_mps)


@kernel
def _measure(p: np.record, row: int) -> None:
    """Let the sensors measure and the filter estimate after the physics, then write the log."""
    e = p.engine
    qpos, qvel = doubles(e.qpos_address, 7), doubles(e.qvel_address, 6)
    e.contact_ticks += e.is_touching
    e.tick += 1
    if e.has_sensors == 1:
        rooms = table(e.rooms_address, e.n_rooms, _N_ROOM_COLUMNS)
        steel = table(e.steel_address, e.n_steel, _N_STEEL_COLUMNS)
        sense(p, qpos, qvel, rooms, steel, doubles(e.normals_address, e.n_normals))
        if p.filter.is_aligned == 0:
            align_when_ready(p.filter)
    history = rows(e.history_address, e.ticks_per_advance, HISTORY_DTYPE)
    _log(history[row], p, qpos, qvel)


@kernel
def _write_state(
    x: np.record, e: np.record, f: np.record, r: np.record, qpos: np.ndarray, qvel: np.ndarray
) -> None:
    """Write the state that the controller may know: the estimate, or the truth in benchmarks.

    The rotors' speeds come from the telemetry of their speed controllers in both cases.
    """
    is_true = e.knows_truth == 1
    for i in range(3):
        # The record still holds the velocity of the tick before, so this must precede its update.
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
def _move_traffic(plants: np.ndarray) -> bool:
    """Advance the movers of a world by a control tick; return true if a vehicle is near one."""
    e = plants[0].engine
    movers = rows(e.movers_address, e.n_movers, MOVER_DTYPE)
    geom_bits = integers(e.geom_bits_address, e.n_geoms)
    body_bits = integers(e.body_bits_address, e.n_bodies)
    move_traffic(
        plants[0].traffic,
        movers,
        table(e.mover_points_address, e.n_mover_points, 3),
        table(e.mocap_pos_address, e.n_movers, 3),
        table(e.mocap_quat_address, e.n_movers, 4),
        geom_bits,
        body_bits,
    )
    is_near = False
    for k in range(len(plants)):
        vehicle_enu_m = doubles(plants[k].engine.qpos_address, 3)
        is_near |= let_touch(movers, vehicle_enu_m, geom_bits, body_bits)
    return is_near


@kernel
def _step_physics(plants: np.ndarray, is_near_mover: bool) -> None:
    """Step to the next control tick, and note which vehicles touched something on the way."""
    lead = plants[0].engine
    for _ in range(lead.steps_per_tick):
        for k in range(len(plants)):
            e, r, c = plants[k].engine, plants[k].rotors, plants[k].controller
            # With an empty battery the rotors run down, whatever the controller commands.
            command = c.rotor_command_radps if e.has_power == 1 else e.no_command
            qpos, qvel = doubles(e.qpos_address, 7), doubles(e.qvel_address, 6)
            applied = doubles(e.applied_address, 6)
            step_rotors(r, command, qpos[3:7], qvel[0:3], qvel[3:6], applied)
        if not is_near_mover and is_free(plants):
            _step_freely(plants)
        else:
            _step_engine(plants)
    if lead.n_movers > 0 or len(plants) > 1:
        # Rays must hit vehicles and movers where they are now. A step leaves the poses of geoms as
        # they were before its integration, and free flight does not touch them at all.
        call_engine(lead.kinematics_address, lead.model_address, lead.data_address)


@kernel
def _step_freely(plants: np.ndarray) -> None:
    """Integrate all vehicles of a world over one step in which none has a contact."""
    for k in range(len(plants)):
        e, r = plants[k].engine, plants[k].rotors
        qpos, qvel = doubles(e.qpos_address, 7), doubles(e.qvel_address, 6)
        step_free(plants[k].free_flight, r, doubles(e.applied_address, 3), qpos, qvel)
    # The engine's clock must go on: `_advance` compares it with ours.
    doubles(plants[0].engine.time_address, 1)[0] += plants[0].free_flight.dt_s


@kernel
def _step_engine(plants: np.ndarray) -> None:
    """Let MuJoCo take a step, and note which vehicles had a contact."""
    lead = plants[0].engine
    call_engine(lead.step_address, lead.model_address, lead.data_address)
    for k in range(len(plants)):
        e = plants[k].engine
        constraint = doubles(e.constraint_address, 6)
        for n in range(6):
            # Without joint limits or friction, contacts are the only constraints of a free body.
            if constraint[n] != 0.0:
                e.is_touching = 1


@kernel
def _log(row: np.record, p: np.record, qpos: np.ndarray, qvel: np.ndarray) -> None:
    """Write one control tick into a row of the history."""
    e, r, imu, f, c, s = p.engine, p.rotors, p.imu, p.filter, p.controller, p.setpoint
    row.time_us = e.tick * e.tick_us
    row.setpoint_level = s.level
    row.is_touching = e.is_touching
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
