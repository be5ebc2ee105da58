"""One advance of the plant: the hot loop of the simulator, compiled as a whole.

Each control tick: controller, physics steps with the rotors' wrench, sensors, estimator, log.
"""

from __future__ import annotations

import numpy as np

from autonomy.control.controller import control
from autonomy.estimation.alignment import align_when_ready, collect_imu, collect_vector
from autonomy.estimation.fusion import fuse_barometer, fuse_magnetometer
from autonomy.estimation.predict import predict
from autonomy.estimation.terrain import fuse_range
from autonomy.estimation.wind import fuse_drag
from autonomy.jit import kernel
from flightsim.environment.air import move_air
from flightsim.environment.motion import move_traffic
from flightsim.plant.aiding import sense_pose, sense_satellites
from flightsim.plant.mujoco_calls import call_mj_ray, call_mj_step
from flightsim.sensors.barometer import sample_barometer
from flightsim.sensors.imu import sample_imu
from flightsim.sensors.magnetometer import sample_magnetometer
from flightsim.sensors.rangefinder import aim_ray, sample_rangefinder
from flightsim.vehicles.rotor_model import step_rotors


@kernel
def advance(
    engines: np.ndarray,
    qpos: np.ndarray,
    qvel: np.ndarray,
    applied: np.ndarray,
    constraint: np.ndarray,
    rotors: np.ndarray,
    airs: np.ndarray,
    traffic: np.ndarray,
    movers: np.ndarray,
    mover_points: np.ndarray,
    mocap_pos: np.ndarray,
    mocap_quat: np.ndarray,
    geom_conaffinity: np.ndarray,
    body_conaffinity: np.ndarray,
    imus: np.ndarray,
    receivers: np.ndarray,
    barometers: np.ndarray,
    magnetometers: np.ndarray,
    rangefinders: np.ndarray,
    vios: np.ndarray,
    mocaps: np.ndarray,
    rooms: np.ndarray,
    filters: np.ndarray,
    states: np.ndarray,
    controllers: np.ndarray,
    setpoints: np.ndarray,
    imu_normals: np.ndarray,
    gnss_normals: np.ndarray,
    baro_normals: np.ndarray,
    mag_normals: np.ndarray,
    range_normals: np.ndarray,
    vio_normals: np.ndarray,
    mocap_normals: np.ndarray,
    air_normals: np.ndarray,
    history: np.ndarray,
    reports: np.ndarray,
) -> None:
    """Advance by 20 ms.

    Args:
        engines: `ENGINE_DTYPE`; this and every other record comes in an array of shape (1,).
        qpos: Pose of the vehicle (7,), MuJoCo's own memory, as the next three.
        qvel: Its velocity (6,): linear in the world, angular in the body.
        applied: Wrench on its body (6,), written here.
        constraint: Constraint forces (nv,); non-zero while it touches something.
        rotors: `ROTORS_DTYPE`.
        airs: `AIR_DTYPE`.
        traffic: `TRAFFIC_DTYPE`.
        movers: `MOVER_DTYPE`, a row for each moving obstacle, as the next three.
        mover_points: Control points of their paths (k, 3).
        mocap_pos: MuJoCo's poses of their bodies (n, 3), written here.
        mocap_quat: The same (n, 4).
        geom_conaffinity: What the model's geoms may touch, written for movers.
        body_conaffinity: The same of its bodies.
        imus: `IMU_DTYPE`.
        receivers: `GNSS_DTYPE`.
        barometers: `BAROMETER_DTYPE`.
        magnetometers: `MAGNETOMETER_DTYPE`.
        rangefinders: `RANGEFINDER_DTYPE`.
        vios: `VIO_DTYPE`.
        mocaps: `MOCAP_DTYPE`.
        rooms: Without satellites and wind (n, 8), `flightsim.environment.rooms`.
        filters: `FILTER_DTYPE`.
        states: `STATE_DTYPE`.
        controllers: `CONTROLLER_DTYPE`.
        setpoints: `SETPOINT_DTYPE`.
        imu_normals: Standard normals for one second, a row for each sample, as the next six.
        gnss_normals: For the receiver.
        baro_normals: For the barometer.
        mag_normals: For the magnetometer.
        range_normals: For the rangefinder.
        vio_normals: For visual-inertial odometry.
        mocap_normals: For motion capture.
        air_normals: For turbulence.
        history: `HISTORY_DTYPE`, a row for each control tick.
        reports: `REPORT_DTYPE`, written at the end.
    """
    e, r, f, c, s = engines[0], rotors[0], filters[0], controllers[0], setpoints[0]
    imu, gnss, baro = imus[0], receivers[0], barometers[0]
    mag, rangefinder = magnetometers[0], rangefinders[0]
    vio, mocap = vios[0], mocaps[0]
    x = states[0]
    e.contact_ticks = 0
    for i in range(e.ticks_per_advance):
        _tell_state(x, e, f, qpos, qvel)
        control(c, s, x, e.has_new_setpoint == 1)
        e.has_new_setpoint = 0
        gusts = air_normals[e.tick % e.tick_hz]
        move_air(airs[0], qpos[0:3], qvel[0:3], rooms, gusts, r.wind_enu_mps)
        if len(movers) > 0:
            move_traffic(
                traffic[0],
                movers,
                mover_points,
                qpos[0:3],
                mocap_pos,
                mocap_quat,
                geom_conaffinity,
                body_conaffinity,
            )
        is_touching = _step_physics(e, r, c, qpos, qvel, applied, constraint)
        e.contact_ticks += is_touching
        e.tick += 1
        sample_imu(imu, qpos[3:7], qvel[0:3], imu_normals[(e.tick - 1) % e.tick_hz])
        if f.is_aligned == 1:
            predict(f, imu.accel_flu_mps2, imu.gyro_flu_radps)
            fuse_drag(f, imu.accel_flu_mps2, r.speed_radps)
        else:
            collect_imu(f, imu.accel_flu_mps2, imu.gyro_flu_radps)
        sense_satellites(e, f, gnss, rooms, qpos, qvel, gnss_normals)
        sense_pose(e, f, vio, mocap, qpos, vio_normals, mocap_normals)
        _sense_pressure(e, f, baro, qpos, baro_normals)
        _sense_field_and_range(e, f, mag, rangefinder, qpos, mag_normals, range_normals)
        if f.is_aligned == 0:
            align_when_ready(f)
        _log(history[i], e, qpos, qvel, r, imu, f, c, s, is_touching)
    reports[0].contact_ticks = e.contact_ticks
    _report(reports[0], history[-1], f, c)
    _report_sensors(reports[0], imu, gnss, baro, mag, rangefinder)


