"""The memory of the plant: one record for each of its parts, and MuJoCo's own arrays."""

from __future__ import annotations

import mujoco
import numpy as np

from autonomy.control import CONTROLLER_DTYPE, SETPOINT_DTYPE, new_controller
from autonomy.control.cfg import controller_cfg_for
from autonomy.estimation import FILTER_DTYPE, new_filter
from autonomy.model.quadrotor import GRAVITY_MPS2
from flightsim.environment.magnetic_field import FIELD_ENU_UT
from flightsim.plant.cfg import ADVANCE_HZ, IMUS, PlantCfg, estimator_cfg_for
from flightsim.plant.mujoco_calls import function_addresses
from flightsim.plant.record import ENGINE_DTYPE, HISTORY_DTYPE, REPORT_DTYPE
from flightsim.sensors.barometer import BAROMETER_DTYPE, BAROMETER_NORMALS, new_barometer
from flightsim.sensors.gnss import GNSS_DTYPE, GNSS_NORMALS, GRADES, new_gnss
from flightsim.sensors.imu import IMU_DTYPE, IMU_NORMALS, new_imu
from flightsim.sensors.magnetometer import (
    MAGNETOMETER_DTYPE,
    MAGNETOMETER_NORMALS,
    new_magnetometer,
)
from flightsim.sensors.normals import NormalBlocks
from flightsim.sensors.rangefinder import (
    RANGEFINDER_DTYPE,
    RANGEFINDER_NORMALS,
    new_rangefinder,
)
from flightsim.vehicles.rotor_model import ROTORS_DTYPE, new_rotors
from flightsim.world import World

_N_SENSORS = 5


def example_arguments() -> tuple[np.ndarray, ...]:
    """Arrays of the types that the kernel takes, for compiling it without a world."""
    records = (
        ROTORS_DTYPE,
        IMU_DTYPE,
        GNSS_DTYPE,
        BAROMETER_DTYPE,
        MAGNETOMETER_DTYPE,
        RANGEFINDER_DTYPE,
        FILTER_DTYPE,
        CONTROLLER_DTYPE,
        SETPOINT_DTYPE,
    )
    return (
        np.zeros(1, ENGINE_DTYPE),
        *(np.zeros(n) for n in (7, 6, 6, 6)),
        *(np.zeros(1, dtype) for dtype in records),
        *(np.zeros((1, 1)) for _ in range(_N_SENSORS)),
        np.zeros(1, HISTORY_DTYPE),
        np.zeros(1, REPORT_DTYPE),
    )


class PlantMemory:
    """All that the kernel reads and writes."""

    def __init__(self, world: World, cfg: PlantCfg, data: mujoco.MjData) -> None:
        self._body = world.vehicle_body_id
        self._data = data
        joint = world.model.body_jntadr[self._body]
        q, v = world.model.jnt_qposadr[joint], world.model.jnt_dofadr[joint]
        self.qpos, self.qvel = data.qpos[q : q + 7], data.qvel[v : v + 6]
        self.tick_us = 1_000_000 // cfg.control_hz
        self.engines = _new_engine(world, cfg, data)
        self.history = np.zeros(cfg.control_hz // ADVANCE_HZ, HISTORY_DTYPE)
        self.reports = np.zeros(1, REPORT_DTYPE)
        self.report_flat = self.reports.view("f8")
        self.setpoints = np.zeros(1, SETPOINT_DTYPE)
        self.setpoint_flat = self.setpoints.view("f8")
        quadrotor = world.airframe.quadrotor
        self.rotors = new_rotors(
            quadrotor,
            world.airframe.body_size_m,
            dt_s=1.0 / cfg.physics_hz,
            axial_limit_mps=cfg.rotor_axial_limit_mps,
        )
        dt_s = 1.0 / cfg.control_hz
        gains = cfg.controller or controller_cfg_for(quadrotor)
        self.controllers = new_controller(quadrotor, gains, dt_s=dt_s)
        self.filters = new_filter(
            cfg.estimator or estimator_cfg_for(IMUS[cfg.imu]),
            dt_s=dt_s,
            field_enu_ut=FIELD_ENU_UT,
            gravity_mps2=GRAVITY_MPS2,
        )
        self._build_sensors(world, cfg)

    def _build_sensors(self, world: World, cfg: PlantCfg) -> None:
        hz = cfg.control_hz
        gnss = GRADES[cfg.gnss]
        imu_seed, gnss_seed, *seeds = np.random.SeedSequence(cfg.seed).spawn(2 + _N_SENSORS)
        self.imus = new_imu(
            IMUS[cfg.imu],
            np.random.default_rng(imu_seed),
            rate_hz=hz,
            quat_wxyz=self.qpos[3:7],
            velocity_enu_mps=self.qvel[:3],
        )
        self.receivers = new_gnss(gnss, np.random.default_rng(gnss_seed), tick_hz=hz)
        self.barometers = new_barometer(
            cfg.barometer, tick_hz=hz, origin_altitude_m=world.scene.altitude_m
        )
        self.magnetometers = new_magnetometer(
            cfg.magnetometer, tick_hz=hz, field_enu_ut=FIELD_ENU_UT
        )
        self.rangefinders = new_rangefinder(cfg.rangefinder, tick_hz=hz)
        self.normals = NormalBlocks(
            seeds,
            [
                (hz, IMU_NORMALS),
                (gnss.rate_hz, GNSS_NORMALS),
                (cfg.barometer.rate_hz, BAROMETER_NORMALS),
                (cfg.magnetometer.rate_hz, MAGNETOMETER_NORMALS),
                (cfg.rangefinder.rate_hz, RANGEFINDER_NORMALS),
            ],
        )

    def arguments(self) -> tuple[np.ndarray, ...]:
        """Arguments of `flightsim.plant.kernel.advance`, the same arrays for the whole run."""
        return (
            self.engines,
            self.qpos,
            self.qvel,
            self._data.xfrc_applied[self._body],
            self._data.qfrc_constraint,
            self.rotors,
            self.imus,
            self.receivers,
            self.barometers,
            self.magnetometers,
            self.rangefinders,
            self.filters,
            self.controllers,
            self.setpoints,
            *self.normals.blocks,
            self.history,
            self.reports,
        )

    def sensor(self, name: str) -> np.ndarray:
        """The record of a sensor that can be switched off."""
        return {
            "gnss": self.receivers,
            "baro": self.barometers,
            "mag": self.magnetometers,
            "range": self.rangefinders,
        }[name]

    def describe_start(self) -> None:
        """Write the report of time zero, before anything has been measured."""
        report = self.reports[0]
        report["position_true"] = self.qpos[:3]
        report["quat_true"] = self.qpos[3:7]
        report["quat_est"][0] = 1.0
        report["terrain_height"] = np.nan
        report["range"] = np.nan
        for name in ("gnss_tick", "baro_tick", "mag_tick"):
            report[name] = -1.0


def _new_engine(world: World, cfg: PlantCfg, data: mujoco.MjData) -> np.ndarray:
    engines = np.zeros(1, ENGINE_DTYPE)
    e = engines[0]
    e["tick_us"] = 1_000_000 // cfg.control_hz
    e["tick_hz"] = cfg.control_hz
    e["steps_per_tick"] = cfg.physics_hz // cfg.control_hz
    e["ticks_per_advance"] = cfg.control_hz // ADVANCE_HZ
    e["has_power"] = 1
    e["step_address"], e["ray_address"] = function_addresses()
    e["model_address"] = world.model._address
    e["data_address"] = data._address
    e["vehicle_body"] = world.vehicle_body_id
    return engines
