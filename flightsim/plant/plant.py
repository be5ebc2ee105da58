"""The plant: everything that runs faster than 50 Hz, behind a call every 20 ms.

`Plant` is the Python face of one kernel call (`flightsim.plant.kernel`). It writes setpoints into
the plant's record before the call, and reads states and sensors from it afterwards, when somebody
asks.
"""

from __future__ import annotations

import logging
from collections.abc import Callable

import numpy as np

from autonomy.control.record import setpoint_row
from autonomy.types import OFF, ControlLevel, Quaternion, Setpoint, State, Vector3, vector3
from flightsim.environment.motion import MAX_RATE, obstacle_states
from flightsim.environment.movers import ObstacleStates
from flightsim.environment.wind import WindCfg
from flightsim.plant.cfg import NotAlignedError, PhysicsDivergedError, PlantCfg, PlantError
from flightsim.plant.checks import check_worlds, normalised, unaligned
from flightsim.plant.compilation import compile_kernels
from flightsim.plant.external_aids import ExternalAids
from flightsim.plant.failures import Failures
from flightsim.plant.handover import Handover
from flightsim.plant.kernel import advance
from flightsim.plant.memory import PlantMemory, new_memories
from flightsim.plant.readings import EstimatorStatus, estimator_status
from flightsim.plant.record import with_rotors
from flightsim.plant.relocation import relocate
from flightsim.plant.sensing import SensorReadings
from flightsim.vehicles.battery import Battery
from flightsim.world import World

_LOG = logging.getLogger(__name__)
_ESTIMATE = ("position_enu_m", "velocity_enu_mps", "quat_wxyz", "angular_rate_flu_radps")


