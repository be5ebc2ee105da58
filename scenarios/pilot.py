"""Our own pilot: flies a mission over MAVLink, chooses the touchdown point from depth, lands.

A state machine that is called every 20 ms of simulated time. It knows the map of the scene, what
MAVLink tells, and the frames of the downward camera; the true state it never sees.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum

from aeroscene.scene import InteractionArea
from autonomy.model.quadrotor import Vector3
from autonomy.perception import LandingMap, LandingSite
from autonomy.planning import PlanningError, Trajectory
from autonomy.types import FlatReference
from scenarios.landing_watch import DepthFrame, LandingWatch
from scenarios.mavlink_client import (
    PX4_OFFBOARD,
    PX4_RETURN,
    Command,
    MavlinkClient,
)
from scenarios.mavlink_telemetry import LANDED_ON_GROUND
from scenarios.mission import Mission

_LOG = logging.getLogger(__name__)

COMMIT_HEIGHT_M = 1.0
"""Of the soles above the surface: below it the landing is no longer called off."""
TOUCHDOWN_SPEED_MPS = 0.4
DESCENT_SPEED_MPS = 0.8
SEARCH_FRAMES = 6
"""Depth images that are fused before a place is chosen."""
MAX_SEARCH_FRAMES = 20
MAX_LOOKS = 4
"""Searches and descents at one area before the next is tried."""
MAX_AREAS = 3
_ON_COURSE_M = 0.4
_AT_PLACE_M = 0.25
_AT_REST_MPS = 0.2
_PRESS_M = 0.4
"""How far below the surface the last setpoints lie, so that the rotors let go."""


class Phase(Enum):
    """What the pilot is doing."""

    CONNECT = "connect"
    PREPARE = "wait for health"
    ARM = "arm"
    TAKEOFF = "take off"
    NAVIGATE = "navigate"
    SEARCH = "search"
    ALIGN = "align"
    DESCEND = "descend"
    TOUCHDOWN = "touch down"
    DISARM = "disarm"
    CLIMB = "climb"
    RETURN = "return"
    DONE = "done"
    FAILED = "failed"


_TIME_LIMIT_S = {
    Phase.CONNECT: 10.0,
    Phase.PREPARE: 60.0,
    Phase.ARM: 20.0,
    Phase.TAKEOFF: 30.0,
    Phase.NAVIGATE: 120.0,
    Phase.SEARCH: 20.0,
    Phase.ALIGN: 30.0,
    Phase.DESCEND: 40.0,
    Phase.TOUCHDOWN: 20.0,
    Phase.DISARM: 10.0,
    Phase.CLIMB: 30.0,
    Phase.RETURN: 5.0,
}
_IN_THE_AIR = {
    Phase.TAKEOFF,
    Phase.NAVIGATE,
    Phase.SEARCH,
    Phase.ALIGN,
    Phase.DESCEND,
    Phase.TOUCHDOWN,
    Phase.CLIMB,
}
Step = tuple[Phase, str] | None


@dataclass(frozen=True, kw_only=True, slots=True)
class PilotVerdict:
    """How a flight ended, as far as the pilot can know."""

    success: bool
    reason: str
    touchdown_error_m: float | None = None
    """Estimated resting place against the chosen point, horizontally."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Transition:
    """A change of phase."""

    time_us: int
    source: Phase
    target: Phase
    reason: str


