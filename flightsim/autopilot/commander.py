"""Commander: arming, mode changes and the vehicle's action in each tick.

It owns the present mode and its behaviour. Clients, failsafes, sticks and behaviours all ask for
changes here, so that one place decides which of them wins. A behaviour flies; the commander decides
whether it may fly, rest on the ground with idle rotors, or has to be replaced.
"""

from __future__ import annotations

from autonomy.types import IDLE, OFF, Setpoint
from flightsim.autopilot.arming import ArmingChecks
from flightsim.autopilot.behaviours import Behaviour
from flightsim.autopilot.behaviours.hold import Hold
from flightsim.autopilot.behaviours.land import Descend
from flightsim.autopilot.behaviours.manual import Manual
from flightsim.autopilot.behaviours.offboard import Offboard
from flightsim.autopilot.events import Severity
from flightsim.autopilot.failsafes import ACTION_MODES, BATTERY_REASONS, MEASURES, Action, Failsafes
from flightsim.autopilot.flight_context import FlightContext
from flightsim.autopilot.flight_limits import SpeedRequests
from flightsim.autopilot.mode_entry import behaviour_of, may_enter
from flightsim.autopilot.modes import POSITION_MODES, STICK_MODES, FailsafeReason, Mode
from flightsim.autopilot.results import ACCEPTED, Reply, rejected
from flightsim.autopilot.vehicle import TICK_S

# Behaviours that do not move `flight.path`. Their successor must start it at the vehicle.
_WITHOUT_REFERENCES = (Offboard, Manual, Descend)
_GUIDED_MODES = frozenset({Mode.TAKEOFF, Mode.HOLD, Mode.OFFBOARD})
"""Modes between which a speed that a client asked for lasts: it may ask while it still climbs."""
_ONE_FLIGHT_MODES = frozenset(
    {
        *(Mode.TAKEOFF, Mode.RETURN, Mode.LAND, Mode.ORBIT, Mode.FOLLOW),
        *(Mode.PRECISION_LAND, Mode.DESCEND, Mode.TERMINATION),
    }
)
"""Modes that end with the flight: disarming switches them to hold."""


