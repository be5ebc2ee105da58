"""The memory of the plant: one record for each of its parts, and MuJoCo's own arrays."""

from __future__ import annotations

import mujoco
import numpy as np

from autonomy.control import CONTROLLER_DTYPE, SETPOINT_DTYPE, STATE_DTYPE, new_controller
from autonomy.control.cfg import controller_cfg_for
from autonomy.estimation import FILTER_DTYPE, new_filter
from autonomy.model.quadrotor import GRAVITY_MPS2
from flightsim.environment.air import AIR_DTYPE, AIR_NORMALS, new_air, set_wind
from flightsim.environment.magnetic_field import FIELD_ENU_UT
from flightsim.environment.motion import (
    MOVER_DTYPE,
    TRAFFIC_DTYPE,
    new_movers,
    new_traffic,
    place_mover,
)
from flightsim.environment.rooms import ROOM_COLUMNS, indoor_rooms
from flightsim.environment.wind import WindCfg
from flightsim.looks.movers import MOVER_CONTACT_BIT
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
from flightsim.sensors.mocap import MOCAP_DTYPE, MOCAP_NORMALS, new_mocap
from flightsim.sensors.normals import NormalBlocks
from flightsim.sensors.rangefinder import (
    RANGEFINDER_DTYPE,
    RANGEFINDER_NORMALS,
    new_rangefinder,
)
from flightsim.sensors.vio import VIO_DTYPE, VIO_NORMALS, new_vio
from flightsim.vehicles.rotor_model import ROTORS_DTYPE, drag_model, new_rotors
from flightsim.world import World

_N_SENSORS = 7


def example_arguments() -> tuple[np.ndarray, ...]:
    """Arrays of the types that the kernel takes, for compiling it without a world."""
    bits = np.zeros(1, dtype=np.int32)
    records = (
        IMU_DTYPE,
        GNSS_DTYPE,
        BAROMETER_DTYPE,
        MAGNETOMETER_DTYPE,
        RANGEFINDER_DTYPE,
        VIO_DTYPE,
        MOCAP_DTYPE,
    )
    loops = (FILTER_DTYPE, STATE_DTYPE, CONTROLLER_DTYPE, SETPOINT_DTYPE)
    return (
        np.zeros(1, ENGINE_DTYPE),
        *(np.zeros(n) for n in (7, 6, 6, 6)),
        *(np.zeros(1, dtype) for dtype in (ROTORS_DTYPE, AIR_DTYPE, TRAFFIC_DTYPE, MOVER_DTYPE)),
        *(np.zeros((1, n)) for n in (3, 3, 4)),
        *(bits, bits),
        *(np.zeros(1, dtype) for dtype in records),
        np.zeros((1, len(ROOM_COLUMNS))),
        *(np.zeros(1, dtype) for dtype in loops),
        *(np.zeros((1, 1)) for _ in range(_N_SENSORS + 1)),
        np.zeros(1, HISTORY_DTYPE),
        np.zeros(1, REPORT_DTYPE),
    )


