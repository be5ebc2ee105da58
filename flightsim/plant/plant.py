"""The plant: everything that runs faster than 50 Hz, behind a call every 20 ms.

Physics, rotors, sensors, estimator and controller run in one kernel (`flightsim.plant.kernel`).
Its memory is a few records; what Python reads of it is built when asked for.
"""

from __future__ import annotations

import logging
import math
from dataclasses import replace

import numpy as np

from autonomy.control.record import setpoint_row
from autonomy.jit import compile_ahead
from autonomy.types import OFF, ControlLevel, Setpoint, State, Vector3
from flightsim.environment.motion import MAX_RATE
from flightsim.environment.movers import MOVER_KINDS, MoverName, ObstacleStates
from flightsim.environment.wind import WindCfg
from flightsim.plant.cfg import (
    ADVANCE_HZ,
    NotAlignedError,
    PhysicsDivergedError,
    PlantCfg,
    PlantError,
)
from flightsim.plant.kernel import advance
from flightsim.plant.memory import PlantMemory, example_arguments
from flightsim.plant.readings import EstimatorStatus, Report
from flightsim.plant.record import report_slices
from flightsim.plant.sensing import SENSORS, SensorReadings
from flightsim.sensors.imu import IMU
from flightsim.vehicles.battery import Battery
from flightsim.world import World

_LOG = logging.getLogger(__name__)
_COMPILE_SECONDS = 12.0
_ADVANCE_US = 1_000_000 // ADVANCE_HZ


