"""What all phases of a flight share: what is known, what is flown, what was tried so far."""

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
from scenarios.pilot.phases import Phase, Replan
from scenarios.pilot.senses import Senses

PLANNING_TIME_S = 0.1
"""A plan made in flight takes over so much later: what a computer on board may take to make it."""
_ON_COURSE_M = 0.4
"""A prepared trajectory is flown if it begins so near."""
_AT_REST_MPS = 0.05
_STRAIGHT_M = 3.0
"""Ways up to this length are first tried straight."""
_LESS_ROOM_M = (0.0, 0.15, 0.3, 0.5, 0.7, 0.9)
"""To what moves, beside the margins that predictions have: the widest stop that there is."""
_PLANNING_TIME_US = round(1e6 * PLANNING_TIME_S)


@dataclass(kw_only=True, eq=False)
class Flight:
    """One flight; every place in it is in the map's frame."""

    client: MavlinkClient
    mission: Mission
    senses: Senses
    course: Course
    area: InteractionArea
    """Where it wants to land at present."""
    hover_enu_m: Vector3
    """From where to look at the area."""
    alternates: list[InteractionArea]
    """Areas not tried yet."""
    site: LandingSite | None = None
    watch: LandingWatch | None = None
    given_up: str | None = None
    """Why there will be no landing on an area, None while there may be."""
    complaint: str | None = None
    """What keeps it from knowing where it is, None if nothing does."""
    gaze: Gaze | None = None
    """Turns the heading to look out for what moves; None to look where it flies."""
    after_hold: Phase = Phase.NAVIGATE
    time_us: int = 0
    since_us: int = 0
    """When the present phase began."""
    commands: list[Command] = field(default_factory=list)
    """Sent in the present phase."""
    replans: list[Replan] = field(default_factory=list)
    n_looks: int = 0
    n_areas: int = 1
    n_holds: int = 0

    @property
    def telemetry(self) -> Telemetry:
        """The vehicle as last reported, in the map's frame."""
        return self.senses.telemetry

    @property
    def elapsed_s(self) -> float:
        """Time in the present phase."""
        return (self.time_us - self.since_us) * 1e-6

    @property
    def take_over_us(self) -> int:
        """When a plan that is made now can be flown."""
        return self.time_us + _PLANNING_TIME_US

    @property
    def has_arrived(self) -> bool:
        """Whether what is flown is over and the vehicle rests at its end."""
        return self.course.has_arrived(self.time_us, self.telemetry)

    @property
    def setpoint(self) -> FlatReference:
        """What is flown now."""
        return self.course.reference(self.time_us)

    @property
    def chosen(self) -> LandingSite:
        """The place to land on; only after one was chosen."""
        assert self.site is not None
        return self.site

    @property
    def resting_height_m(self) -> float:
        """Height of the vehicle's origin when it stands on the chosen place."""
        return self.chosen.position_enu_m[2] + self.mission.surroundings.airframe.leg_length_m

    @property
    def home_resting_height_m(self) -> float:
        """Height of the vehicle's origin when it stands at the start."""
        world = self.mission.surroundings
        return world.scene.start_position_enu_m[2] + world.airframe.leg_length_m

    def last_words(self) -> str:
        """The latest text of the autopilot, to go after a reason."""
        texts = self.telemetry.texts
        return f"; the autopilot said: {texts[-1][1]}" if texts else ""

    def is_at_end(self, goal_enu_m: Vector3) -> bool:
        """Whether what is flown ends at a place: where the map grows it may end before."""
        trajectory = self.course.trajectory
        end = trajectory.sample(trajectory.duration_s).position_enu_m
        return math.dist(end, goal_enu_m) < _ON_COURSE_M

    def moving(self) -> MovingObstacles:
        """What moves, predicted from when a new plan can take over."""
        return self.senses.moving(self.take_over_us)

    def room_to_movers_m(self) -> float:
        """How near the rest of what is flown comes to what moves."""
        since_s = self.course.elapsed_s(self.take_over_us)
        radius_m = self.mission.surroundings.radius_m
        return room_to_movers_m(self.course.trajectory, since_s, self.moving(), radius_m)

    def fly(self, trajectory: Trajectory) -> None:
        """Follow a certified trajectory from when a plan can take over."""
        self.course.fly(trajectory, self.take_over_us)

    def begin_with(self, trajectory: Trajectory) -> None:
        """Follow a trajectory that begins where the vehicle rests, from now on."""
        self.course.fly(trajectory, self.time_us)

    def leg(
        self, goal_enu_m: Vector3, speed_mps: float | None = None, *, exempt_m: float = 0.0
    ) -> Trajectory:
        """A certified straight line from the present setpoint, at rest, to rest at a goal.

        Raises:
            PlanningError: If it cannot be proved.
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
        """From rest to a goal nearby: straight if that can be proved, else by a plan.

        Raises:
            PlanningError: If there is no certified way.
        """
        now = self.setpoint
        if math.dist(now.position_enu_m, goal_enu_m) <= _STRAIGHT_M:
            try:
                self.begin_with(self.leg(goal_enu_m, speed_mps))
            except PlanningError:
                if math.dist(now.position_enu_m, goal_enu_m) < _ON_COURSE_M:
                    raise
            else:
                return
        self.plan_to(goal_enu_m)

    def plan_to(self, goal_enu_m: Vector3, prepared: Trajectory | None = None) -> None:
        """Fly a prepared trajectory if it begins here, else plan one from the setpoint.

        Raises:
            PlanningError: If there is none, or none past what moves.
        """
        here = self.telemetry.position_enu_m
        is_here = prepared is not None and (
            math.dist(prepared.sample(0.0).position_enu_m, here) <= _ON_COURSE_M
        )
        if prepared is None or not is_here:
            prepared = self._plan(self.course.reference(self.take_over_us), goal_enu_m)
        self.fly(self._past_movers(prepared))

    def go_on_from(self, start: FlatReference, goal_enu_m: Vector3, reason: str) -> None:
        """Plan anew from a state in which a plan can take over.

        Raises:
            PlanningError: If there is no certified way from there.
        """
        self.fly(self._past_movers(self._plan(start, goal_enu_m)))
        self.replans.append(Replan(time_us=self.time_us, reason=reason))

    def replan(self, reason: str) -> None:
        """Plan the rest of what is flown anew, past what moves.

        Raises:
            PlanningError: If there is none.
        """
        at_s = self.course.elapsed_s(self.take_over_us)
        world, moving = self.mission.surroundings, self.moving()
        self.fly(world.replan(self.course.trajectory, at_s, moving=moving))
        self.replans.append(Replan(time_us=self.time_us, reason=reason))

    def brake(self, start: FlatReference | None = None) -> None:
        """Come to rest as soon as possible, aside where something comes along.

        Args:
            start: Where the vehicle will be when the stop takes over; None for where it should.

        Raises:
            PlanningError: If not even a stop among what stands can be proved.
        """
        world, moving = self.mission.surroundings, self.moving()
        plan, at_s = self.course.trajectory, self.course.elapsed_s(self.take_over_us)
        urgent = replace(world, limits=urgent_limits(world.limits))
        # Where nothing moves, less room to it is no other way.
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

    def _plan(self, start: FlatReference, goal_enu_m: Vector3) -> Trajectory:
        return self.mission.surroundings.plan(start, goal_enu_m)

    def _past_movers(self, plan: Trajectory) -> Trajectory:
        """The same plan, or one around what moves where that would come too near.

        Raises:
            EvasionError: If there is none.
        """
        moving, world = self.moving(), self.mission.surroundings
        if room_to_movers_m(plan, 0.0, moving, world.radius_m) >= KEEP_FROM_MOVERS_M:
            return plan
        return world.replan(plan, 0.0, moving=moving)

    def is_resting(self) -> bool:
        """Whether what is flown stands still now."""
        return math.hypot(*self.setpoint.velocity_enu_mps) < _AT_REST_MPS
