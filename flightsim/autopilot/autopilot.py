"""Public interface of the autopilot: reported state, requests and input streams."""

from __future__ import annotations

from collections.abc import Mapping
from math import isfinite

from aeroscene.scene import Relief
from autonomy.types import IDLE, OFF, ControlLevel, Setpoint, Vector3
from flightsim.autopilot.actuator_test import ActuatorTest
from flightsim.autopilot.arming import ArmingChecks
from flightsim.autopilot.battery_monitor import BatteryMonitor
from flightsim.autopilot.behaviours.mission import MissionFlight
from flightsim.autopilot.commander import Commander
from flightsim.autopilot.events import Event, EventLog
from flightsim.autopilot.failsafes import Failsafes
from flightsim.autopilot.flight_context import FlightContext
from flightsim.autopilot.guided import GuidedRequests
from flightsim.autopilot.modes import BatteryWarning, FailsafeReason, LandedState, Mode, SystemState
from flightsim.autopilot.parameters import Parameters
from flightsim.autopilot.results import ACCEPTED, Reply, denied
from flightsim.autopilot.status import BatteryView, Health, Home, PrearmReport
from flightsim.autopilot.streams import DatalinkWatch, Sticks
from flightsim.autopilot.vehicle import Vehicle
from flightsim.frames import LocalFrame
from flightsim.plant import Plant
from flightsim.vehicles.airframe import Airframe

_GUARD_EVERY = 5
"""Ticks between failsafe checks: 100 ms."""
_REPORT_EVERY = 25
"""Ticks between refreshes of health, battery and arming report: 500 ms."""