class Pilot:
    """Flies one mission; call `update` at the end of every tick.

    Attributes:
        phase: What it is doing.
        area: Where it wants to land at present.
        trajectory: What it is flying or flew last.
        site: The touchdown point that it chose, None before.
        landing_map: What it knows of the landing area, None before it looked.
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
        self._mission = mission
        self._frames = frames
        self._world = mission.surroundings
        self._hover_enu_m = mission.hover_enu_m
        self._alternates = list(mission.alternates)
        self._watch: LandingWatch | None = None
        self._commands: list[Command] = []
        self._n_looks = 0
        self._n_areas = 1
        self._time_us = 0
        self._since_us = 0
        self._begun_us = 0
        self._hold: FlatReference | None = None
        self._commit: FlatReference | None = None
        self.phase = Phase.CONNECT
        self.area: InteractionArea = mission.area
        self.trajectory: Trajectory = mission.trajectory
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
        self._steer()

    # --- the machine ---

    def _enter(self, phase: Phase, reason: str) -> None:
        self.transitions.append(
            Transition(time_us=self._time_us, source=self.phase, target=phase, reason=reason)
        )
        _LOG.info("%.2f s %s -> %s: %s", self._time_us * 1e-6, self.phase.value, phase.value, reason)
        if phase is Phase.FAILED or phase is Phase.RETURN:
            self.verdict = PilotVerdict(success=False, reason=reason)
        self.phase = phase
        self._since_us = self._time_us
        self._commands = []

    def _watchdog(self) -> Step:
        """What ends any phase: too long, or the vehicle no longer obeys."""
        telemetry = self._client.telemetry
        if self.phase in _IN_THE_AIR:
            if not telemetry.is_armed:
                return Phase.FAILED, f"disarmed while trying to {self.phase.value}{self._last_words()}"
            if telemetry.custom_mode != PX4_OFFBOARD:
                return Phase.FAILED, f"the autopilot left offboard mode{self._last_words()}"
        if self._elapsed_s() <= _TIME_LIMIT_S[self.phase]:
            return None
        reason = f"no success to {self.phase.value} within {_TIME_LIMIT_S[self.phase]:.0f} s"
        if self.phase in _IN_THE_AIR:
            return Phase.RETURN, reason
        return Phase.FAILED, reason + self._last_words()

    def _last_words(self) -> str:
        texts = self._client.telemetry.texts
        return f"; the autopilot said: {texts[-1][1]}" if texts else ""

    def _elapsed_s(self) -> float:
        return (self._time_us - self._since_us) * 1e-6

    def _steer(self) -> None:
        """Send the setpoint of this tick."""
        if self._commit is not None:
            self._client.send_setpoint(self._sinking(self._commit))
        elif self._hold is not None:
            self._client.send_setpoint(self._hold)
        elif self.phase in _IN_THE_AIR:
            self._client.send_setpoint(self._reference())

    # --- on the ground ---

    def _connect(self) -> Step:
        telemetry = self._client.telemetry
        if telemetry.system_id and not self._commands:
            self._commands = [self._client.request_origin(), *self._client.request_streams()]
        if self._commands and all(command.is_done for command in self._commands):
            return Phase.PREPARE, f"system {telemetry.system_id} answers"
        return None

    def _prepare(self) -> Step:
        telemetry = self._client.telemetry
        if telemetry.has_state and telemetry.is_armable and telemetry.is_navigating:
            self._hold = FlatReference(
                position_enu_m=telemetry.position_enu_m, yaw_rad=telemetry.yaw_rad
            )
            return Phase.ARM, "estimator and arming checks are ready"
        return None

    def _arm(self) -> Step:
        """The stream of setpoints runs; now the mode, then the rotors."""
        telemetry = self._client.telemetry
        if telemetry.is_armed and telemetry.custom_mode == PX4_OFFBOARD:
            here = telemetry.position_enu_m
            self._fly(self._world.leg(here, self._mission.takeoff_enu_m, telemetry.yaw_rad))
            return Phase.TAKEOFF, "armed in offboard mode"
        if self._elapsed_s() < 0.2 or not all(command.is_done for command in self._commands):
            return None
        refused = [command for command in self._commands if not command.is_accepted]
        if refused and len(self._commands) > 10:
            return Phase.FAILED, f"arming was {refused[-1].outcome()}{self._last_words()}"
        if telemetry.custom_mode != PX4_OFFBOARD:
            self._commands.append(self._client.set_mode(PX4_OFFBOARD))
        elif not telemetry.is_armed:
            self._commands.append(self._client.arm())
        return None

    def _disarm(self) -> Step:
        telemetry = self._client.telemetry
        if not telemetry.is_armed:
            error_m = math.dist(telemetry.position_enu_m[:2], self._site().position_enu_m[:2])
            self.verdict = PilotVerdict(
                success=True,
                reason=f"landed {error_m:.2f} m from the chosen point and disarmed",
                touchdown_error_m=error_m,
            )
            return Phase.DONE, self.verdict.reason
        if all(command.is_done for command in self._commands):
            self._commands = [self._client.disarm()]
        return None

    # --- on the way ---

    def _take_off(self) -> Step:
        if not self._has_arrived():
            return None
        try:
            self._navigate_to(self._mission.hover_enu_m, self._mission.trajectory)
        except PlanningError as error:
            return Phase.RETURN, f"no way from the take-off: {error}"
        return Phase.NAVIGATE, "above the start"

    def _navigate(self) -> Step:
        if not self._has_arrived():
            return None
        return self._look(f"above area {self.area.id}")

    def _navigate_to(self, goal_enu_m: Vector3, prepared: Trajectory | None = None) -> None:
        """Fly a prepared trajectory if it begins here, else one that does.

        Raises:
            PlanningError: If there is none.
        """
        telemetry = self._client.telemetry
        here = telemetry.position_enu_m
        if prepared is not None:
            begin = prepared.sample(0.0).position_enu_m
            if math.dist(begin, here) <= _ON_COURSE_M:
                self._fly(prepared)
                return
        start = FlatReference(position_enu_m=here, yaw_rad=telemetry.yaw_rad)
        self._fly(self._world.plan(start, goal_enu_m))

    # --- at the area ---

    def _look(self, reason: str) -> Step:
        """Begin to look at the area anew, or go on to the next one."""
        self._n_looks += 1
        if self._n_looks > MAX_LOOKS:
            return self._give_up_area(reason)
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
        if not watch.look(self._time_us, self._client.telemetry):
            return None
        if watch.n_frames < SEARCH_FRAMES:
            return None
        self.site = watch.choose()
        if self.site is not None:
            self._fly(self._straight_to(self._above(self.site, self._hover_enu_m[2])))
            return Phase.ALIGN, (
                f"chose ({self.site.position_enu_m[0]:.2f}, {self.site.position_enu_m[1]:.2f}): "
                f"slope {math.degrees(self.site.slope_rad):.1f} deg, "
                f"{self.site.clearance_m:.2f} m of room"
            )
        if watch.n_frames < MAX_SEARCH_FRAMES:
            return None
        return self._give_up_area(f"no safe place seen on area {self.area.id}")

    def _align(self) -> Step:
        if not self._has_arrived():
            return None
        site = self._site()
        commit_m = site.position_enu_m[2] + self._world.airframe.leg_length_m + COMMIT_HEIGHT_M
        self._fly(self._straight_to(self._above(site, commit_m), DESCENT_SPEED_MPS))
        return Phase.DESCEND, "above the touchdown point"

    def _descend(self) -> Step:
        watch, site = self._watching(), self._site()
        if watch.look(self._time_us, self._client.telemetry) and not watch.is_safe(site):
            x, y, z = self._client.telemetry.position_enu_m
            self._fly(self._straight_to((x, y, max(z, self._hover_enu_m[2]))))
            return Phase.CLIMB, "the touchdown point no longer looks safe"
        if not self._has_arrived():
            return None
        self._commit = self._reference()
        return Phase.TOUCHDOWN, f"safe down to {COMMIT_HEIGHT_M} m"

    def _climb(self) -> Step:
        if not self._has_arrived():
            return None
        return self._look("climbed back")

    def _touch_down(self) -> Step:
        if self._client.telemetry.landed_state != LANDED_ON_GROUND:
            return None
        return Phase.DISARM, "on the ground"

    def _return(self) -> Step:
        """Hand the vehicle back to the autopilot."""
        if not self._commands:
            self._commands = [self._client.set_mode(PX4_RETURN)]
        if all(command.is_done for command in self._commands):
            return Phase.FAILED, self.verdict.reason
        return None

    # --- references ---

    def _fly(self, trajectory: Trajectory) -> None:
        self.trajectory = trajectory
        self._begun_us = self._time_us
        self._hold = None
        self._commit = None

    def _reference(self) -> FlatReference:
        return self.trajectory.sample((self._time_us - self._begun_us) * 1e-6)

    def _has_arrived(self) -> bool:
        """Whether the trajectory is over and the vehicle rests at its end."""
        if (self._time_us - self._begun_us) * 1e-6 < self.trajectory.duration_s:
            return False
        telemetry = self._client.telemetry
        away_m = math.dist(telemetry.position_enu_m, self._reference().position_enu_m)
        return away_m < _AT_PLACE_M and math.hypot(*telemetry.velocity_enu_mps) < _AT_REST_MPS

    def _straight_to(self, goal_enu_m: Vector3, speed_mps: float | None = None) -> Trajectory:
        """A straight way from where the last one ends."""
        here = self._reference()
        return self._world.leg(here.position_enu_m, goal_enu_m, here.yaw_rad, speed_mps)

    def _sinking(self, commit: FlatReference) -> FlatReference:
        """Straight down at a steady speed, a little past the surface."""
        x, y, z = commit.position_enu_m
        surface_m = self._site().position_enu_m[2] + self._world.airframe.leg_length_m
        lowest_m = surface_m - _PRESS_M
        height_m = z - TOUCHDOWN_SPEED_MPS * self._elapsed_s()
        return FlatReference(
            position_enu_m=(x, y, max(height_m, lowest_m)),
            velocity_enu_mps=(0.0, 0.0, -TOUCHDOWN_SPEED_MPS if height_m > lowest_m else 0.0),
            yaw_rad=commit.yaw_rad,
        )

    def _above(self, site: LandingSite, height_m: float) -> Vector3:
        return (site.position_enu_m[0], site.position_enu_m[1], height_m)

    def _site(self) -> LandingSite:
        assert self.site is not None
        return self.site

    def _watching(self) -> LandingWatch:
        assert self._watch is not None
        return self._watch