@kernel
def _tell_state(
    x: np.record, e: np.record, f: np.record, qpos: np.ndarray, qvel: np.ndarray
) -> None:
    """What the controller may know: the estimate, or the truth for benchmarks of control alone."""
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
def _step_physics(
    e: np.record,
    r: np.record,
    c: np.record,
    qpos: np.ndarray,
    qvel: np.ndarray,
    applied: np.ndarray,
    constraint: np.ndarray,
) -> int:
    """Step to the next control tick; 1 if the vehicle touched something on the way."""
    command = c.rotor_command_radps if e.has_power == 1 else e.no_command
    is_touching = 0
    for _ in range(e.steps_per_tick):
        step_rotors(r, command, qpos[3:7], qvel[0:3], qvel[3:6], applied)
        call_mj_step(e.step_address, e.model_address, e.data_address)
        for k in range(len(constraint)):
            if constraint[k] != 0.0:
                is_touching = 1
    return is_touching


@kernel
def _is_due(e: np.record, period_ticks: int) -> bool:
    return e.tick % period_ticks == 0


@kernel
def _row(e: np.record, period_ticks: int) -> int:
    """Which of the second's normals belongs to the sample of this tick."""
    return (e.tick - 1) % e.tick_hz // period_ticks


@kernel
def _sense_pressure(
    e: np.record, f: np.record, baro: np.record, qpos: np.ndarray, baro_normals: np.ndarray
) -> None:
    if _is_due(e, baro.period_ticks) and baro.is_enabled == 1:
        sample_barometer(baro, e.tick, qpos[2], baro_normals[_row(e, baro.period_ticks)])
        if f.is_aligned == 1:
            fuse_barometer(f, baro.altitude_m)
        else:
            f.baro_sum += baro.altitude_m
            f.n_baro += 1


