"""Our own pilot: a state machine called every 20 ms of simulated time.

The task of the paper, section "AeroScene for Navigation and Interaction Tasks": navigate along a
planned trajectory, then land by onboard depth. The pilot knows the given map, the telemetry and the
frames of its cameras, but never the true state, so that the same code could fly a real vehicle. The
phases are in `phases`, their actions in `ground_phases`, `en_route_phases` and `landing_phases`,
conditions that end any of them in `guard`.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from aeroscene.scene import InteractionArea
from autonomy.perception import LandingMap, LandingSite
from autonomy.planning import MovingObstacles, Trajectory
from autonomy.types import FlatReference, Vector3
from flightsim.mavlink.client.client import MavlinkClient
from scenarios.mission.mission import Mission
from scenarios.pilot.course import Course
from scenarios.pilot.depth_frames import Frames
from scenarios.pilot.en_route_phases import EnRoutePhases
from scenarios.pilot.final_descent import FinalDescent
from scenarios.pilot.flight_state import FlightState
from scenarios.pilot.gaze import Gaze
from scenarios.pilot.ground_phases import GroundPhases
from scenarios.pilot.guard import Guard
from scenarios.pilot.landing_phases import LandingPhases
from scenarios.pilot.pace import AMONG_MOVERS, USUAL
from scenarios.pilot.phases import (
    FOLLOWS,
    LOOKS_AROUND,
    Phase,
    PilotVerdict,
    Replan,
    Step,
    Transition,
)
from scenarios.pilot.senses import Senses

_LOG = logging.getLogger(__name__)
_PLANNED_STEP_S = 0.1  # between the points of the plan that a recording shows


@dataclass(frozen=True, kw_only=True, slots=True)
class PilotCfg:
    """Settings of the pilot besides the mission."""

    expects_traffic: bool = False
    """True to look ahead for movers five times a second."""


def _gaze(mission: Mission, cfg: PilotCfg) -> Gaze | None:
    """Return the gaze for a given map; in a growing map, plans determine the heading."""
    world = mission.surroundings
    return Gaze(world.limits) if cfg.expects_traffic and world.is_known else None


def _unfinished(phase: Phase) -> PilotVerdict:
    return PilotVerdict(success=False, reason=f"not finished, still in {phase.value}")


class Pilot:
    """Flies one mission; call `update` at the end of every tick.

    Attributes:
        mission: Mission to fly; its area is the assigned one.
        phase: Present phase.
        verdict: Outcome of the flight; "not finished" while it lasts.
        transitions: All changes of phase with their reasons.
    """

    def __init__(
        self, client: MavlinkClient, mission: Mission, frames: Frames, cfg: PilotCfg = PilotCfg()
    ) -> None:
        """Prepare a flight.

        Args:
            client: Connection to the vehicle.
            mission: Mission to fly.
            frames: Renders the present frame of a named camera.
            cfg: Settings of the pilot.
        """
        senses = Senses(mission.surroundings, frames, expects_traffic=cfg.expects_traffic)
        self._flight = flight = FlightState(
            client=client,
            mission=mission,
            senses=senses,
            course=Course(mission.trajectory),
            area=mission.area,
            hover_enu_m=mission.hover_enu_m,
            alternates=list(mission.alternates),
            gaze=_gaze(mission, cfg),
            pace=AMONG_MOVERS if cfg.expects_traffic else USUAL,
        )
        self.mission = mission
        self._ground, area = GroundPhases(flight), LandingPhases(flight)
        en_route = EnRoutePhases(flight, area)
        # Set afterwards: each of the two needs the other.
        area.fallbacks = en_route
        descent = FinalDescent(flight)
        self._guard = Guard(flight, en_route, descent)
        self.phase = Phase.CONNECT
        self.verdict = _unfinished(self.phase)
        self.transitions: list[Transition] = []
        self._steps: dict[Phase, Callable[[], Step]] = {
            Phase.CONNECT: self._ground.connect,
            Phase.PREPARE: self._ground.prepare,
            Phase.ARM: self._ground.arm,
            Phase.TAKEOFF: en_route.take_off,
            Phase.NAVIGATE: en_route.navigate,
            Phase.SEARCH: area.search,
            Phase.ALIGN: area.align,
            Phase.DESCEND: area.descend,
            Phase.TOUCHDOWN: descent.touch_down,
            Phase.DISARM: self._ground.disarm,
            Phase.CLIMB: area.climb,
            Phase.HOLD: en_route.wait,
            Phase.RETURN: en_route.fly_home,
            Phase.LAND_HOME: en_route.land_home,
            Phase.HAND_OVER: en_route.hand_over,
        }

    @property
    def is_done(self) -> bool:
        """True if the flight is over, successful or not."""
        return self.phase in {Phase.DONE, Phase.FAILED}

    @property
    def area(self) -> InteractionArea:
        """Area chosen for landing at present; it may be an alternate."""
        return self._flight.area

    @property
    def site(self) -> LandingSite | None:
        """Chosen landing site, None before the choice."""
        return self._flight.site

    @property
    def trajectory(self) -> Trajectory:
        """Present or last trajectory; before the flight, the plan to the area."""
        return self._flight.course.trajectory

    @property
    def planned_enu_m(self) -> Float[np.ndarray, "n 3"] | None:
        """Path that was planned before the take-off; None in a growing map."""
        return self.mission.path_enu_m(_PLANNED_STEP_S)

    @property
    def landing_map(self) -> LandingMap | None:
        """Assessment of the landing area, None before it was observed."""
        watch = self._flight.watch
        return None if watch is None else watch.map

    @property
    def touchdown_enu_m(self) -> Vector3 | None:
        """Chosen touchdown point, None before the choice."""
        site = self._flight.site
        return None if site is None else site.position_enu_m

    @property
    def moving(self) -> MovingObstacles:
        """Movers as seen now."""
        return self._flight.senses.moving(self._flight.time_us)

    @property
    def replans(self) -> Sequence[Replan]:
        """Replans without a change of phase, with their reasons."""
        return self._flight.replans

    def update(self, time_us: int) -> None:
        """Read telemetry, decide and send a set point.

        Call it once at the end of every tick with its time in microseconds.
        """
        flight = self._flight
        flight.time_us = time_us
        flight.client.update(time_us)
        if self.is_done:
            return
        flight.senses.locate(time_us, flight.client.telemetry)
        flight.heed_wind()
        if self.phase in FOLLOWS and flight.has_left_start():
            flight.learn_following()
        # The guard first: it may forbid what the phase would do.
        step = self._guard.check(self.phase) or self._steps[self.phase]()
        if step is not None:
            self._enter(*step)
        # After the phase's action, which may have taken the image that found it.
        if (place := flight.senses.take_place()) is not None:
            flight.client.send_place(place.position_enu_m, place.yaw_rad, place.sigma_m)
        if flight.course.has_begun and not flight.is_silent and not self.is_done:
            flight.client.send_setpoint(flight.senses.to_estimate(self._looking()))

    def _looking(self) -> FlatReference:
        """Present set point, turned to the gaze."""
        flight = self._flight
        if flight.gaze is None:
            return flight.setpoint
        return flight.gaze.turn(
            flight.time_us,
            flight.setpoint,
            flight.course.heading_rad(flight.time_us),
            looks_around=self.phase in LOOKS_AROUND,
        )

    def _enter(self, phase: Phase, reason: str) -> None:
        flight = self._flight
        change = Transition(time_us=flight.time_us, source=self.phase, target=phase, reason=reason)
        self.transitions.append(change)
        _LOG.info("%.2f s, %s: %s", flight.time_us * 1e-6, phase.value, reason)
        if phase is Phase.DONE:
            self.verdict = self._ground.success()
        elif phase is Phase.FAILED:
            self.verdict = PilotVerdict(success=False, reason=flight.given_up or reason)
        else:
            self.verdict = _unfinished(phase)
        self.phase = phase
        # Clocks and commands belong to a phase.
        flight.since_us = flight.time_us
        flight.commands = []