class Autopilot:
    """Commander, navigator and failsafes on top of a plant; `update` once every 20 ms.

    Attributes:
        parameters: Changed by `parameters.set`.
        mission: Uploaded mission and its progress.
        fence, rally: Uploaded geofence and rally points.
        battery_monitor, datalink, sticks: What the autopilot reads, for letting it fail.
        follow_target, landing_target: Reports of what to follow, and of what to land on.
        collision_prevention: Reports of what not to fly into.
        actuator_test: Tests of motors on the ground.
        setpoint: Setpoint applied last.

    Requests from `takeoff` to `set_home` are `flightsim.autopilot.guided.GuidedRequests`.
    """

    def __init__(
        self,
        plant: Plant,
        frame: LocalFrame,
        *,
        airframe: Airframe,
        initial_parameters: Mapping[str, float] | None = None,
        parameter_ranges: Mapping[str, tuple[float, float]] | None = None,
        pilot_speeds_limit_all: bool = True,
        terrain: Relief | None = None,
    ) -> None:
        """Connect the parts.

        Args:
            plant: Vehicle, of which only the sensors and the estimate are read, never the truth.
            frame: Geodetic position of the local frame.
            airframe: Constants of the vehicle.
            initial_parameters: Values that replace defaults, read-only ones included.
            parameter_ranges: Ranges that widen those of the table, by name.
            pilot_speeds_limit_all: Whether the greatest climb and descent of the sticks bound
                automatic flight too, as in PX4.
            terrain: Map of the terrain, above which some altitudes count; without it they count
                above home.

        Raises:
            ParameterError: If one of the initial parameters is unknown or out of range.
        """
        hover = airframe.quadrotor.hover_thrust_fraction
        self.parameters = Parameters(
            parameter_ranges,
            **{
                "BAT1_N_CELLS": airframe.battery.cells,
                "BAT1_CAPACITY": airframe.battery.capacity_mah,
                "MPC_THR_HOVER": min(max(hover, 0.1), 0.8),
                **(initial_parameters or {}),
            },
        )
        self._plant = plant
        self._events = EventLog()
        self._vehicle = Vehicle(plant, self.parameters, hover)
        self._flight = FlightContext(self._vehicle, self.parameters, self._events, frame)
        self._flight.terrain = terrain
        self._flight.limits.pilot_speeds_limit_all = pilot_speeds_limit_all
        self.battery_monitor = BatteryMonitor(self.parameters, self._events, airframe.battery.cells)
        self.datalink = DatalinkWatch(self.parameters)
        self._checks = ArmingChecks(plant, self._flight, self.battery_monitor)
        self._failsafes = Failsafes(self._flight, self.battery_monitor, self.datalink)
        self._commander = Commander(self._flight, self._checks, self._failsafes)
        self.mission = self._flight.mission
        self.fence = self._flight.fence
        self.rally = self._flight.rally
        self.sticks = self._flight.sticks
        self.follow_target = self._flight.follow_target
        self.landing_target = self._flight.landing_target
        self.collision_prevention = self._flight.collision_prevention
        self.actuator_test = ActuatorTest(plant, self._flight, airframe)
        guided = GuidedRequests(self._flight, self._commander)
        self.takeoff, self.land, self.restart = guided.takeoff, guided.land, guided.restart
        self.goto, self.orbit = guided.goto, guided.orbit
        self.circle_ahead = guided.circle_ahead
        self.set_yaw, self.set_speed = guided.set_yaw, guided.set_speed
        self.set_home = guided.set_home
        self.setpoint: Setpoint = OFF
        self._n_ticks = 0

    def update(self) -> None:
        """Run one tick: read the plant, decide and apply a setpoint."""
        vehicle, commander = self._vehicle, self._commander
        vehicle.read()
        self._events.time_us = vehicle.time_us
        is_guarding = self._n_ticks % _GUARD_EVERY == 0
        if is_guarding:
            vehicle.read_slowly()
        is_descending = commander.behaviour.may_rest
        if is_descending:
            vehicle.read_range()
        self._flight.land_detector.update(
            vehicle,
            is_armed=commander.is_armed,
            is_descending=is_descending,
            commanded_up_mps=self.setpoint.velocity_enu_mps[2],
        )
        if is_guarding:
            commander.guard()
            if self._n_ticks % _REPORT_EVERY == 0:
                self._refresh_reports()
        self._n_ticks += 1
        self.actuator_test.update(is_armed=commander.is_armed)
        setpoint = commander.tick()
        if setpoint.level > ControlLevel.IDLE and not vehicle.is_attitude_ok:
            setpoint = IDLE  # armed by force: there is nothing to fly by yet
        self.setpoint = setpoint
        self._plant.apply(setpoint)

    def pop_events(self) -> list[Event]:
        """Events since the last call."""
        return self._events.pop()

    # State

    @property
    def mode(self) -> Mode:
        """Present mode."""
        return self._commander.mode

    @property
    def is_armed(self) -> bool:
        """Whether the rotors may turn."""
        return self._commander.is_armed

    @property
    def landed_state(self) -> LandedState:
        """Phase between ground and air."""
        if self._vehicle.is_landed:
            return LandedState.ON_GROUND
        if self._commander.behaviour.is_landing:
            return LandedState.LANDING
        return LandedState.TAKEOFF if self.mode is Mode.TAKEOFF else LandedState.IN_AIR

    @property
    def system_state(self) -> SystemState:
        """System state, as a heartbeat reports it."""
        if self.mode is Mode.TERMINATION:
            return SystemState.EMERGENCY
        if not self.is_armed:
            return SystemState.STANDBY
        if self.battery_monitor.warning is BatteryWarning.EMERGENCY:
            return SystemState.EMERGENCY
        return SystemState.ACTIVE if self.failsafe is None else SystemState.CRITICAL

    @property
    def failsafe(self) -> FailsafeReason | None:
        """Reason of the failsafe that chose the present mode, else the worst present condition."""
        return self._commander.failsafe or self._failsafes.reason

    @property
    def home(self) -> Home | None:
        """Where a return ends; None before the first position."""
        return self._flight.home

    @property
    def health(self) -> Health:
        """Health of the parts; refreshed twice a second."""
        return self._checks.health

    @property
    def prearm(self) -> PrearmReport:
        """Whether arming would be accepted; refreshed twice a second."""
        return self._checks.report

    @property
    def battery(self) -> BatteryView:
        """The battery; refreshed twice a second."""
        return self.battery_monitor.view

    @property
    def target_enu_m(self) -> Vector3 | None:
        """Position that the present mode flies to, if any."""
        return self._flight.target_enu_m

    @property
    def is_mission_running(self) -> bool:
        """Whether a mission is being flown."""
        return self.is_armed and self.mode is Mode.MISSION and not self.mission.is_finished

    @property
    def armed_at_us(self) -> int | None:
        """Time of arming; None while disarmed."""
        return self._commander.armed_at_us

    @property
    def took_off_at_us(self) -> int | None:
        """Time of takeoff in this armed period, or of the last flight's."""
        return self._commander.took_off_at_us

    @property
    def n_arms(self) -> int:
        """Number of times that the vehicle has been armed."""
        return self._commander.n_arms

    # Requests

    def arm(self, *, is_forced: bool = False) -> Reply:
        """Arm the vehicle; `is_forced` skips the checks."""
        return self._commander.arm(is_forced=is_forced)

    def disarm(self, *, is_forced: bool = False) -> Reply:
        """Disarm the vehicle; in the air only with `is_forced`."""
        return self._commander.disarm(is_forced=is_forced)

    def set_mode(self, mode: Mode) -> Reply:
        """Change the mode."""
        return self._commander.request(mode)

    def return_to_launch(self) -> Reply:
        """Return home and land."""
        return self._commander.request(Mode.RETURN)

    def start_mission(self, first: int = 0, last: int | None = None) -> Reply:
        """Fly the mission from one item to another, once the vehicle is armed."""
        n_items = len(self.mission)
        if n_items and not (0 <= first < n_items and (last is None or first <= last)):
            return denied(f"no mission items {first} to {last}; there are 0 to {n_items - 1}")
        reply = self._commander.request(Mode.MISSION, MissionFlight(self._flight, last_index=last))
        if reply.is_accepted and (first != self.mission.current_index or self.mission.is_finished):
            self.mission.select(first)
        return reply

    def set_current_mission_item(self, index: int) -> Reply:
        """Continue the mission at another item."""
        if not 0 <= index < len(self.mission):
            return denied(f"no mission item {index}; there are {len(self.mission)}")
        self.mission.select(index)
        return ACCEPTED

    def pause(self) -> Reply:
        """Stop and hold position."""
        return self._commander.request(Mode.HOLD)

    def resume(self) -> Reply:
        """Continue the mission."""
        return self._commander.request(Mode.MISSION)

    def terminate(self) -> Reply:
        """Stop the rotors irrevocably, wherever the vehicle is."""
        self._commander.terminate()
        return ACCEPTED

    def run_prearm_checks(self) -> PrearmReport:
        """Run the arming checks now and announce what forbids arming."""
        report = self._checks.refresh(self.mode, is_armed=self.is_armed)
        self._checks.announce()
        return report

    # Streams

    def set_offboard_setpoint(self, setpoint: Setpoint) -> None:
        """Accept an offboard setpoint; more than two a second keep offboard alive."""
        self._flight.offboard.receive(setpoint, self._plant.time_us)

    def set_manual_control(self, *, pitch: float, roll: float, throttle: float, yaw: float) -> None:
        """Accept stick positions; values that are not finite are ignored.

        Args:
            pitch: Forward, -1 to 1.
            roll: Right, -1 to 1.
            throttle: Up, 0 to 1.
            yaw: Clockwise from above, -1 to 1.
        """
        if not all(isfinite(c) for c in (pitch, roll, throttle, yaw)):
            return
        sticks = Sticks.limited(pitch=pitch, roll=roll, throttle=throttle, yaw=yaw)
        self.sticks.receive(sticks, self._plant.time_us)

    def on_link_heartbeat(self, _source: object = None) -> None:
        """Accept the heartbeat of a ground station."""
        self.datalink.receive(self._plant.time_us)

    def _refresh_reports(self) -> None:
        self.battery_monitor.update(self._plant.battery, is_armed=self.is_armed)
        if self._flight.home is None and self._vehicle.is_position_ok:
            self._flight.move_home(None, is_manual=False)
        self._checks.refresh(self.mode, is_armed=self.is_armed)
