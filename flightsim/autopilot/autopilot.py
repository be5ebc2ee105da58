"""Public interface of the autopilot: reported state, requests and input streams.

`Autopilot` connects the parts of this package and gives clients one object to talk to. MAVLink
handlers, recordings and Python pilots use it alone, so that the parts behind it can change. Times
are simulated microseconds, positions are ENU metres of the local frame.
"""

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
"""Ticks between failsafe checks: 100 ms, because limits and battery change slowly."""
_REPORT_EVERY = 25
"""Ticks between refreshes of health, battery and arming report: 500 ms."""


class Autopilot:
    """Commander, navigator and failsafes on top of a plant; call `update` once every 20 ms.

    Attributes:
        parameters: Parameters with PX4's names; change them by `parameters.set`.
        mission: Uploaded mission and its progress.
        fence, rally: Uploaded geofence and rally points.
        battery_monitor, datalink, sticks: Inputs of the autopilot; failures are injected there.
        follow_target, landing_target: Reports of the target to follow, and of the one to land on.
        collision_prevention: Reported obstacles that stick flight keeps away from.
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
            plant: Vehicle. The autopilot reads its sensors and its estimate, never the truth.
            frame: Geodetic position of the local frame.
            airframe: Constants of the vehicle.
            initial_parameters: Values that replace defaults, read-only ones included.
            parameter_ranges: Ranges that widen those of the table, by name.
            pilot_speeds_limit_all: True lets the greatest climb and descent of the sticks bound
                automatic flight too, as in PX4.
            terrain: Map of the terrain, above which some altitudes count. Without it they count
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
                # The range of the parameter: a stronger or weaker airframe reports the nearest
                # value.
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
        """Run one tick of 20 ms: read the plant, decide, and apply a setpoint to the plant.

        The order matters. The land detector and the failsafes see this tick's estimates and the
        setpoint of the last tick, before the behaviour computes a new one.
        """
        vehicle, commander = self._vehicle, self._commander
        vehicle.read()
        self._events.time_us = vehicle.time_us
        is_guarding = self._n_ticks % _GUARD_EVERY == 0
        if is_guarding:
            vehicle.read_slowly()
        is_descending = commander.behaviour.may_rest
        if is_descending:
            # A descent needs each reading: at 0.5 m/s the vehicle sinks 5 cm between two slow ones.
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
        # Before the commander: once the vehicle is armed, the test ends before a setpoint is
        # applied.
        self.actuator_test.update(is_armed=commander.is_armed)
        setpoint = commander.tick()
        if setpoint.level > ControlLevel.IDLE and not vehicle.is_attitude_ok:
            setpoint = IDLE  # armed by force: there is nothing to fly by yet
        self.setpoint = setpoint
        self._plant.apply(setpoint)

    def pop_events(self) -> list[Event]:
        """Remove and return the events since the last call, oldest first."""
        return self._events.pop()

    # State

    @property
    def mode(self) -> Mode:
        """Present flight mode."""
        return self._commander.mode

    @property
    def is_armed(self) -> bool:
        """True if the rotors may turn."""
        return self._commander.is_armed

    @property
    def landed_state(self) -> LandedState:
        """Phase between ground and air, by the land detector and the present behaviour."""
        if self._vehicle.is_landed:
            return LandedState.ON_GROUND
        if self._commander.behaviour.is_landing:
            return LandedState.LANDING
        return LandedState.TAKEOFF if self.mode is Mode.TAKEOFF else LandedState.IN_AIR

    @property
    def system_state(self) -> SystemState:
        """System state, as a heartbeat reports it."""
        # The strongest state comes first: a termination or an empty battery outranks a failsafe.
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
        """Position where a return ends; None before the first position estimate."""
        return self._flight.home

    @property
    def health(self) -> Health:
        """Health of the sensors and estimates, up to half a second old.

        `run_prearm_checks` renews it at once, and so does `arm` unless it is forced.
        """
        return self._checks.health

    @property
    def prearm(self) -> PrearmReport:
        """Report of the arming checks, up to half a second old; see `run_prearm_checks`."""
        return self._checks.report

    @property
    def battery(self) -> BatteryView:
        """State of the battery, up to half a second old."""
        return self.battery_monitor.view

    @property
    def target_enu_m(self) -> Vector3 | None:
        """Position that the present mode flies to, ENU m; None if it has none."""
        return self._flight.target_enu_m

    @property
    def is_mission_running(self) -> bool:
        """True while the vehicle is armed in mission mode and items are left."""
        return self.is_armed and self.mode is Mode.MISSION and not self.mission.is_finished

    @property
    def armed_at_us(self) -> int | None:
        """Simulated time of arming, microseconds; None while disarmed."""
        return self._commander.armed_at_us

    @property
    def took_off_at_us(self) -> int | None:
        """Time of the takeoff in this armed period, or in the last one; None before any."""
        return self._commander.took_off_at_us

    @property
    def n_arms(self) -> int:
        """Number of times that the vehicle has been armed."""
        return self._commander.n_arms

    # Requests

    def arm(self, *, is_forced: bool = False) -> Reply:
        """Arm the vehicle.

        Args:
            is_forced: True skips the checks. The rotors then only idle until there is an attitude.

        Returns:
            The reply; a rejection names the first reason, and each one is queued as a text.
        """
        return self._commander.arm(is_forced=is_forced)

    def disarm(self, *, is_forced: bool = False) -> Reply:
        """Stop the rotors; without `is_forced` the request is rejected in the air.

        The vehicle may be armed again afterwards, also in the air. A mode that ends with its
        flight, such as Mode.TERMINATION, becomes Mode.HOLD.
        """
        return self._commander.disarm(is_forced=is_forced)

    def set_mode(self, mode: Mode) -> Reply:
        """Change the flight mode; a refusal names the reason."""
        return self._commander.request(mode)

    def return_to_launch(self) -> Reply:
        """Return home and land."""
        return self._commander.request(Mode.RETURN)

    def start_mission(self, first: int = 0, last: int | None = None) -> Reply:
        """Fly the mission from item `first` to item `last`, once the vehicle is armed.

        Args:
            first: Index of the first item to fly.
            last: Index of the item after which the mission is finished; None flies all.

        Returns:
            The reply. It is denied if an index does not exist or the mission cannot be flown from
            here.
        """
        n_items = len(self.mission)
        if n_items and not (0 <= first < n_items and (last is None or first <= last)):
            return denied(f"no mission items {first} to {last}; there are 0 to {n_items - 1}")
        reply = self._commander.request(Mode.MISSION, MissionFlight(self._flight, last_index=last))
        # Selecting restarts the jump counters, so a mission that goes on where it was keeps them.
        if reply.is_accepted and (first != self.mission.current_index or self.mission.is_finished):
            self.mission.select(first)
        return reply

    def set_current_mission_item(self, index: int) -> Reply:
        """Continue the mission at another item; the reply is denied if the index does not exist."""
        if not 0 <= index < len(self.mission):
            return denied(f"no mission item {index}; there are {len(self.mission)}")
        self.mission.select(index)
        return ACCEPTED

    def pause(self) -> Reply:
        """Stop, and hold the position."""
        return self._commander.request(Mode.HOLD)

    def resume(self) -> Reply:
        """Continue the mission at its present item."""
        return self._commander.request(Mode.MISSION)

    def terminate(self) -> Reply:
        """Stop the rotors for the rest of this flight, even in the air (Mode.TERMINATION).

        While the vehicle is armed, no other mode is accepted and no failsafe acts. It leaves this
        state by `disarm`, which must be forced in the air. It may then be armed for a new flight.
        """
        self._commander.terminate()
        return ACCEPTED

    def run_prearm_checks(self) -> PrearmReport:
        """Run the arming checks now, and queue a text for each reason that forbids arming."""
        report = self._checks.refresh(self.mode, is_armed=self.is_armed)
        self._checks.announce()
        return report

    # Streams

    def set_offboard_setpoint(self, setpoint: Setpoint) -> None:
        """Accept an offboard setpoint; more than two a second keep the offboard mode alive."""
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
        """Accept a ground station's heartbeat; the link is lost after COM_DL_LOSS_T without one."""
        self.datalink.receive(self._plant.time_us)

    def _refresh_reports(self) -> None:
        # Home is the first valid position at first; arming moves it.
        self.battery_monitor.update(self._plant.battery, is_armed=self.is_armed)
        if self._flight.home is None and self._vehicle.is_position_ok:
            self._flight.move_home(None, is_manual=False)
        self._checks.refresh(self.mode, is_armed=self.is_armed)