class Plant:
    """A vehicle in its world, from setpoints to what its sensors and its estimator say.

    Deterministic: the same world, configuration and setpoints give the same history, bit for bit.
    """

    def __init__(self, world: World, cfg: PlantCfg) -> None:
        """Put a vehicle at rest at the world's start.

        Raises:
            PlantError: If the world has no vehicle or the configured rates do not fit.
        """
        if world.vehicle_body_id < 0:
            raise PlantError("world: it has no vehicle, build it with vehicle=True")
        cfg.check(world.model.opt.timestep)
        compile_kernels()
        self.world = world
        self.cfg = cfg
        self.data = world.new_data()
        self.battery = Battery(world.airframe.battery)
        self.time_us = 0
        """Simulated time."""
        self.contact_ticks = 0
        """Control ticks of the last advance in which the vehicle touched something."""
        self.total_contact_ticks = 0
        self.n_refused_setpoints = 0
        self._n_advances = 0
        self._memory = PlantMemory(world, cfg, self.data)
        self._arguments = self._memory.arguments()
        self._report_slices = report_slices()
        self.sensors = SensorReadings(self._memory.plant, self._memory.tick_us)
        """Latest reading of each sensor."""
        self.history = self._memory.history
        """The last advance, a row for each control tick (`flightsim.plant.record`)."""
        self._memory.describe_start()
        self._read_report()
        self.wind = cfg.wind
        self.apply(OFF)

    def advance(self) -> None:
        """Advance by 20 ms.

        Raises:
            PhysicsDivergedError: If the physics engine had to give the state up.
        """
        if self._n_advances % ADVANCE_HZ == 0:
            self._memory.draw_normals()
        advance(*self._arguments)
        self._n_advances += 1
        self.time_us += _ADVANCE_US
        if abs(self.data.time - 1e-6 * self.time_us) > 1e-3:
            raise PhysicsDivergedError(
                f"the physics engine reset itself before t = {1e-6 * self.time_us:.2f} s: "
                "its state had become infinite or not a number"
            )
        self._read_report()
        self.contact_ticks = int(self._report.scalar("contact_ticks"))
        self.total_contact_ticks += self.contact_ticks
        self.battery.step(self.rotor_speeds_radps, 1.0 / ADVANCE_HZ)
        if self.battery.remaining <= 0.0:
            self._memory.plant["engine"]["has_power"] = 0

    def _read_report(self) -> None:
        self._report = Report(
            self._memory.report_flat.tolist(),
            self._report_slices,
            self.time_us,
            self._memory.tick_us,
        )
        self._truth = self._estimate = self._status = None

    @property
    def is_aligned(self) -> bool:
        """Whether the controller knows the vehicle's state: by the estimator, or as the truth."""
        return self.cfg.state == "truth" or self._report.scalar("is_aligned") == 1.0

    def align(self, timeout_s: float = 10.0) -> None:
        """Rest until the estimator is aligned, which takes about a second.

        Raises:
            NotAlignedError: If it is not within `timeout_s` of simulated time.
        """
        end_us = self.time_us + round(1e6 * timeout_s)
        self.apply(OFF)
        while not self.is_aligned:
            if self.time_us >= end_us:
                raise NotAlignedError(
                    f"the estimator is not aligned after {timeout_s:g} s: it needs a vehicle at "
                    "rest, a barometer, a magnetometer, and satellites where aiding = 'gnss'"
                )
            self.advance()

    def apply(self, setpoint: Setpoint) -> None:
        """Follow this setpoint from the next advance on.

        One that is not a number where it matters, at `ATTITUDE` or `RATE`, is refused: the setpoint
        before stays, and `n_refused_setpoints` counts.

        Raises:
            NotAlignedError: If it asks for more than idling before the estimator is aligned.
        """
        if setpoint.level >= ControlLevel.TRAJECTORY and not self.is_aligned:
            raise NotAlignedError(
                f"setpoint at level {setpoint.level.name} after {1e-6 * self.time_us:.2f} s: the "
                "estimator is not aligned yet; valid: OFF and IDLE, or call align() before"
            )
        if setpoint.level >= ControlLevel.ATTITUDE:
            setpoint_or_none = _normalised(setpoint)
            if setpoint_or_none is None:
                self.n_refused_setpoints += 1
                if self.n_refused_setpoints == 1:
                    _LOG.warning("setpoint refused, not finite: %s", setpoint)
                return
            setpoint = setpoint_or_none
        self._memory.setpoint_flat[:] = setpoint_row(setpoint)
        self._memory.plant["engine"]["has_new_setpoint"] = 1

    @property
    def truth(self) -> State:
        """True state now."""
        if self._truth is None:
            self._truth = self._report.state("true")
        return self._truth

    @property
    def estimate(self) -> State:
        """Estimated state now; all zero and level until the filter is aligned."""
        if self._estimate is None:
            self._estimate = self._report.state("est")
        return self._estimate

    @property
    def estimator(self) -> EstimatorStatus:
        """Health of the estimate."""
        if self._status is None:
            self._status = self._report.estimator()
        return self._status

    @property
    def rotor_speeds_radps(self) -> tuple[float, float, float, float]:
        """True rotor speeds."""
        return self._report.vector("rotor_speed")

    @property
    def rotor_speed_commands_radps(self) -> tuple[float, float, float, float]:
        """Speeds last commanded."""
        return self._report.vector("rotor_command")

    @property
    def collective_thrust_fraction(self) -> float:
        """Commanded collective thrust over its maximum, 0 to 1."""
        return self._report.scalar("thrust_fraction")

    @property
    def terrain_height_est_m(self) -> float:
        """Estimated ENU height of the surface below; NaN before the first range."""
        return self._report.scalar("terrain_height")

    @property
    def wind_est_enu_mps(self) -> tuple[float, float]:
        """Estimated velocity of the air, east and north; zero before the first flight."""
        return self._report.vector("wind")

    @property
    def filter(self) -> np.void:
        """The filter's own record (`autonomy.estimation.error_state`), for those who judge it."""
        return self._memory.plant["filter"]

    @property
    def reference(self) -> tuple[Vector3, Vector3]:
        """Position and velocity that the controller tracks just now, ENU."""
        row = self.history[-1]
        return (
            tuple(row["reference_position_enu_m"].tolist()),
            tuple(row["reference_velocity_enu_mps"].tolist()),
        )

    @property
    def wind(self) -> WindCfg:
        """What wind blows; set it to let another blow from the next advance on."""
        return self._wind

    @wind.setter
    def wind(self, cfg: WindCfg) -> None:
        self._wind = cfg
        self._memory.set_wind(cfg)

    @property
    def air_velocity_true_enu_mps(self) -> Vector3:
        """Velocity of the air now: wind, turbulence and gusts."""
        east, north, up = self._memory.plant["rotors"]["wind_enu_mps"].tolist()
        return (east, north, up)

    @property
    def obstacles_true(self) -> ObstacleStates:
        """Where everything that moves by itself is now."""
        movers = self._memory.movers
        kinds: tuple[MoverName, ...] = tuple(obstacle.kind for obstacle in self.world.obstacles)
        size_m = np.array([MOVER_KINDS[kind].size_m for kind in kinds]).reshape(-1, 3)
        return ObstacleStates(
            kinds=kinds,
            position_enu_m=movers["position_enu_m"] + size_m * (0.0, 0.0, 0.5),
            velocity_enu_mps=movers["velocity_enu_mps"].copy(),
            yaw_rad=movers["yaw_rad"].copy(),
            size_m=size_m,
        )

    @property
    def traffic_speed(self) -> float:
        """How fast the movers' time runs, 1 as it is and 0 not at all; it changes gradually."""
        return float(self._memory.plant["traffic"]["rate_cmd"])

    @traffic_speed.setter
    def traffic_speed(self, rate: float) -> None:
        if not 0.0 <= rate <= MAX_RATE:
            raise PlantError(f"traffic_speed = {rate}: 0 to {MAX_RATE:g} are valid")
        self._memory.plant["traffic"]["rate_cmd"] = rate

    def set_rotor_effectiveness(self, rotor: int, effectiveness: float) -> None:
        """Let a rotor (0 to 3) make only this share, 0 to 1, of its thrust and torque.

        Raises:
            PlantError: If there is no such rotor or share.
        """
        if rotor not in range(4) or not 0.0 <= effectiveness <= 1.0:
            raise PlantError(
                f"rotor = {rotor}, effectiveness = {effectiveness}: 0 to 3 and 0 to 1 are valid"
            )
        self._memory.plant["rotors"]["effectiveness"][rotor] = effectiveness

    def set_sensor_enabled(self, sensor: str, *, is_enabled: bool) -> None:
        """Switch a sensor off or on again; one that is off keeps its last reading and its time.

        Raises:
            PlantError: If there is no such sensor that can be switched off.
        """
        names = [s.name for s in SENSORS if s is not IMU]
        if sensor not in names:
            raise PlantError(f"sensor = {sensor!r}: valid are {', '.join(names)}")
        self._memory.plant[sensor]["is_enabled"] = int(is_enabled)


def compile_kernels() -> None:
    """Compile the flight kernels now, or load them from the cache; says so if it takes long."""
    compile_ahead(advance, example_arguments(), "flight kernels", _COMPILE_SECONDS)


def _normalised(setpoint: Setpoint) -> Setpoint | None:
    """The same attitude or rate setpoint with a unit quaternion, None if it is not finite."""
    w, x, y, z = setpoint.quat_wxyz
    norm = math.sqrt(w * w + x * x + y * y + z * z)
    total = setpoint.thrust + norm + sum(setpoint.angular_rate_flu_radps)
    if not math.isfinite(total) or norm < 1e-3:
        return None
    return replace(setpoint, quat_wxyz=(w / norm, x / norm, y / norm, z / norm))