class Commander:
    """State of the vehicle as a whole.

    Attributes:
        mode: Present mode.
        is_armed: True if the rotors may turn.
        behaviour: Behaviour that flies the present mode.
        armed_at_us: Time of arming; None while disarmed.
        took_off_at_us: Time of takeoff in this armed period, if any.
        n_arms: Number of times that the vehicle has been armed.
        failsafe: Reason of the failsafe that chose the present mode, if one did.
    """

    def __init__(self, flight: FlightContext, checks: ArmingChecks, failsafes: Failsafes) -> None:
        self._flight = flight
        self._checks = checks
        self._failsafes = failsafes
        self.mode = Mode.HOLD
        self.is_armed = False
        self.behaviour: Behaviour = Hold(flight)
        self.armed_at_us: int | None = None
        self.took_off_at_us: int | None = None
        self.n_arms = 0
        self._is_idle = True  # the rotors idle on the ground, and the behaviour does not fly
        self._standing_s = 0.0  # on the ground since arming, landing or the last change of idling
        self._failsafe_action = Action.WARN
        self.failsafe: FailsafeReason | None = None
        self._was_landed = True
        self._is_resting = False

    def arm(self, *, is_forced: bool) -> Reply:
        """Let the rotors turn, unless a check forbids it.

        Args:
            is_forced: True skips the checks.

        Returns:
            The reply; a rejection names the first reason, and each reason becomes an event.
        """
        if self.is_armed:
            return ACCEPTED
        events = self._flight.events
        if not is_forced:
            report = self._checks.refresh(self.mode, is_armed=False)
            for reason in report.reasons:
                events.report(Severity.CRITICAL, f"Arming denied: {reason}")
            if report.reasons:
                return rejected(f"arming denied: {report.reasons[0]}")
        self.is_armed = True
        self.n_arms += 1
        self.armed_at_us = self._flight.vehicle.time_us
        self.took_off_at_us = None
        self._standing_s = 0.0
        self._is_idle = self._was_landed = self._flight.vehicle.is_landed
        self._forget_failsafes()
        home = self._flight.home
        # A home that a client set stays; otherwise each flight begins at its own home.
        if self._flight.vehicle.is_position_ok and (home is None or not home.is_manual):
            self._flight.move_home(None, is_manual=False)
        if self._flight.mission.is_finished:
            self._flight.mission.rewind()
        events.report(Severity.INFO, "Armed by external command")
        # Armed in the air, after a disarming by force: fly at once, there is no takeoff.
        if not self._is_idle:
            self._flight.start_references_here()
            self.behaviour.start()
        return ACCEPTED

    def disarm(self, *, is_forced: bool, why: str = "external command") -> Reply:
        """Stop the rotors; in the air only with `is_forced`.

        Args:
            is_forced: True disarms in the air too.
            why: Cause, as the text for people names it.
        """
        if not self.is_armed:
            return ACCEPTED
        if not (self._flight.vehicle.is_landed or is_forced):
            self._flight.events.report(Severity.CRITICAL, "Disarming denied: not landed")
            return rejected("disarming denied: not landed")
        self.is_armed = False
        self.armed_at_us = None
        self._forget_failsafes()
        self._flight.target_enu_m = None
        # Requested speeds end with the flight, so that the next one starts with the parameters.
        self._flight.limits.speeds = SpeedRequests()
        mission = self._flight.mission
        is_over = self.mode is Mode.MISSION and mission.is_finished
        if mission.is_finished:
            mission.rewind()
        if self.mode in _ONE_FLIGHT_MODES or is_over:
            self.mode = Mode.HOLD
        self.behaviour = behaviour_of(self.mode, self._flight)
        self._flight.events.report(Severity.INFO, f"Disarmed by {why}")
        return ACCEPTED

    def request(self, mode: Mode, behaviour: Behaviour | None = None) -> Reply:
        """Change the mode at a client's request.

        Args:
            mode: The mode.
            behaviour: Behaviour in that mode, if not the usual one.

        Returns:
            The reply. It is accepted without effect if the vehicle is in that mode already, except
            that hold stops the vehicle again and a finished mission begins anew.
        """
        is_restart = mode is Mode.HOLD or (
            mode is Mode.MISSION and self._flight.mission.is_finished
        )
        if mode is self.mode and behaviour is None and not is_restart:
            return ACCEPTED
        if self.mode is Mode.TERMINATION and self.is_armed:
            return rejected("the flight has been terminated")
        reply = may_enter(mode, self._flight, is_armed=self.is_armed, is_bare=behaviour is None)
        if not reply.is_accepted:
            why = f"switching to {mode.value} denied: {reply.reason}"
            self._flight.events.report(Severity.CRITICAL, f"{why[0].upper()}{why[1:]}")
            return Reply(reply.result, why)
        # A client overrules a failsafe: the same condition does not act again until it gets worse.
        self._failsafe_action = Action.WARN
        self.failsafe = None
        self._enter(mode, behaviour)
        return ACCEPTED

    def terminate(self) -> None:
        """Stop the rotors until the vehicle is disarmed, even in the air."""
        self._flight.events.report(Severity.EMERGENCY, "Flight termination")
        self._enter(Mode.TERMINATION, None)

    def tick(self) -> Setpoint:
        """Run one tick of the present behaviour; return its setpoint, or idle or stopped rotors."""
        if not self.is_armed:
            return OFF
        # Order: landing and takeoff are noticed first, because idling and resting depend on them.
        self._follow_landing()
        is_standing = self._flight.vehicle.is_landed
        if (is_standing and not self._lifts_off()) or self._rests():
            setpoint = IDLE
        else:
            setpoint = self.behaviour.update()
        if is_standing:
            self._disarm_if_forgotten()
        if self.behaviour.next_mode is not None:
            self._enter(self.behaviour.next_mode, None)
        return setpoint if self.is_armed and self.mode is not Mode.TERMINATION else OFF

    def guard(self) -> None:
        """Check failsafe conditions and act on new ones; a few times a second suffice."""
        flight = self._flight
        self._failsafes.watch_links()
        if not self.is_armed or self.mode is Mode.TERMINATION:
            return
        # A pilot who takes over comes before failsafes: they judge the mode that is flown then.
        self._take_over_by_sticks()
        # On the ground with idle rotors no failsafe acts.
        if flight.vehicle.is_landed and self._is_idle:
            return
        for reason, action in self._failsafes.update(self.mode):
            self._act(reason, action)

    def _enter(self, mode: Mode, behaviour: Behaviour | None) -> None:
        flight = self._flight
        # A requested speed lasts between guided modes, see `_GUIDED_MODES`.
        if mode is not self.mode and not {mode, self.mode} <= _GUIDED_MODES:
            flight.limits.speeds = SpeedRequests()
        if mode is not Mode.OFFBOARD:
            flight.heading.forget_request()
        has_references = not isinstance(self.behaviour, _WITHOUT_REFERENCES)
        self.mode = mode
        self.behaviour = behaviour or behaviour_of(mode, flight)
        if not self.is_armed or (flight.vehicle.is_landed and self._is_idle):
            return
        if not has_references:
            flight.start_references_here()
        self.behaviour.start()

    def _forget_failsafes(self) -> None:
        self._failsafes.clear()
        self._failsafe_action = Action.WARN
        self.failsafe = None

    def _follow_landing(self) -> None:
        """Track takeoff and landing."""
        is_landed = self._flight.vehicle.is_landed
        if is_landed == self._was_landed:
            return
        self._was_landed = is_landed
        self._standing_s = 0.0
        self._is_idle = is_landed
        if not is_landed:
            self.took_off_at_us = self._flight.vehicle.time_us
        text = "Landing detected" if is_landed else "Takeoff detected"
        self._flight.events.report(Severity.INFO, text)

    def _rests(self) -> bool:
        """Return true if the ground carries a vehicle that came down: its rotors should idle.

        Controlling attitude and position against the ground makes a vehicle bounce on it. A vehicle
        at rest stays at rest until its behaviour leads up: gusts and noise are no reason to lift
        it.
        """
        flight = self._flight
        is_resting = flight.land_detector.has_contact and (
            self.behaviour.may_rest or (self._is_resting and not self.behaviour.ready_to_lift())
        )
        # While it rested the reference stood still; start it at the vehicle, without a jump.
        if self._is_resting and not is_resting:
            flight.start_references_here()
        self._is_resting = is_resting
        return is_resting

    def _lifts_off(self) -> bool:
        """Return true if a landed vehicle takes off now; otherwise its rotors idle."""
        spooled_us = self._flight.vehicle.time_us - (self.armed_at_us or 0)
        is_ready = (
            spooled_us >= 1e6 * self._flight.parameters["COM_SPOOLUP_TIME"]
            and self.behaviour.ready_to_lift()
        )
        # Ready and still idle, or no longer ready and not idle: the state changes in this tick.
        if is_ready == self._is_idle:
            self._is_idle = not is_ready
            self._standing_s = 0.0
            if is_ready:
                self._flight.start_references_here()
                self.behaviour.start()
        return is_ready

    def _disarm_if_forgotten(self) -> None:
        """Disarm a vehicle that has landed, or that was armed and does not leave the ground."""
        p = self._flight.parameters
        self._standing_s += TICK_S
        is_in_mission = self.mode is Mode.MISSION and not self._flight.mission.is_finished
        # A mission may wait on the ground between two flights.
        if self._is_idle and is_in_mission:
            return
        has_flown = self.took_off_at_us is not None and self._is_idle
        limit_s = p["COM_DISARM_LAND"] if has_flown else p["COM_DISARM_PRFLT"]
        # A negative limit switches automatic disarming off.
        if 0.0 <= limit_s <= self._standing_s:
            why = "landing" if has_flown else "auto preflight disarming"
            self.disarm(is_forced=True, why=why)

    def _take_over_by_sticks(self) -> None:
        flight = self._flight
        if self.mode in STICK_MODES or flight.vehicle.is_landed:
            return
        # Bits of COM_RC_OVERRIDE: 1 automatic modes, 2 offboard.
        bit = 2 if self.mode is Mode.OFFBOARD else 1
        if not int(flight.parameters["COM_RC_OVERRIDE"]) & bit:
            return
        if not flight.sticks.is_moved(flight.vehicle.time_us):
            return
        mode = Mode.POSITION if flight.vehicle.is_position_ok else Mode.ALTITUDE
        flight.events.report(Severity.INFO, "Pilot took over using sticks")
        self.request(mode)

    def _act(self, reason: FailsafeReason, action: Action) -> None:
        """Execute the action of a new failsafe condition, unless a stronger one is underway."""
        flight = self._flight
        if action is Action.WARN:
            if reason in BATTERY_REASONS:
                return
            flight.events.report(Severity.WARNING, f"Failsafe warning: {reason.value}")
            return
        mode = self._mode_for(action)
        # A landing is not interrupted by a return, nor a failsafe by a weaker or an equal one.
        if action <= max(self._failsafe_action, MEASURES.get(self.mode, Action.WARN)):
            return
        self._failsafe_action = action
        self.failsafe = reason
        if action is Action.DISARM:
            flight.events.report(
                Severity.EMERGENCY, f"Failsafe activated: {reason.value}, disarming"
            )
            self.disarm(is_forced=True, why="failsafe")
            return
        flight.events.report(
            Severity.CRITICAL, f"Failsafe activated: {reason.value}, switching to {mode.value}"
        )
        self._enter(mode, None)

    def _mode_for(self, action: Action) -> Mode:
        """Mode that an action leads to; without a position it is the blind descent."""
        flight = self._flight
        if action is Action.STICKS:
            wanted = {1: Mode.ALTITUDE, 2: Mode.STABILIZED}  # by COM_OBL_RC_ACT
            has_sticks = flight.sticks.is_alive(flight.vehicle.time_us)
            choice = int(flight.parameters["COM_OBL_RC_ACT"])
            mode = wanted.get(choice, Mode.POSITION) if has_sticks else Mode.HOLD
        else:
            mode = ACTION_MODES.get(action, Mode.HOLD)
        # Hold, return and land would follow an estimate that jumps.
        if mode in POSITION_MODES and not flight.vehicle.is_position_ok:
            return Mode.DESCEND
        return mode
