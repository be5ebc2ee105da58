"""Our own pilot: flies a mission over MAVLink, chooses the touchdown point from depth, lands.

The task of the paper, section "AeroScene for Navigation and Interaction Tasks": navigate along a
planned trajectory, then land by onboard depth. A state machine that is called every 20 ms of
simulated time. It knows the map of the scene, what MAVLink tells, and the frames of the downward
camera; the true state it never sees.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Callable

from aeroscene.scene import InteractionArea
from autonomy.model.quadrotor import Vector3
from autonomy.perception import LandingMap, LandingSite
from autonomy.planning import PlanningError, Trajectory
from autonomy.types import FlatReference
from scenarios.course import Course
from scenarios.landing_watch import DepthFrame, LandingWatch
from scenarios.mavlink_client import PX4_OFFBOARD, PX4_RETURN, Command, MavlinkClient
from scenarios.mavlink_telemetry import LANDED_ON_GROUND
from scenarios.mission import Mission
from scenarios.pilot_phases import IN_THE_AIR, TIME_LIMIT_S, Phase, PilotVerdict, Transition

__all__ = ["Phase", "Pilot", "PilotVerdict", "Transition"]

_LOG = logging.getLogger(__name__)

COMMIT_HEIGHT_M = 1.0
"""Of the soles above the surface: below it the landing is no longer called off."""
DESCENT_SPEED_MPS = 0.8
SEARCH_FRAMES = 6
"""Depth images that are fused before a place is chosen."""
MAX_SEARCH_FRAMES = 20
MAX_LOOKS = 4
"""Searches and descents at one area before the next is tried."""
MAX_AREAS = 3
MAX_ARMING_TRIES = 10
_STREAM_BEFORE_ARMING_S = 0.2
_ON_COURSE_M = 0.4
Step = tuple[Phase, str] | None


class Pilot:
    """Flies one mission; call `update` at the end of every tick.

    Attributes:
        phase: What it is doing.
        area: Where it wants to land at present.
        site: The touchdown point that it chose, None before.
        verdict: How it ended; of a flight that is not done, that it is not.
        transitions: Every change of phase with its reason.
    """

    def __init__(
        self, client: MavlinkClient, mission: Mission, frames: Callable[[str], DepthFrame]
    ) -> None:
        """Prepare a flight.

        Args:
            client: Connection to the vehicle.
            mission: What to fly.
            frames: Renders the named camera now.
        """
        self._client = client
        self._telemetry = client.telemetry
        self._mission = mission
        self._frames = frames
        self._world = mission.surroundings
        self._hover_enu_m = mission.hover_enu_m
        self._alternates = list(mission.alternates)
        self._course = Course(mission.trajectory)
        self._watch: LandingWatch | None = None
        self._commands: list[Command] = []
        self._n_looks = 0
        self._n_areas = 1
        self._time_us = 0
        self._since_us = 0
        self.phase = Phase.CONNECT
        self.area: InteractionArea = mission.area
        self.site: LandingSite | None = None
        self.verdict = PilotVerdict(success=False, reason="not finished")
        self.transitions: list[Transition] = []
        self._steps: dict[Phase, Callable[[], Step]] = {
            Phase.CONNECT: self._connect,
            Phase.PREPARE: self._prepare,
            Phase.ARM: self._arm,
            Phase.TAKEOFF: self._take_off,
            Phase.NAVIGATE: self._navigate,
            Phase.SEARCH: self._search,
            Phase.ALIGN: self._align,
            Phase.DESCEND: self._descend,
            Phase.TOUCHDOWN: self._touch_down,
            Phase.DISARM: self._disarm,
            Phase.CLIMB: self._climb,
            Phase.RETURN: self._return,
        }

    @property
    def is_done(self) -> bool:
        """Whether the flight is over, well or badly."""
        return self.phase in {Phase.DONE, Phase.FAILED}

    @property
    def trajectory(self) -> Trajectory:
        """What it is flying or flew last; before the flight, the way to the area."""
        return self._course.trajectory

    @property
    def landing_map(self) -> LandingMap | None:
        """What it knows of the landing area, None before it looked."""
        return None if self._watch is None else self._watch.map

    @property
    def touchdown_enu_m(self) -> Vector3 | None:
        """The touchdown point that it chose, None before."""
        return None if self.site is None else self.site.position_enu_m

    def update(self, time_us: int) -> None:
        """Read telemetry, decide, send a setpoint."""
        self._time_us = time_us
        self._client.update(time_us)
        if self.is_done:
            return
        step = self._watchdog() or self._steps[self.phase]()
        if step is not None:
            self._enter(*step)
        if self._course.has_begun and not self.is_done:
            self._client.send_setpoint(self._course.reference(time_us))

    def _enter(self, phase: Phase, reason: str) -> None:
        change = Transition(time_us=self._time_us, source=self.phase, target=phase, reason=reason)
        self.transitions.append(change)
        _LOG.info("%.2f s, %s: %s", self._time_us * 1e-6, phase.value, reason)
        if phase in {Phase.RETURN, Phase.FAILED}:
            self.verdict = PilotVerdict(success=False, reason=reason)
        self.phase = phase
        self._since_us = self._time_us
        self._commands = []

    def _watchdog(self) -> Step:
        """What ends any phase: it takes too long, or the vehicle no longer obeys."""
        phase = self.phase
        if phase in IN_THE_AIR:
            if not self._telemetry.is_armed:
                return Phase.FAILED, f"disarmed in phase {phase.value}{self._last_words()}"
            if self._telemetry.custom_mode != PX4_OFFBOARD:
                return Phase.FAILED, f"the autopilot left offboard mode{self._last_words()}"
        if self._elapsed_s() <= TIME_LIMIT_S[phase]:
            return None
        reason = f"phase {phase.value} took more than {TIME_LIMIT_S[phase]:.0f} s"
        if phase in IN_THE_AIR:
            return Phase.RETURN, reason
        return Phase.FAILED, reason + self._last_words()

    def _last_words(self) -> str:
        texts = self._telemetry.texts
        return f"; the autopilot said: {texts[-1][1]}" if texts else ""

    def _elapsed_s(self) -> float:
        return (self._time_us - self._since_us) * 1e-6

    # On the ground

    def _connect(self) -> Step:
        if self._telemetry.system_id and not self._commands:
            self._commands = [self._client.request_origin(), *self._client.request_streams()]
        if self._commands and all(command.is_done for command in self._commands):
            return Phase.PREPARE, f"system {self._telemetry.system_id} answers"
        return None

    def _prepare(self) -> Step:
        telemetry = self._telemetry
        if not (telemetry.has_state and telemetry.is_armable and telemetry.is_navigating):
            return None
        here = telemetry.position_enu_m
        # A stream of setpoints that stay where it stands: offboard mode wants one.
        self._fly(self._world.leg(here, here, telemetry.yaw_rad))
        return Phase.ARM, "estimator and arming checks are ready"

    def _arm(self) -> Step:
        """The stream of setpoints runs; now the mode, then the rotors."""
        telemetry = self._telemetry
        if telemetry.is_armed and telemetry.custom_mode == PX4_OFFBOARD:
            here = telemetry.position_enu_m
            self._fly(self._world.leg(here, self._mission.takeoff_enu_m, telemetry.yaw_rad))
            return Phase.TAKEOFF, "armed in offboard mode"
        is_waiting = not all(command.is_done for command in self._commands)
        if is_waiting or self._elapsed_s() < _STREAM_BEFORE_ARMING_S:
            return None
        if len(self._commands) >= MAX_ARMING_TRIES:
            outcome = self._commands[-1].outcome()
            return Phase.FAILED, f"mode or arming: {outcome}{self._last_words()}"
        if telemetry.custom_mode != PX4_OFFBOARD:
            self._commands.append(self._client.set_mode(PX4_OFFBOARD))
        else:
            self._commands.append(self._client.arm())
        return None

    def _disarm(self) -> Step:
        if self._telemetry.is_armed:
            if all(command.is_done for command in self._commands):
                self._commands = [self._client.disarm()]
            return None
        rest_enu_m = self._telemetry.position_enu_m
        error_m = math.dist(rest_enu_m[:2], self._chosen().position_enu_m[:2])
        self.verdict = PilotVerdict(
            success=True,
            reason=f"landed {error_m:.2f} m from the chosen point and disarmed",
            touchdown_error_m=error_m,
        )
        return Phase.DONE, self.verdict.reason

    # On the way

    def _take_off(self) -> Step:
        if not self._has_arrived():
            return None
        try:
            self._navigate_to(self._mission.hover_enu_m, self._mission.trajectory)
        except PlanningError as error:
            return Phase.RETURN, f"no way from the take-off: {error}"
        return Phase.NAVIGATE, "above the start"

    def _navigate(self) -> Step:
        return self._look(f"above area {self.area.id}") if self._has_arrived() else None

    def _navigate_to(self, goal_enu_m: Vector3, prepared: Trajectory | None = None) -> None:
        """Fly a prepared trajectory if it begins here, else plan one that does.

        Raises:
            PlanningError: If there is none.
        """
        here = self._telemetry.position_enu_m
        if prepared is not None:
            begin = prepared.sample(0.0).position_enu_m
            if math.dist(begin, here) <= _ON_COURSE_M:
                self._fly(prepared)
                return
        start = FlatReference(position_enu_m=here, yaw_rad=self._telemetry.yaw_rad)
        self._fly(self._world.plan(start, goal_enu_m))

    # At the area

    def _look(self, reason: str) -> Step:
        """Begin to look at the area anew, or go on to the next one."""
        self._n_looks += 1
        if self._n_looks > MAX_LOOKS:
            return self._give_up_area(f"{reason}, for the {MAX_LOOKS}th time")
        self._watch = LandingWatch(self._world, self.area, self._hover_enu_m, self._frames)
        return Phase.SEARCH, reason

    def _give_up_area(self, reason: str) -> Step:
        self._n_looks = 0
        while self._alternates and self._n_areas < MAX_AREAS:
            area = self._alternates.pop(0)
            hover = self._world.hover_point(area)
            if hover is None:
                continue
            try:
                self._navigate_to(hover)
            except PlanningError as error:
                _LOG.info("area %d: %s", area.id, error)
                continue
            self._n_areas += 1
            self.area, self._hover_enu_m, self.site = area, hover, None
            return Phase.NAVIGATE, f"{reason}; on to area {area.id}"
        return Phase.RETURN, reason

    def _search(self) -> Step:
        watch = self._watching()
        if not watch.look(self._time_us, self._telemetry) or watch.n_frames < SEARCH_FRAMES:
            return None
        self.site = watch.choose()
        if self.site is not None:
            x, y, _ = self.site.position_enu_m
            self._go_straight((x, y, self._hover_enu_m[2]))
            return Phase.ALIGN, (
                f"chose ({x:.2f}, {y:.2f}): slope {math.degrees(self.site.slope_rad):.1f} deg, "
                f"roughness {100 * self.site.roughness_m:.0f} cm, "
                f"{self.site.clearance_m:.2f} m of room"
            )
        if watch.n_frames < MAX_SEARCH_FRAMES:
            return None
        return self._give_up_area(f"no safe place seen on area {self.area.id}")

    def _align(self) -> Step:
        if not self._has_arrived():
            return None
        x, y, _ = self._chosen().position_enu_m
        commit_m = min(self._resting_height_m() + COMMIT_HEIGHT_M, self._hover_enu_m[2])
        self._go_straight((x, y, commit_m), DESCENT_SPEED_MPS)
        return Phase.DESCEND, "above the touchdown point"

    def _descend(self) -> Step:
        watch = self._watching()
        if watch.look(self._time_us, self._telemetry):
            self.site = watch.again(self._chosen())
            if reason := watch.objection(self.site):
                x, y, z = self._telemetry.position_enu_m
                self._go_straight((x, y, max(z, self._hover_enu_m[2])))
                return Phase.CLIMB, f"the touchdown point no longer looks safe: {reason}"
        if not self._has_arrived():
            return None
        self._course.touch_down(self._time_us, self._resting_height_m())
        return Phase.TOUCHDOWN, "still safe from here"

    def _climb(self) -> Step:
        return self._look("climbed back") if self._has_arrived() else None

    def _touch_down(self) -> Step:
        if self._telemetry.landed_state != LANDED_ON_GROUND:
            return None
        return Phase.DISARM, "on the ground"

    def _return(self) -> Step:
        """Hand the vehicle back to the autopilot."""
        if not self._commands:
            self._commands = [self._client.set_mode(PX4_RETURN)]
        if all(command.is_done for command in self._commands):
            return Phase.FAILED, self.verdict.reason
        return None

    # Steering

    def _fly(self, trajectory: Trajectory) -> None:
        self._course.fly(trajectory, self._time_us)

    def _go_straight(self, goal_enu_m: Vector3, speed_mps: float | None = None) -> None:
        """From the present setpoint to a point at rest."""
        now = self._course.reference(self._time_us)
        self._fly(self._world.leg(now.position_enu_m, goal_enu_m, now.yaw_rad, speed_mps))

    def _has_arrived(self) -> bool:
        return self._course.has_arrived(self._time_us, self._telemetry)

    def _resting_height_m(self) -> float:
        """Height of the vehicle's origin when it stands on the chosen place."""
        return self._chosen().position_enu_m[2] + self._world.airframe.leg_length_m

    def _chosen(self) -> LandingSite:
        assert self.site is not None
        return self.site

    def _watching(self) -> LandingWatch:
        assert self._watch is not None
        return self._watch
