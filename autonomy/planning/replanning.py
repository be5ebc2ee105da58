"""Replanning in flight: the rest of a plan, optimised again around moving obstacles.

A plan from scratch takes up to half a second; a mover does not wait so long. The free space of the
plan is kept, and its times are good guesses, so a few quadratic programs are enough. An obstacle
that moves gets a plane in each piece that it comes near to. The plane moves along with it, so for
motion that is straight in the obstacle's frame one plane parts the two, and the hull of the control
points proves it for the whole piece.

The side to pass on is found by trial: the side of the plan if it already clears the obstacle, else
left, right, above and below, as seen along the motion relative to the obstacle, and a slower
flight. The first choice that can be proved and costs little time is taken, else the quickest. If
none can be proved, the rest of the plan stays as it is, if that can be proved.
"""

from __future__ import annotations

import dataclasses
import functools
from dataclasses import dataclass

import numpy as np

from autonomy.planning.corridor import Corridor
from autonomy.planning.craft import Craft
from autonomy.planning.demand import excess
from autonomy.planning.errors import EvasionError, PlanningError
from autonomy.planning.evasion import Rest, no_nearer, remainder
from autonomy.planning.moving_obstacles import NOTHING_MOVES, MovingObstacles
from autonomy.planning.obstacles import Obstacles
from autonomy.planning.optimiser import EVADING, WARM, optimise
from autonomy.planning.planner import as_node, bounds_for, with_yaw
from autonomy.planning.trajectory import Trajectory, coefficients_from_nodes
from autonomy.types import ZERO3, FlatReference

MOVING_MARGIN_M = 0.3
"""Distance to aim at between the vehicle's sphere and a predicted obstacle. The proof demands less.
"""
_SMALL_DELAY_S = 1.0
"""Delay up to which a path around is taken without trying the other sides."""


def replan(
    previous: Trajectory,
    at_time_s: float,
    obstacles: Obstacles,
    craft: Craft,
    *,
    moving: MovingObstacles = NOTHING_MOVES,
    start: FlatReference | None = None,
) -> Trajectory:
    """Plan a certified trajectory for the rest of a plan.

    Args:
        previous: A plan by `plan_trajectory` with the optimiser, or by this function.
        at_time_s: Time of that plan from which the new one, at its time 0, takes over.
        obstacles: Static obstacles, for the proof.
        craft: Vehicle that flies.
        moving: Moving obstacles, predicted from `at_time_s` on. One nearer to the start than the
            margin is proved to come no nearer.
        start: State of the vehicle at that time; None for the state of the plan.

    Raises:
        PlanningError: If the plan is over or has no corridor, or if the start has left it.
        LimitsError: If the start is beyond the limits.
        EvasionError: If no path around the moving obstacles could be proved: hold, or plan anew.
        CertificateError: If nothing moves and the rest of the plan could not be proved.
    """
    if previous.corridor is None or not 0 <= at_time_s < previous.duration_s:
        raise PlanningError(
            f"at_time_s {at_time_s:.2f} is not within a plan with a corridor; valid: a plan of "
            f"plan_trajectory by method 'optimise', 0 to {previous.duration_s:.2f} s"
        )
    begin = previous.sample(at_time_s) if start is None else start
    moving = no_nearer(moving, np.array(begin.position_enu_m), craft.keep_m)
    rest = Rest(previous, previous.corridor, at_time_s, moving)
    task = _Task(begin, obstacles, craft, moving)
    best, reason = _quickest(task, rest)
    if best is not None:
        return best
    # Only without a given start: from another state the old plan leads nowhere.
    if start is None:
        try:
            return task.prove(*remainder(previous, previous.corridor, at_time_s))
        except PlanningError as error:
            reason = error
    assert reason is not None
    if len(moving):
        raise EvasionError(
            f"no way past what moves ({reason}); valid: hold, wait or plan anew"
        ) from reason
    raise reason


def _quickest(task: _Task, rest: Rest) -> tuple[Trajectory | None, PlanningError | None]:
    """The first path around that costs little time, else the quickest, and the last failure."""
    reason: PlanningError | None = None
    best: Trajectory | None = None
    for corridor, first_s in rest.problems(task.craft.cfg.vehicle_radius_m + MOVING_MARGIN_M):
        try:
            trajectory = task.solve(corridor, first_s, rest.goal_enu_m)
        except PlanningError as error:
            reason = error
            continue
        if best is None or trajectory.duration_s < best.duration_s:
            # Keep the corridor without the moving planes: the next replan adds its own.
            best = dataclasses.replace(
                trajectory,
                corridor=dataclasses.replace(corridor, moving_mps=None, planes=rest.planes),
            )
        if best.duration_s <= rest.duration_s + _SMALL_DELAY_S:
            break
    return best, reason


@dataclass(frozen=True, slots=True)
class _Task:
    """The arguments of a replan."""

    begin: FlatReference
    obstacles: Obstacles
    craft: Craft
    moving: MovingObstacles

    def solve(self, corridor: Corridor, first_s: np.ndarray, goal_enu_m: np.ndarray) -> Trajectory:
        """Plan a certified trajectory through a corridor.

        Raises:
            PlanningError: If there is no such trajectory.
        """
        limits, quadrotor = self.craft.limits, self.craft.quadrotor
        solution = optimise(
            as_node(self.begin),
            np.array([goal_enu_m, ZERO3, ZERO3]),
            corridor,
            bounds_for(self.begin, limits, quadrotor),
            excess=functools.partial(excess, limits=limits, quadrotor=quadrotor),
            first_s=first_s,
            search=WARM if corridor.moving_mps is None else EVADING,
        )
        coefficients = coefficients_from_nodes(solution.nodes, solution.durations_s)
        return self.prove(coefficients, solution.durations_s, corridor)

    def prove(
        self, coefficients: np.ndarray, durations_s: np.ndarray, corridor: Corridor
    ) -> Trajectory:
        """Add the heading to a trajectory and certify it.

        Raises:
            CertificateError: If the trajectory breaks the clearance or a limit.
        """
        begin, limits = self.begin, self.craft.limits
        trajectory = with_yaw(
            coefficients, durations_s, begin.yaw_rad, limits, begin.yaw_rate_radps
        )
        proved = self.craft.prove(trajectory, self.obstacles, moving=self.moving)
        return dataclasses.replace(proved, corridor=corridor)