@kernel
def _sense_field_and_range(
    e: np.record,
    f: np.record,
    mag: np.record,
    rangefinder: np.record,
    qpos: np.ndarray,
    mag_normals: np.ndarray,
    range_normals: np.ndarray,
) -> None:
    if _is_due(e, mag.period_ticks) and mag.is_enabled == 1:
        sample_magnetometer(mag, e.tick, qpos[3:7], mag_normals[_row(e, mag.period_ticks)])
        if f.is_aligned == 1:
            fuse_magnetometer(f, mag.field_flu_ut)
        else:
            collect_vector(f.mag_sum, mag.field_flu_ut)
            f.n_mag += 1
    if _is_due(e, rangefinder.period_ticks) and rangefinder.is_enabled == 1:
        aim_ray(rangefinder, qpos[0:3], qpos[3:7])
        distance = call_mj_ray(
            e.ray_address,
            e.model_address,
            e.data_address,
            rangefinder.ray.ctypes.data,
            rangefinder.ray[3:].ctypes.data,
            e.vehicle_body,
            e.ray_geom.ctypes.data,
        )
        row = range_normals[_row(e, rangefinder.period_ticks)]
        sample_rangefinder(rangefinder, e.tick, distance, row)
        if f.is_aligned == 1:
            fuse_range(f, rangefinder.range_m, rangefinder.period_ticks * f.dt_s)


@kernel
def _log(
    row: np.record,
    e: np.record,
    qpos: np.ndarray,
    qvel: np.ndarray,
    r: np.record,
    imu: np.record,
    f: np.record,
    c: np.record,
    s: np.record,
    is_touching: int,
) -> None:
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


@kernel
def _report(report: np.record, row: np.record, f: np.record, c: np.record) -> None:
    for i in range(3):
        report.position_true[i] = row.position_true_enu_m[i]
        report.velocity_true[i] = row.velocity_true_enu_mps[i]
        report.rate_true[i] = row.angular_rate_true_flu_radps[i]
        report.position_est[i] = f.position_enu_m[i]
        report.velocity_est[i] = f.velocity_enu_mps[i]
        report.rate_est[i] = f.angular_rate_flu_radps[i]
        report.gyro_bias[i] = f.gyro_bias_flu_radps[i]
        report.accel_bias[i] = f.accel_bias_flu_mps2[i]
    for i in range(4):
        report.quat_true[i] = row.quat_true_wxyz[i]
        report.quat_est[i] = f.quat_wxyz[i]
        report.rotor_speed[i] = row.rotor_speed_radps[i]
        report.rotor_command[i] = c.rotor_command_radps[i]
    for i in range(len(report.variance)):
        report.variance[i] = f.covariance[i, i]
    report.thrust_fraction = c.thrust_fraction
    report.terrain_height = f.terrain_height_m
    report.is_aligned = f.is_aligned
    report.gnss_age_ticks = f.tick - f.last_gnss_tick
    report.wind[0] = f.wind_enu_mps[0]
    report.wind[1] = f.wind_enu_mps[1]
    report.ratios[0] = f.ratio_gnss_position
    report.ratios[1] = f.ratio_gnss_velocity
    report.ratios[2] = f.ratio_baro
    report.ratios[3] = f.ratio_heading


@kernel
def _report_sensors(
    report: np.record,
    imu: np.record,
    gnss: np.record,
    baro: np.record,
    mag: np.record,
    rangefinder: np.record,
) -> None:
    for i in range(3):
        report.accel[i] = imu.accel_flu_mps2[i]
        report.gyro[i] = imu.gyro_flu_radps[i]
        report.gnss_position[i] = gnss.position_enu_m[i]
        report.gnss_velocity[i] = gnss.velocity_enu_mps[i]
        report.field[i] = mag.field_flu_ut[i]
    report.gnss_tick = gnss.tick
    report.gnss_settling = gnss.settling_sigma_m
    report.hears_satellites = gnss.under_sky_ticks >= gnss.reacquire_ticks
    report.baro_tick = baro.tick
    report.mag_tick = mag.tick
    report.pressure = baro.pressure_pa
    report.pressure_altitude = baro.altitude_m
    report.temperature = baro.temperature_degc
    report.range = rangefinder.range_m