class Plant:
    """A vehicle in its world, from setpoints to readings of its sensors and its estimator.

    It is deterministic: the same world, configuration and setpoints give the same history, bit for
    bit. The vehicles of one world share one state of the physics engine, so that they meet: they
    touch each other, and the rays of one hit the others. The first one draws the noise that it
    would draw alone, and all share its movers.

    Attributes:
        other_plants: The other vehicles of the world, which advance together with this one.
    """

    def __init__(self, world: World, cfg: PlantCfg, *, memory: PlantMemory | None = None) -> None:
        """Put the first vehicle of a world at rest at its start, and the others at theirs.

        Args:
            world: World as its first vehicle has it, from `build_world`.
            cfg: Configuration of all its vehicles.
            memory: Memory of a mate, whose plant the first vehicle's makes; None makes that of all.

        Raises:
            PlantError: If the world has no vehicle, or the configured rates do not fit.
        """
        others: list[PlantMemory] = []
        if memory is None:
            check_worlds([world], [cfg])
            compile_kernels()
            memory, *others = new_memories(world.views, cfg, world.new_data())
        self.world, self.cfg = world, cfg
        self.data = memory.data
        self.battery = Battery(world.airframe.battery)
        self.time_us = 0
        """Simulated time."""
        self.contact_ticks = 0
        """Control ticks of the last advance in which the vehicle touched something."""
        self.total_contact_ticks = self.n_refused_setpoints = 0
        self._n_advances = 0
        self._handover: Handover | None = None
        self._memory = memory
        self._row, self._counter = memory.row.reshape(1, -1), np.zeros(1, np.int64)
        self._advance_us = 1_000_000 // cfg.advance_hz
        self._record = memory.plant
        self._engine: np.void = self._record["engine"]
        self._controller: np.void = self._record["controller"]
        self._filter: np.void = self._record["filter"]
        n = len(world.airframe.quadrotor.rotors)
        self._rotor_speeds: np.ndarray = self._record["rotors"]["speed_radps"][:n]
        self._rotor_commands: np.ndarray = self._controller["rotor_command_radps"][:n]
        qpos, qvel = memory.qpos, memory.qvel
        self._true_views = (qpos[:3], qvel[:3], qpos[3:7], qvel[3:6])
        self._estimate_views = tuple(self._filter[name] for name in _ESTIMATE)
        self.sensors = SensorReadings(self._record, self._memory.tick_us)
        """Latest reading of each sensor."""
        self.failures = Failures(self._record, self.sensors)
        """Switches that make parts of the vehicle fail."""
        self.external_aids = ExternalAids(self._record, self._memory.tick_us)
        """Input of fixes and poses that replace those of the vehicle's own sensors."""
        self.history = with_rotors(self._memory.history, n)
        """The last advance, a row for each control tick (`flightsim.plant.record`)."""
        self._read_afresh()
        self.wind = cfg.wind
        self.apply(OFF)
        self.other_plants: tuple[Plant, ...] = tuple(
            Plant(other.world, cfg, memory=other) for other in others
        )
        for plant in self.other_plants:
            rest = (other for other in self.other_plants if other is not plant)
            plant.other_plants = (self, *rest)

    def advance(self) -> None:
        """Advance all vehicles of the world by 20 ms, or what `PlantCfg.advance_hz` says.

        Raises:
            PhysicsDivergedError: If the physics engine had to give the state up.
        """
        plants = (self, *self.other_plants)
        for plant in plants:
            plant._begin_advance()
        if self._handover is None:
            self._counter[0] = 0
            advance(self._row, self._counter)
        for plant in plants:
            plant._end_advance()

    def _begin_advance(self) -> None:
        """Draw the noise of the next second if it begins now."""
        if self._n_advances % self.cfg.advance_hz == 0:
            self._memory.draw_normals()

    def _end_advance(self) -> None:
        """Read time, contacts and battery after the kernel's call."""
        if self._handover is None:
            self.time_us += self._advance_us
            self.contact_ticks = int(self._engine["contact_ticks"])
        else:
            self.contact_ticks = self._handover.advance(self._end_tick)
        self._n_advances += 1
        if abs(self.data.time - 1e-6 * self.time_us) > 1e-3:
            raise PhysicsDivergedError(
                f"the physics engine reset itself before t = {1e-6 * self.time_us:.2f} s: "
                "its state had become infinite or not a number"
            )
        self._read_afresh()
        self.total_contact_ticks += self.contact_ticks
        self.battery.step(self.rotor_speeds_radps, 1.0 / self.cfg.advance_hz)
        if self.battery.remaining <= 0.0:
            self._engine["has_power"] = 0

    def put(self, position_enu_m: Vector3, quat_wxyz: Quaternion) -> None:
        """Put the vehicle at rest at another pose within no time, and take its estimate along.

        Raises:
            PlaceTakenError: If it would be inside of a solid there; it then stays where it is.
        """
        relocate(self._memory, position_enu_m, quat_wxyz)
        self._read_afresh()

    def renew(self, position_enu_m: Vector3, quat_wxyz: Quaternion) -> None:
        """Put the vehicle to a start, with its rotors off and a new battery; time goes on.

        Raises:
            PlaceTakenError: If something else stands there now.
        """
        self.put(position_enu_m, quat_wxyz)
        self._rotor_speeds[:] = 0.0
        self.battery = Battery(self.world.airframe.battery)
        self._engine["has_power"] = 1

    def hand_over(self, drive: Callable[[], None]) -> Handover:
        """Let another flight stack fly the vehicle.

        Args:
            drive: Called before each control tick, to command the rotors.
        """
        self._handover = Handover(self._memory, drive)
        return self._handover

    def _end_tick(self) -> None:
        self.time_us += self._memory.tick_us
        self._read_afresh()

    def _read_afresh(self) -> None:
        """Drop the cached objects that were built from the record of an earlier tick."""
        self._truth = self._estimate = self._status = None
        self.sensors.drop()

    def _state(self, views: tuple[np.ndarray, ...]) -> State:
        position, velocity, quat, rate = (tuple(view.tolist()) for view in views)
        return State(
            time_us=self.time_us,
            position_enu_m=position,
            velocity_enu_mps=velocity,
            quat_wxyz=quat,
            angular_rate_flu_radps=rate,
        )

    @property
    def is_aligned(self) -> bool:
        """True if the controller knows the vehicle's state: by the estimator, or as the truth."""
        return self.cfg.state == "truth" or self._filter["is_aligned"] == 1

    def align(self, timeout_s: float = 10.0) -> None:
        """Rest until the estimators of all vehicles of the world are aligned, about a second.

        Raises:
            NotAlignedError: If one is not aligned within `timeout_s` of simulated time.
        """
        end_us, plants = self.time_us + round(1e6 * timeout_s), (self, *self.other_plants)
        for plant in plants:
            plant.apply(OFF)
        while not all(plant.is_aligned for plant in plants):
            if self.time_us >= end_us:
                raise NotAlignedError(
                    f"the estimator is not aligned after {timeout_s:g} s: it needs a vehicle at "
                    "rest, a barometer, a magnetometer, and satellites where aiding = 'gnss'"
                )
            self.advance()

    def apply(self, setpoint: Setpoint) -> None:
        """Follow this setpoint from the next advance on.

        A setpoint at `ATTITUDE` or `RATE` that is not finite is refused and counted in
        `n_refused_setpoints`.

        Raises:
            NotAlignedError: If it asks for more than idling before the estimator is aligned.
        """
        if setpoint.level >= ControlLevel.TRAJECTORY and not self.is_aligned:
            raise unaligned(setpoint, self.time_us)
        if setpoint.level >= ControlLevel.ATTITUDE:
            setpoint_or_none = normalised(setpoint)
            if setpoint_or_none is None:
                self.n_refused_setpoints += 1
                # A client repeats a bad setpoint many times a second: one warning is enough.
                if self.n_refused_setpoints == 1:
                    _LOG.warning("setpoint refused, not finite: %s", setpoint)
                return
            setpoint = setpoint_or_none
        self._memory.setpoint_flat[:] = setpoint_row(setpoint)
        self._engine["has_new_setpoint"] = 1

    def set_room_below(self, room_m: float) -> None:
        """Pass the free height below the legs to the controller, m; 0 if it is unknown."""
        self._controller["room_below_m"] = room_m

    @property
    def truth(self) -> State:
        """True state now."""
        if self._truth is None:
            self._truth = self._state(self._true_views)
        return self._truth

    @property
    def estimate(self) -> State:
        """Estimated state now; all zero and level until the filter is aligned."""
        if self._estimate is None:
            self._estimate = self._state(self._estimate_views)
        return self._estimate

    @property
    def estimator(self) -> EstimatorStatus:
        """Health of the estimate now."""
        if self._status is None:
            self._status = estimator_status(self._filter, self._memory.tick_us)
        return self._status

    @property
    def rotor_speeds_radps(self) -> tuple[float, ...]:
        """True rotor speeds, in the order of the airframe's rotors."""
        return tuple(self._rotor_speeds.tolist())

    @property
    def rotor_speed_commands_radps(self) -> tuple[float, ...]:
        """Last commanded rotor speeds, in the same order."""
        return tuple(self._rotor_commands.tolist())

    @property
    def lost_rotors(self) -> tuple[int, ...]:
        """Rotors (from 0) that the controller has found not to turn, until the vehicle rests."""
        if self._controller["n_lost"] == 0:
            return ()
        return tuple(np.flatnonzero(self._controller["is_lost"]).tolist())

    @property
    def collective_thrust_fraction(self) -> float:
        """Commanded collective thrust over its maximum, 0 to 1."""
        return float(self._controller["thrust_fraction"])

    @property
    def terrain_height_est_m(self) -> float:
        """Estimated ENU height of the surface below; NaN before the first range."""
        return float(self._filter["terrain_height_m"])

    @property
    def wind_est_enu_mps(self) -> tuple[float, float]:
        """Estimated velocity of the air, east and north; zero before the first flight."""
        return tuple(self._filter["wind_enu_mps"].tolist())

    @property
    def n_free_steps(self) -> int:
        """Number of physics steps since the start that the kernel took without MuJoCo."""
        return int(self._record["free_flight"]["n_steps"])

    @property
    def record_address(self) -> int:
        """Address of the plant's record (`PLANT_DTYPE`), for kernels that read it."""
        return self._memory.plants.ctypes.data

    @property
    def records(self) -> np.ndarray:
        """`PLANT_DTYPE` (1,), the plant's record, for those who read many plants alike."""
        return self._memory.plants

    @property
    def filter(self) -> np.void:
        """Record of the filter (`autonomy.estimation.error_state`), to judge it by."""
        return self._filter

    @property
    def controller(self) -> np.void:
        """Record of the controller (`autonomy.control.record`), for reports of its demands."""
        return self._controller

    @property
    def tick_us(self) -> int:
        """Time between two control ticks."""
        return self._memory.tick_us

    @property
    def reference(self) -> tuple[Vector3, Vector3]:
        """Position and velocity that the controller tracks at present, ENU."""
        row = self.history[-1]
        position, velocity = row["reference_position_enu_m"], row["reference_velocity_enu_mps"]
        return vector3(position), vector3(velocity)

    @property
    def wind(self) -> WindCfg:
        """Present wind; a new value takes effect at the next advance."""
        return self._wind

    @wind.setter
    def wind(self, cfg: WindCfg) -> None:
        self._wind = cfg
        self._memory.set_wind(cfg)

    @property
    def air_velocity_true_enu_mps(self) -> Vector3:
        """Velocity of the air now: wind, turbulence and gusts."""
        return vector3(self._record["rotors"]["wind_enu_mps"])

    @property
    def obstacles_true(self) -> ObstacleStates:
        """True states of the movers now."""
        return obstacle_states(self.world.obstacles, self._memory.movers)

    @property
    def traffic_speed(self) -> float:
        """Rate of the movers' time: 1 is real time, 0 a standstill. Changes are gradual.

        Raises:
            PlantError: If the rate is set outside of 0 to `MAX_RATE`.
        """
        return float(self._memory.traffic["rate_cmd"])

    @traffic_speed.setter
    def traffic_speed(self, rate: float) -> None:
        if not 0.0 <= rate <= MAX_RATE:
            raise PlantError(f"traffic_speed = {rate}: 0 to {MAX_RATE:g} are valid")
        self._memory.traffic["rate_cmd"] = rate

    def spin_rotors(self, speeds_radps: tuple[float, ...]) -> None:
        """Turn the rotors at these speeds while the setpoint is `OFF`, for a motor test."""
        self._controller["given_speed_radps"][: len(speeds_radps)] = speeds_radps