class PlantMemory:
    """All that the kernel reads and writes."""

    def __init__(self, world: World, cfg: PlantCfg, data: mujoco.MjData) -> None:
        self._body = world.vehicle_body_id
        self._data, self._model = data, world.model
        joint = world.model.body_jntadr[self._body]
        q, v = world.model.jnt_qposadr[joint], world.model.jnt_dofadr[joint]
        self.qpos, self.qvel = data.qpos[q : q + 7], data.qvel[v : v + 6]
        self.tick_us = 1_000_000 // cfg.control_hz
        self.engines = _new_engine(world, cfg, data)
        self.history = np.zeros(cfg.control_hz // ADVANCE_HZ, HISTORY_DTYPE)
        self.traffic = new_traffic(1.0 / cfg.control_hz)
        self.movers, self.mover_points = new_movers(world.obstacles)
        self._name_movers(world)
        self.reports = np.zeros(1, REPORT_DTYPE)
        self.report_flat = self.reports.view("f8")
        self.states = np.zeros(1, STATE_DTYPE)
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
        self._build_sensors(world, cfg)

    def _name_movers(self, world: World) -> None:
        """Tell the movers which bodies and geoms of the model are theirs."""
        for index, mover in enumerate(self.movers):
            mover["body"] = world.mover_body_id(index)
            mover["geom"] = world.model.body_geomadr[mover["body"]]
            mover["contact_bits"] = MOVER_CONTACT_BIT
            place_mover(mover, self.mover_points, 0.0, 1.0)

    def draw_normals(self) -> None:
        """Draw the noise of the next second."""
        self.normals.draw()
        if self.airs["turbulence_mps"][0] > 0.0:
            self.air_normals.draw()

    def set_wind(self, cfg: WindCfg) -> None:
        """Let another wind blow from the next advance on."""
        was_smooth = self.airs["turbulence_mps"][0] == 0.0
        set_wind(self.airs, cfg, has_rooms=len(self.rooms) > 0)
        self.rotors["wind_enu_mps"][0] = cfg.steady_enu_mps
        if was_smooth and cfg.turbulence_mps > 0.0:
            self.air_normals.draw()

    def _build_aiding(
        self, world: World, cfg: PlantCfg, start_seed: np.random.SeedSequence
    ) -> None:
        """The filter, and what tells it where it is beside the receiver."""
        position, quat, dt_s = self.qpos[:3], self.qpos[3:7], 1.0 / cfg.control_hz
        estimator = cfg.estimator or estimator_cfg_for(cfg)
        start = np.random.default_rng(start_seed).normal(position, estimator.start_sigma_m)
        self.filters = new_filter(
            estimator,
            dt_s=dt_s,
            field_enu_ut=FIELD_ENU_UT,
            gravity_mps2=GRAVITY_MPS2,
            drag=drag_model(world.airframe.quadrotor, world.airframe.body_size_m),
            start_enu_m=None if cfg.aiding == "gnss" else tuple(start.tolist()),
        )
        self.vios = new_vio(
            cfg.vio, tick_hz=cfg.control_hz, position_enu_m=position, quat_wxyz=quat
        )
        self.mocaps = new_mocap(cfg.mocap, tick_hz=cfg.control_hz)
        self.rooms = indoor_rooms(world.scene)
        self.receivers["is_enabled"] = cfg.has_gnss
        self.vios["is_enabled"] = cfg.aiding in ("vio", "auto")
        self.mocaps["is_enabled"] = cfg.aiding == "mocap"

    def _build_sensors(self, world: World, cfg: PlantCfg) -> None:
        hz = cfg.control_hz
        gnss = GRADES[cfg.gnss]
        children = np.random.SeedSequence(cfg.seed).spawn(2 + _N_SENSORS + 3)
        imu_seed, gnss_seed, *seeds = children[: 2 + _N_SENSORS]
        air_seed, first_air_seed, start_seed = children[2 + _N_SENSORS :]
        self.airs = new_air(np.random.default_rng(first_air_seed), dt_s=1.0 / hz)
        self.air_normals = NormalBlocks([air_seed], [(hz, AIR_NORMALS)])
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
                (cfg.vio.rate_hz, VIO_NORMALS),
                (cfg.mocap.rate_hz, MOCAP_NORMALS),
            ],
        )
        self._build_aiding(world, cfg, start_seed)

    def arguments(self) -> tuple[np.ndarray, ...]:
        """Arguments of `flightsim.plant.kernel.advance`, the same arrays for the whole run."""
        return (
            self.engines,
            self.qpos,
            self.qvel,
            self._data.xfrc_applied[self._body],
            self._data.qfrc_constraint,
            self.rotors,
            self.airs,
            self.traffic,
            self.movers,
            self.mover_points,
            self._data.mocap_pos,
            self._data.mocap_quat,
            self._model.geom_conaffinity,
            self._model.body_conaffinity,
            self.imus,
            self.receivers,
            self.barometers,
            self.magnetometers,
            self.rangefinders,
            self.vios,
            self.mocaps,
            self.rooms,
            self.filters,
            self.states,
            self.controllers,
            self.setpoints,
            *self.normals.blocks,
            *self.air_normals.blocks,
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
            "vio": self.vios,
            "mocap": self.mocaps,
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
    e["knows_truth"] = cfg.state == "truth"
    e["step_address"], e["ray_address"] = function_addresses()
    e["model_address"] = world.model._address
    e["data_address"] = data._address
    e["vehicle_body"] = world.vehicle_body_id
    return engines
