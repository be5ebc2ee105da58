"""Our own pilot: flies to a landing area and lands on it, knowing only MAVLink and camera frames.

The unified task of the paper, section "AeroScene for Navigation and Interaction Tasks": a
navigation phase along a planned trajectory, then an interaction phase by onboard depth. An explicit
state machine in simulated time; every transition is written down with its reason.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import Enum
from typing import Protocol

import numpy as np

from aeroscene.scene import InteractionArea
from autonomy.model.quadrotor import Vector3
from autonomy.perception.landing import LandingSite
from autonomy.planning.errors import PlanningError
from autonomy.planning.trajectory import Trajectory
from autonomy.types import FlatReference
from flightsim.autopilot.events import Severity
from flightsim.sensors.camera import RgbdFrame
from scenarios.landing_eye import CAMERA, LandingEye, View
from scenarios.mavlink_client import PX4_LAND, PX4_OFFBOARD, PX4_RETURN, Command, MavlinkClient
from scenarios.mavlink_telemetry import LANDED_ON_GROUND
from scenarios.mission import Mission


class Phase(Enum):
    """What the pilot is about."""

    CONNECT = "connect"
    PREFLIGHT = "preflight"
    ENGAGE = "engage"
    TAKEOFF = "takeoff"
    NAVIGATE = "navigate"
    SEARCH = "search"
    ALIGN = "align"
    DESCEND = "descend"
    CLIMB = "climb"
    TOUCHDOWN = "touchdown"
    DISARM = "disarm"
    DONE = "done"
    FAILED = "failed"


@dataclass(frozen=True, kw_only=True, slots=True)
class PilotCfg:
    """How the pilot flies."""

    look_period_us: int = 200_000
    """Between two depth images while searching and descending."""
    n_search_frames: int = 6
    """Fused before a touchdown point is chosen."""
    max_search_frames: int = 25
    """After so many without a safe place the search has failed."""
    commit_height_m: float = 0.9
    """Soles above the surface where checking ends and landing begins."""
    n_unsafe_looks: int = 3
    """So many looks in a row that find the chosen place unsafe abort the descent."""
    max_attempts: int = 2
    """Descents to one area before the next one is tried."""
    max_areas: int = 3
    arrival_m: float = 0.3


_TIME_LIMIT_S: Mapping[Phase, float] = {
    Phase.CONNECT: 10.0,
    Phase.PREFLIGHT: 30.0,
    Phase.ENGAGE: 10.0,
    Phase.TAKEOFF: 20.0,
    Phase.NAVIGATE: 120.0,
    Phase.SEARCH: 20.0,
    Phase.ALIGN: 15.0,
    Phase.DESCEND: 20.0,
    Phase.CLIMB: 15.0,
    Phase.TOUCHDOWN: 20.0,
    Phase.DISARM: 10.0,
}
_STREAM_BEFORE_OFFBOARD_US = 1_000_000
_AIRBORNE = frozenset(
    {Phase.TAKEOFF, Phase.NAVIGATE, Phase.SEARCH, Phase.ALIGN, Phase.DESCEND, Phase.CLIMB}
)


class Journal(Protocol):
    """Where the pilot writes down what it plans, sees and decides; the recorder is one."""

    def log_plan(self, time_us: int, positions_enu_m: np.ndarray) -> None:
        """A trajectory that is flown from now on, as (n, 3) points."""

    def log_landing_map(
        self,
        time_us: int,
        cells_enu_m: np.ndarray,
        cost: np.ndarray,
        touchdown_enu_m: Vector3 | None = None,
    ) -> None:
        """What is known of the ground, (n, 3), with the cost of each cell, 0 to 1."""

    def log_statustext(self, time_us: int, severity: Severity, text: str) -> None:
        """A transition."""


@dataclass(frozen=True, slots=True)
class Transition:
    """A change of phase."""

    time_us: int
    phase: Phase
    reason: str


@dataclass(frozen=True, slots=True)
class Leg:
    """A trajectory and when it began."""

    trajectory: Trajectory
    start_us: int


class Pilot:
    """Flies one mission; call `update` after every simulator tick.

    Attributes:
        phase: What it is about now.
        area: Where it means to land.
        trajectory: The way there.
        reason: Of the last transition; of the failure, in the end.
        transitions: All of them, in order.
        touchdown_enu_m: Where it chose to touch down, in the frame of the estimate.
    """

    def __init__(
        self,
        client: MavlinkClient,
        mission: Mission,
        *,
        look: Callable[[str], RgbdFrame],
        journals: list[Journal] | None = None,
        cfg: PilotCfg | None = None,
    ) -> None:
        """Take the controls.

        Args:
            client: MAVLink to the vehicle.
            mission: Where to land, and the way there.
            look: Takes a frame of the named camera now.
            journals: Who hears of plans, maps and transitions.
            cfg: How to fly.
        """
        self._client = client
        self._vehicle = client.telemetry
        self._mission = mission
        self._surroundings = mission.surroundings
        self._airframe = mission.surroundings.airframe
        self._alternates = list(mission.alternates)
        self._look = look
        self.journals = journals or []
        self._cfg = cfg or PilotCfg()
        self._target(mission.area, mission.hover_enu_m, mission.trajectory)
        self.phase = Phase.CONNECT
        self.reason = ""
        self.transitions: list[Transition] = []
        self.touchdown_enu_m: Vector3 | None = None
        self._phase_start_us = 0
        self._leg: Leg | None = None
        self._pending: list[Command] = []
        self._look_due_us = 0
        self._n_unsafe = 0
        self._n_attempts = 0
        self._n_areas = 1
        self._steps: Mapping[Phase, Callable[[], None]] = {
            Phase.CONNECT: self._connect,
            Phase.PREFLIGHT: self._preflight,
            Phase.ENGAGE: self._engage,
            Phase.TAKEOFF: self._take_off,
            Phase.NAVIGATE: self._navigate,
            Phase.SEARCH: self._search,
            Phase.ALIGN: self._align,
            Phase.DESCEND: self._descend,
            Phase.CLIMB: self._climb,
            Phase.TOUCHDOWN: self._touch_down,
            Phase.DISARM: self._disarm,
        }

    @property
    def is_done(self) -> bool:
        """Whether it has landed or given up."""
        return self.phase in {Phase.DONE, Phase.FAILED}

    @property
    def has_landed(self) -> bool:
        """Whether, as far as it knows, the vehicle stands disarmed where it should."""
        return self.phase is Phase.DONE

    def update(self, time_us: int) -> None:
        """Take in what came, decide, and send the setpoint of this tick."""
        self._now_us = time_us
        self._client.update(time_us)
        step = self._steps.get(self.phase)
        if step is None:
            return
        if self._elapsed_us > 1e6 * _TIME_LIMIT_S[self.phase]:
            self._fail(f"{self.phase.value} took longer than {_TIME_LIMIT_S[self.phase]:.0f} s")
            return
        step()
        if self._leg is not None:
            self._client.send_setpoint(self._reference())

    # The phases, in the order of a mission

    def _connect(self) -> None:
        if not self._pending:
            self._pending = [*self._client.request_streams(), self._client.request_origin()]
        elif any(command.is_done and not command.is_accepted for command in self._pending):
            self._fail("the vehicle refuses a stream")
        elif all(command.is_accepted for command in self._pending):
            self._enter(Phase.PREFLIGHT, "telemetry flows")

    def _preflight(self) -> None:
        vehicle = self._vehicle
        if not (vehicle.is_armable and vehicle.is_navigating and vehicle.has_state):
            return
        self._leg = self._straight(vehicle.position_enu_m, vehicle.position_enu_m, vehicle.yaw_rad)
        self._log_plan()
        self._enter(
            Phase.ENGAGE,
            f"planned {self.trajectory.duration_s:.1f} s to area {self.area.id}, "
            f"clearance {self.trajectory.min_clearance_m:.2f} m",
        )

    def _engage(self) -> None:
        if self._elapsed_us < _STREAM_BEFORE_OFFBOARD_US:
            return
        if not self._pending:
            self._pending = [self._client.set_mode(PX4_OFFBOARD)]
        last = self._pending[-1]
        if last.is_done and not last.is_accepted:
            self._fail(f"the vehicle answers {last.outcome()} to OFFBOARD or arming")
        elif last.is_accepted and len(self._pending) == 1:
            self._pending.append(self._client.arm())
        elif last.is_accepted:
            self._go_straight(self._mission.takeoff_enu_m)
            self._enter(Phase.TAKEOFF, "armed, in OFFBOARD")

    def _take_off(self) -> None:
        if self._has_arrived:
            self._leg = Leg(self.trajectory, self._now_us)
            self._enter(Phase.NAVIGATE, "above the start")

    def _navigate(self) -> None:
        if self._has_arrived:
            self._start_search("above the landing area")

    def _start_search(self, reason: str) -> None:
        self._n_attempts += 1
        self._eye.forget()
        self._enter(Phase.SEARCH, f"{reason}, attempt {self._n_attempts}")

    def _search(self) -> None:
        view = self._look_down(self.area.centroid)
        if view is None or self._eye.n_frames < self._cfg.n_search_frames:
            return
        if view.site is not None:
            self._approach(view.site)
        elif self._eye.n_frames >= self._cfg.max_search_frames:
            self._give_area_up("no safe place to land is in sight")

    def _approach(self, site: LandingSite) -> None:
        self.touchdown_enu_m = site.position_enu_m
        x, y, _ = site.position_enu_m
        self._n_unsafe = 0
        self._go_straight((x, y, self._hover_enu_m[2]))
        self._enter(
            Phase.ALIGN,
            f"touchdown point chosen: slope {math.degrees(site.slope_rad):.1f} degrees, "
            f"roughness {100 * site.roughness_m:.0f} cm, room {site.clearance_m:.2f} m",
        )

    def _align(self) -> None:
        if self._is_place_lost():
            self._abort()
        elif self._has_arrived:
            assert self.touchdown_enu_m is not None
            x, y, z = self.touchdown_enu_m
            low = z + self._airframe.leg_length_m + self._cfg.commit_height_m
            self._go_straight((x, y, low))
            self._enter(Phase.DESCEND, "above the touchdown point")

    def _descend(self) -> None:
        if self._is_place_lost():
            self._abort()
        elif self._has_arrived:
            self._enter(Phase.TOUCHDOWN, f"committed at {self._cfg.commit_height_m:.1f} m")
            self._pending = [self._client.set_mode(PX4_LAND)]

    def _is_place_lost(self) -> bool:
        """Look again; whether the chosen place has been found unsafe several times in a row."""
        assert self.touchdown_enu_m is not None
        view = self._look_down(self.touchdown_enu_m)
        if view is not None:
            is_safe = self._eye.is_safe(view.landing, self.touchdown_enu_m)
            self._n_unsafe = 0 if is_safe else self._n_unsafe + 1
        return self._n_unsafe >= self._cfg.n_unsafe_looks

    def _abort(self) -> None:
        self.touchdown_enu_m = None
        if self._n_attempts >= self._cfg.max_attempts:
            self._give_area_up(f"no place stayed safe in {self._n_attempts} attempts")
            return
        self._go_straight(self._hover_enu_m)
        self._enter(Phase.CLIMB, "the touchdown point turned out unsafe")

    def _give_area_up(self, reason: str) -> None:
        """Go on to the next area that can be flown to, or fail."""
        here = self._reference()
        while self._alternates and self._n_areas < self._cfg.max_areas:
            area = self._alternates.pop(0)
            hover = self._surroundings.hover_point(area)
            if hover is None:
                continue
            try:
                trajectory = self._surroundings.plan(here, hover)
            except PlanningError:
                continue
            given_up = self.area.id
            self._target(area, hover, trajectory)
            self._n_areas += 1
            self._n_attempts = 0
            self._leg = Leg(trajectory, self._now_us)
            self._log_plan()
            self._enter(Phase.NAVIGATE, f"area {given_up}: {reason}; on to area {area.id}")
            return
        self._fail(reason)

    def _target(self, area: InteractionArea, hover: Vector3, trajectory: Trajectory) -> None:
        self.area, self._hover_enu_m, self.trajectory = area, hover, trajectory
        self._eye = LandingEye(area, self._airframe)

    def _climb(self) -> None:
        if self._has_arrived:
            self._start_search("climbed")

    def _touch_down(self) -> None:
        if any(command.is_done and not command.is_accepted for command in self._pending):
            self._fail("the vehicle refuses to land")
        elif self._vehicle.custom_mode == PX4_LAND:
            self._leg = None
            if self._vehicle.landed_state == LANDED_ON_GROUND:
                self._enter(Phase.DISARM, "on the ground")

    def _disarm(self) -> None:
        if not self._vehicle.is_armed:
            self._enter(Phase.DONE, "landed and disarmed")
        elif not self._pending or self._pending[-1].is_done:
            self._pending = [self._client.disarm()]

    # Flying

    @property
    def _elapsed_us(self) -> int:
        return self._now_us - self._phase_start_us

    def _enter(self, phase: Phase, reason: str) -> None:
        self.phase, self.reason = phase, reason
        self._phase_start_us = self._now_us
        self._look_due_us = self._now_us
        self._pending = []
        self.transitions.append(Transition(self._now_us, phase, reason))
        severity = Severity.ERROR if phase is Phase.FAILED else Severity.INFO
        for journal in self.journals:
            journal.log_statustext(self._now_us, severity, f"pilot: {phase.value}: {reason}")

    def _fail(self, reason: str) -> None:
        if self.phase in _AIRBORNE:
            self._client.set_mode(PX4_RETURN)
        self._leg = None
        self._enter(Phase.FAILED, f"{self.phase.value}: {reason}")

    def _reference(self) -> FlatReference:
        assert self._leg is not None
        return self._leg.trajectory.sample((self._now_us - self._leg.start_us) * 1e-6)

    def _straight(self, start_enu_m: Vector3, goal_enu_m: Vector3, yaw_rad: float) -> Leg:
        return Leg(self._surroundings.leg(start_enu_m, goal_enu_m, yaw_rad), self._now_us)

    def _go_straight(self, goal_enu_m: Vector3) -> None:
        """From the present setpoint to a point at rest."""
        now = self._reference()
        self._leg = self._straight(now.position_enu_m, goal_enu_m, now.yaw_rad)

    def _log_plan(self) -> None:
        times_s = np.linspace(0.0, self.trajectory.duration_s, 400)
        for journal in self.journals:
            journal.log_plan(self._now_us, self.trajectory.positions(times_s))

    @property
    def _has_arrived(self) -> bool:
        """Whether the leg is over and the vehicle near its end."""
        assert self._leg is not None
        if (self._now_us - self._leg.start_us) * 1e-6 < self._leg.trajectory.duration_s:
            return False
        end_enu_m = self._reference().position_enu_m
        return math.dist(self._vehicle.position_enu_m, end_enu_m) < self._cfg.arrival_m

    def _look_down(self, preferred_enu_m: Vector3) -> View | None:
        """Take and judge a depth image if one is due."""
        if self._now_us < self._look_due_us:
            return None
        self._look_due_us += self._cfg.look_period_us
        vehicle = self._vehicle
        self._eye.look(self._look(CAMERA), vehicle.position_enu_m, vehicle.quat_wxyz)
        view = self._eye.judge(preferred_enu_m)
        for journal in self.journals:
            journal.log_landing_map(
                self._now_us, view.landing.cells_enu_m, view.landing.cost, self.touchdown_enu_m
            )
        return view
