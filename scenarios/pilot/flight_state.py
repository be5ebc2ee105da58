"""State shared by all phases of a flight: knowledge, present course and attempts so far.

The phases, the guard and the lookout all act on one flight. They share this object instead of
knowing each other, so that each can be read and tested alone. It also has the few motions that all
of them use: fly a leg, plan to a goal, replan, brake.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

from aeroscene.scene import InteractionArea
from autonomy.perception import LandingSite
from autonomy.planning import MovingObstacles, PlanningError, Trajectory
from autonomy.types import FlatReference, Vector3
from flightsim.mavlink.client.client import Command, MavlinkClient
from flightsim.mavlink.client.telemetry import Telemetry
from scenarios.mission.mission import Mission
from scenarios.pilot.course import Course
from scenarios.pilot.gaze import Gaze
from scenarios.pilot.landing_watch import LandingWatch
from scenarios.pilot.movers import (
    KEEP_FROM_MOVERS_M,
    room_to_movers_m,
    urgent_limits,
    with_less_room,
)
from scenarios.pilot.pace import IN_WIND, USUAL, WINDY_MPS, Pace
from scenarios.pilot.phases import Phase, Replan
from scenarios.pilot.senses import Senses
from scenarios.pilot.tracking_statistics import TrackingStatistics

PLANNING_TIME_S = 0.1
"""Delay until a plan made in flight takes over: the computing time of an onboard computer.
Simulated time stands still while the plan is made."""
SET_OUT_M = 1.0
"""Height above the resting place at home from which the vehicle is clear of the start. A plan may
begin there while it still climbs."""
_ON_COURSE_M = 0.4
"""Distance within which a prepared trajectory must begin to be flown."""
_AT_REST_MPS = 0.05  # of the set point, from which it counts as resting
_STRAIGHT_M = 3.0
"""Length up to which a straight line is tried first."""
_LESS_ROOM_M = (0.0, 0.15, 0.3, 0.5, 0.7, 0.9)
"""Reductions of the room to movers, tried in turn for a stop; predictions have margins already."""
_PLANNING_TIME_US = round(1e6 * PLANNING_TIME_S)


@dataclass(kw_only=True, eq=False)
class FlightState:
    """State of one flight; all positions are in the map's frame."""

    client: MavlinkClient
    mission: Mission
    senses: Senses
    course: Course
    area: InteractionArea
    """Area chosen for landing at present."""
    hover_enu_m: Vector3
    """Hover point from which the area is observed."""
    alternates: list[InteractionArea]
    """Areas not tried yet."""
    site: LandingSite | None = None
    watch: LandingWatch | None = None
    given_up: str | None = None
    """Reason why no landing on an area will be tried any more; None while one may be."""
    tracking: TrackingStatistics = field(default_factory=TrackingStatistics)
    complaint: str | None = None
    """Reason why the vehicle's position is unknown, None if it is known."""
    gaze: Gaze | None = None
    """Turns the heading to look out for movers; None to look along the course."""
    after_hold: Phase = Phase.NAVIGATE
    time_us: int = 0
    since_us: int = 0
    """Start time of the present phase."""
    pace: Pace = USUAL
    is_windy: bool = False
    """True once the autopilot has reported wind; never reset in a flight."""
    is_clear: bool = False
    """True once the vehicle was clear of the start."""
    is_silent: bool = False
    """True while the pilot sends no set points, because the autopilot takes off by itself."""
    commands: list[Command] = field(default_factory=list)
    """Commands sent in the present phase."""
    replans: list[Replan] = field(default_factory=list)
    n_looks: int = 0
    n_areas: int = 1
    n_holds: int = 0

    @property
    def telemetry(self) -> Telemetry:
        """Latest telemetry, in the map's frame."""
        return self.senses.telemetry

    @property
    def elapsed_s(self) -> float:
        """Time since the present phase began, s.

        The guard may shift the beginning, so that time in which a gust carries the vehicle off does
        not count.
        """
        return (self.time_us - self.since_us) * 1e-6

    @property
    def take_over_us(self) -> int:
        """Time from which a plan made now can be flown, us."""
        return self.time_us + _PLANNING_TIME_US

    @property
    def has_arrived(self) -> bool:
        """True if the course is complete and the vehicle rests at its end, as well as it can."""
        within_m, most_mps = self.tracking.at_place
        return self.course.has_arrived(
            self.time_us, self.telemetry, within_m=within_m, most_mps=most_mps
        )

    @property
    def setpoint(self) -> FlatReference:
        """Present set point of the course."""
        return self.course.reference(self.time_us)

    @property
    def level_deviation_m(self) -> float:
        """Horizontal distance of the vehicle from its set point, m."""
        return math.dist(self.telemetry.position_enu_m[:2], self.setpoint.position_enu_m[:2])

    @property
    def chosen(self) -> LandingSite:
        """Chosen landing site; valid only after one was chosen."""
        assert self.site is not None
        return self.site

    @property
    def resting_height_m(self) -> float:
        """Height of the vehicle's origin when it stands on the chosen site, m."""
        return self.chosen.position_enu_m[2] + self.mission.surroundings.airframe.leg_length_m

    @property
    def home_resting_height_m(self) -> float:
        """Height of the vehicle's origin when it stands at the start, m."""
        world = self.mission.surroundings
        return world.scene.start_position_enu_m[2] + world.airframe.leg_length_m

    def last_words(self) -> str:
        """The latest text of the autopilot, to be appended to a reason; empty if there is none.

        A refused command often has its cause only in such a text.
        """
        texts = self.telemetry.texts
        return f"; the autopilot said: {texts[-1][1]}" if texts else ""

    def heed_wind(self) -> None:
        """Fly more slowly from the first report of wind on.

        The present plan is flown to its end as it is.
        """
        # "Not above" instead of "at most", because the wind is NaN before the first report.
        if self.is_windy or not self.telemetry.wind_mps > WINDY_MPS:
            return
        self.is_windy = True
        self._go_carefully()

    def has_left_start(self) -> bool:
        """Return whether the vehicle is, or was, high enough to be clear of the start.

        Once true it stays true, even when the vehicle comes down again.
        """
        height_m = self.telemetry.position_enu_m[2] - self.home_resting_height_m
        self.is_clear = self.is_clear or height_m >= SET_OUT_M
        return self.is_clear

    def learn_following(self) -> None:
        """Learn how far the vehicle strays from its course, and plan with that margin.

        A vehicle that strays far is also flown more slowly, because its lag grows with the speed.
        """
        ours_mps, its_mps = self.telemetry.velocity_enu_mps, self.setpoint.velocity_enu_mps
        self.tracking.update(
            self.time_us,
            self.level_deviation_m,
            math.dist(ours_mps[:2], its_mps[:2]),
            is_resting=self.is_resting(),
        )
        margin_m = self.tracking.margin_m
        if margin_m <= self.mission.surroundings.margin_m:
            return
        # The mission is frozen, so a new margin makes a new one; plans already in flight keep
        # theirs.
        surroundings = replace(self.mission.surroundings, margin_m=margin_m)
        self.mission = replace(self.mission, surroundings=surroundings)
        self._go_carefully()

    def _go_carefully(self) -> None:
        """Fly as slowly as in wind; the present plan is flown to its end."""
        self.pace = self.pace.slowed(IN_WIND)
        surroundings = replace(self.mission.surroundings, limits=self.pace.limits)
        self.mission = replace(self.mission, surroundings=surroundings)

    def touch_down(self, resting_height_m: float) -> None:
        """Sink onto a surface, on which the vehicle's origin rests at this height."""
        self.course.touch_down(self.time_us, resting_height_m, self.pace.touchdown_mps)

    def let_land(self) -> None:
        """Let the autopilot touch down by itself if only then it notices the ground.

        It is asked once; `habits.land` is None for autopilots that follow set points to the ground.
        """
        land = self.client.habits.land
        if land is not None and not self.commands:
            self.commands = [self.client.set_mode(land)]

    def is_at_end(self, goal_enu_m: Vector3) -> bool:
        """Return whether the course ends at a place; in a growing map it may end before."""
        # A growing map's plans may end at rest short of their goal.
        trajectory = self.course.trajectory
        end = trajectory.sample(trajectory.duration_s).position_enu_m
        return math.dist(end, goal_enu_m) < _ON_COURSE_M

    def moving(self) -> MovingObstacles:
        """Movers, predicted from the time when a new plan can take over."""
        return self.senses.moving(self.take_over_us)

    def room_to_movers_m(self) -> float:
        """Least distance of the remaining course to the movers, m; infinite without any."""
        # Predictions begin at the take-over, so the course must be read at the same time.
        since_s = self.course.elapsed_s(self.take_over_us)
        radius_m = self.mission.surroundings.radius_m
        return room_to_movers_m(self.course.trajectory, since_s, self.moving(), radius_m)

    def fly(self, trajectory: Trajectory) -> None:
        """Follow a certified trajectory from the time when a plan can take over."""
        self.course.fly(trajectory, self.take_over_us)

    def begin_with(self, trajectory: Trajectory) -> None:
        """Follow a trajectory from the vehicle's resting place, starting now."""
        self.course.fly(trajectory, self.time_us)

    def leg(
        self, goal_enu_m: Vector3, speed_mps: float | None = None, *, exempt_m: float = 0.0
    ) -> Trajectory:
        """Return a certified straight line from the present set point, at rest, to rest at a goal.

        Args:
            goal_enu_m: End of the line.
            speed_mps: Greatest speed; None for the pace's limits.
            exempt_m: First stretch of the line that is not checked against the map.

        Raises:
            PlanningError: If it cannot be certified.
        """
        now = self.setpoint
        return self.mission.surroundings.certified_leg(
            now.position_enu_m,
            goal_enu_m,
            now.yaw_rad,
            speed_mps,
            moving=self.senses.moving(self.time_us),
            exempt_m=exempt_m,
        )

    def go(self, goal_enu_m: Vector3, speed_mps: float | None = None) -> None:
        """Fly from rest to a goal nearby: straight if that can be certified, else by a plan.

        Raises:
            PlanningError: If there is no certified path.
        """
        now = self.setpoint
        if math.dist(now.position_enu_m, goal_enu_m) <= _STRAIGHT_M:
            try:
                self.begin_with(self.leg(goal_enu_m, speed_mps))
            except PlanningError:
                # So near, a plan would be the same straight line.
                if math.dist(now.position_enu_m, goal_enu_m) < _ON_COURSE_M:
                    raise
            else:
                return
        self.plan_to(goal_enu_m)

    def plan_to(
        self,
        goal_enu_m: Vector3,
        prepared: Trajectory | None = None,
        *,
        start: FlatReference | None = None,
    ) -> None:
        """Fly a prepared trajectory if it begins here, else a plan.

        Args:
            goal_enu_m: Goal, at rest.
            prepared: Trajectory that was planned before, if any.
            start: State in which a plan takes over; None for the one on the course.

        Raises:
            PlanningError: If there is no plan, or none that avoids the movers.
        """
        # A trajectory that was planned before the flight fits only if the vehicle is still near its
        # start.
        here = self.telemetry.position_enu_m
        is_here = prepared is not None and (
            math.dist(prepared.sample(0.0).position_enu_m, here) <= _ON_COURSE_M
        )
        if prepared is None or not is_here:
            start = start or self.course.reference(self.take_over_us)
            prepared = self.mission.surroundings.plan(start, goal_enu_m)
        self.fly(self._past_movers(prepared))

    def go_on_from(self, start: FlatReference, goal_enu_m: Vector3, reason: str) -> None:
        """Replan from a state in which a plan can take over, and note the reason.

        Raises:
            PlanningError: If there is no certified path from there.
        """
        self.plan_to(goal_enu_m, start=start)
        self.replans.append(Replan(time_us=self.time_us, reason=reason))

    def replan(self, reason: str) -> None:
        """Replan the rest of the course around the movers, and note the reason.

        Raises:
            PlanningError: If there is no plan.
        """
        at_s = self.course.elapsed_s(self.take_over_us)
        world, moving = self.mission.surroundings, self.moving()
        self.fly(world.replan(self.course.trajectory, at_s, moving=moving))
        self.replans.append(Replan(time_us=self.time_us, reason=reason))

    def brake(self, start: FlatReference | None = None) -> None:
        """Come to rest as soon as possible, stepping aside for approaching movers.

        Stops are tried from the gentlest to the most urgent: within the usual limits, then within
        those of evasion with less and less room to movers, at last without regard to them.

        Args:
            start: State of the vehicle when the stop takes over; None for the state on the course.

        Raises:
            PlanningError: If not even a stop clear of the static obstacles can be certified.
        """
        world, moving = self.mission.surroundings, self.moving()
        plan, at_s = self.course.trajectory, self.course.elapsed_s(self.take_over_us)
        urgent = replace(world, limits=urgent_limits(world.limits))
        # Without movers, less room to them makes no difference.
        less_room_m = _LESS_ROOM_M if len(moving) else ()
        for each, less_m in [(world, 0.0), *((urgent, less_m) for less_m in less_room_m)]:
            try:
                stop = each.brake(plan, at_s, moving=with_less_room(moving, less_m), start=start)
            except PlanningError:
                continue
            break
        else:
            stop = urgent.brake(plan, at_s, start=start)
        self.fly(stop)

    def _past_movers(self, plan: Trajectory) -> Trajectory:
        """Return the same plan, or one around movers that it would come too near to.

        Raises:
            EvasionError: If there is none.
        """
        moving, world = self.moving(), self.mission.surroundings
        if room_to_movers_m(plan, 0.0, moving, world.radius_m) >= KEEP_FROM_MOVERS_M:
            return plan
        return world.replan(plan, 0.0, moving=moving)

    def is_resting(self) -> bool:
        """Return whether the course is at rest now.

        The set point decides, not the vehicle, which never hovers quite still.
        """
        return math.hypot(*self.setpoint.velocity_enu_mps) < _AT_REST_MPS
