"""Crossing traffic on a plan that is being flown: a trial of replanning and braking, by seed.

The plan is followed exactly and the walker is seen with errors, so that the trial measures the
planner and neither the pilot nor the perception.
"""

from __future__ import annotations

import math
import time
from dataclasses import dataclass

import numpy as np

from autonomy.planning import MovingObstacles, PlanningError, Trajectory
from scenarios.mission.surroundings import Surroundings

_PERSON_RADIUS_M = 0.35
_PERSON_HALF_HEIGHT_M = 0.6
_MOST_SPEED_MPS = 3.0  # walkers run, too
# Sightings, the time that a new plan takes, and the time after the meeting that is looked at.
_LOOK_EVERY_S = 0.2
_PLANNING_TIME_S = 0.1
_AFTER_S = 2.5
# growth of the walker's room in the planner's eyes, for its velocity is uncertain
_GROWTH_MPS = 0.2
_POSITION_SIGMA_M = (0.1, 0.1, 0.1)
_VELOCITY_SIGMA_MPS = (0.2, 0.2, 0.0)
_MARGIN_M = 0.3  # a plan that leads nearer is changed
_STEP_S = 0.02


@dataclass(frozen=True, kw_only=True, slots=True)
class Crossing:
    """Result of a flight past someone who walks across the plan."""

    is_avoided: bool
    has_braked: bool
    """True if the vehicle stopped or stepped aside, because no way past could be certified."""
    has_gone_on: bool
    """True if the vehicle ends at its goal, or on a plan to it."""
    replans_ms: tuple[float, ...]


def fly_past_a_crossing(
    world: Surroundings, plan: Trajectory, rng: np.random.Generator
) -> Crossing | None:
    """Follow a plan exactly, as the pilot does, while a walker crosses it.

    The walker is an upright capsule that moves at 0.5 to 3 m/s on a straight line, even through
    walls, and meets the vehicle at a point of the plan 2 to 4 s after the start. It is seen five
    times a second from the start on, with errors of 0.1 m and 0.2 m/s. Where the plan leads nearer
    than 0.3 m, a new one takes over 0.1 s later; without one the vehicle stops or steps aside, and
    tries to continue with each sighting.

    Args:
        world: World that the plan was made in.
        plan: Plan.
        rng: Source of the walker and of all errors.

    Returns:
        The result; None if the plan is too short, or the walker would start within 0.6 m.
    """
    at_s = rng.uniform(2.0, 4.0)
    speed, heading = rng.uniform(0.5, _MOST_SPEED_MPS), rng.uniform(-math.pi, math.pi)
    if plan.duration_s < at_s + 0.5:
        return None
    velocity = speed * np.array([math.cos(heading), math.sin(heading), 0.0])
    meet = plan.positions(np.array([at_s]))[0]
    # Its room does not grow: this is the true walker.
    walker = _capsule(meet - velocity * at_s, velocity, growth_mps=0.0)
    if walker.distances(plan.positions(np.zeros(1)), np.zeros(1))[0][0, 0] < world.radius_m + 0.6:
        return None
    flight = _Flight(world, plan)
    least_m = math.inf
    for look in range(math.ceil((at_s + _AFTER_S) / _LOOK_EVERY_S)):
        now_s = look * _LOOK_EVERY_S
        seen_velocity = velocity + rng.normal(0.0, _VELOCITY_SIGMA_MPS)
        seen = walker.position_enu_m[0] + velocity * now_s + rng.normal(0.0, _POSITION_SIGMA_M)
        # A new plan begins after the time that planning takes, when the walker has moved on.
        ahead = seen + seen_velocity * _PLANNING_TIME_S
        t = now_s + np.arange(0.0, _PLANNING_TIME_S, _STEP_S)
        path = [flight.positions(t)]
        flight.look(now_s + _PLANNING_TIME_S, _capsule(ahead, seen_velocity))
        later = now_s + np.arange(_PLANNING_TIME_S, _LOOK_EVERY_S, _STEP_S)
        path.append(flight.positions(later))
        gap = walker.distances(np.concatenate(path), np.concatenate([t, later]))[0][0]
        least_m = min(least_m, float(gap.min()))
    return Crossing(
        is_avoided=least_m > world.radius_m,
        has_braked=flight.has_braked,
        has_gone_on=not flight.is_holding,
        replans_ms=tuple(flight.replans_ms),
    )


class _Flight:
    """Present plan, and the way to the goal if that plan is a stop."""

    def __init__(self, world: Surroundings, plan: Trajectory) -> None:
        self._world, self._plan, self._since_s = world, plan, 0.0
        self._way, self._way_at_s = plan, 0.0
        self.is_holding, self.has_braked = False, False
        self.replans_ms: list[float] = []

    def positions(self, times_s: np.ndarray) -> np.ndarray:
        """Positions of the vehicle at times of the trial, n x 3."""
        return self._plan.positions(times_s - self._since_s)

    def look(self, then_s: float, seen: MovingObstacles) -> None:
        """Change the plan from a given time on, if necessary.

        Args:
            then_s: Time at which a new plan would begin.
            seen: The walker as seen, at that time.
        """
        at_s = then_s - self._since_s
        if not self.is_holding and not self._meets(at_s, seen, _MARGIN_M):
            return
        begun_s = time.process_time()
        try:
            plan, is_stop = self._go_on(at_s, seen), False
        except PlanningError:
            plan, is_stop = self._stop(at_s, seen), True
        self.replans_ms.append(1e3 * (time.process_time() - begun_s))
        if plan is None:
            return
        # The first stop keeps the way that it interrupts; further ones must not.
        if is_stop and not self.is_holding:
            self._way, self._way_at_s = self._plan, at_s
        self._plan, self._since_s, self.is_holding = plan, then_s, is_stop
        self.has_braked |= is_stop

    def _go_on(self, at_s: float, seen: MovingObstacles) -> Trajectory:
        if not self.is_holding:
            return self._world.replan(self._plan, at_s, moving=seen)
        # From the middle of a stop back to the way that it has interrupted.
        start = self._plan.sample(at_s)
        return self._world.replan(self._way, self._way_at_s, moving=seen, start=start)

    def _stop(self, at_s: float, seen: MovingObstacles) -> Trajectory | None:
        """A stop; None if the present one suffices, or none can be certified."""
        world = self._world
        if self.is_holding and not self._meets(at_s, seen, world.planner.min_margin_m):
            return None
        try:
            return world.brake(self._plan, at_s, moving=seen)
        except PlanningError:
            return None

    def _meets(self, at_s: float, seen: MovingObstacles, margin_m: float) -> bool:
        """True if the present plan comes nearer than a margin to what is seen."""
        t = np.arange(0.0, seen.horizon_s, 0.05)
        distance = seen.distances(self._plan.positions(at_s + t), t)[0]
        return bool(distance.min() < self._world.radius_m + margin_m)


def _capsule(
    position_enu_m: np.ndarray, velocity_enu_mps: np.ndarray, growth_mps: float = _GROWTH_MPS
) -> MovingObstacles:
    return MovingObstacles(
        position_enu_m=position_enu_m[None],
        velocity_enu_mps=velocity_enu_mps[None],
        radius_m=np.array([_PERSON_RADIUS_M]),
        half_extent_m=np.array([[0.0, 0.0, _PERSON_HALF_HEIGHT_M]]),
        yaw_rad=np.zeros(1),
        growth_mps=growth_mps,
    )
