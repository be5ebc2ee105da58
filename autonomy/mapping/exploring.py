"""Plans towards a goal through a place that is only partly seen.

A search leads to the goal, at a price also through unseen cells. Only the part of its way before it
leaves seen free space is flown, planned and proved against all the rest, and the plan ends at rest:
the vehicle can always stay where its plan ends. As more is seen, a new plan takes over. Where the
way leads on to cells that the camera does not see from there, because they are above, below or
behind, the vehicle turns, or flies to where it sees most of them for the time that takes. Cells
that stay unseen though they were looked at are taken for occupied.

Source: a plan that may use the unknown together with one that stops in the known, as in Tordesillas
et al. 2019 (FASTER), here one after the other and each proved exactly.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from jaxtyping import Int

from autonomy.mapping.agenda import Agenda
from autonomy.mapping.errands import pursue, set_out
from autonomy.mapping.rays import HIT
from autonomy.mapping.seen_map import SeenMap
from autonomy.mapping.task import Task, in_words
from autonomy.planning.craft import Craft
from autonomy.planning.errors import BlockedError, PlanningError, UnreachableError
from autonomy.planning.legs import plan_leg
from autonomy.planning.search import shortest_path
from autonomy.planning.trajectory import Trajectory
from autonomy.types import FlatReference, Vector3

WORTHWHILE_M = 0.5
"""Length below which a way is not flown: the vehicle rather looks where the way goes on."""
FURTHER_M = 1.0
"""Distance beyond the end of the present plan that a new plan must gain during flight."""
SEARCH_IMAGES = 3
"""Number of images between two searches for a way during flight."""
_N_SAMPLES = 50
_MOST_GIVEN_UP = 12
_CLIMB_PRICE = 2.0
"""Price in cells of a rise by one cell through unseen space."""


def plan_towards(
    seen: SeenMap, agenda: Agenda, start: FlatReference, goal_enu_m: Vector3, craft: Craft
) -> Trajectory:
    """Plan a certified trajectory within seen free space: to the goal, towards it, or for a look.

    Args:
        seen: Map so far; cells that stay unseen though looked at become occupied in it.
        agenda: What the vehicle remembers from plan to plan, changed by each.
        start: State of the vehicle.
        goal_enu_m: Position to go to.
        craft: Vehicle that flies.

    Returns:
        A plan that ends at rest; at the goal, if that is within seen free space.

    Raises:
        BlockedError: If start or goal is off the map, or the goal too near to what was seen.
        UnreachableError: If no way is left that may lead to the goal.
        PlanningError: If nothing better can be planned while the vehicle moves, or proved.
    """
    comfortable_m = seen.cfg.cap_m - craft.cfg.vehicle_radius_m
    cfg = dataclasses.replace(craft.cfg, comfortable_m=comfortable_m)
    task = Task(seen, agenda, start, goal_enu_m, dataclasses.replace(craft, cfg=cfg))
    _require_place(task)
    plan = _next_plan(task)
    agenda.plan = plan
    return plan


def _next_plan(task: Task) -> Trajectory:
    seen = task.seen
    for _ in range(_MOST_GIVEN_UP):
        look = None if task.agenda.errand is None else pursue(task, task.agenda.errand)
        if look is not None:
            return look
        _require_news(task)
        path = _way(task)
        n_open = _n_open(task, path)
        is_near = task.away_m(task.point(path[n_open - 1])) < WORTHWHILE_M
        if n_open == len(path):
            try:
                return task.fly(path, task.goal_enu_m)
            except PlanningError:
                # From nearer, or past the clutter, there may be a plan for the rest.
                if is_near:
                    raise
        elif is_near:
            set_out(task, path[n_open:])
            continue
        try:
            return _fly_some(task, path[:n_open])
        except PlanningError:
            if task.is_moving or n_open == len(path):
                raise
            seen.give_up(path[n_open - 1 : n_open])
    raise UnreachableError(
        f"goal {in_words(task.goal_enu_m)} stays out of sight: {_MOST_GIVEN_UP} ways on were "
        "looked at in vain; valid: another goal, or plan again from elsewhere"
    )


def _has_plan(task: Task) -> bool:
    """Whether the vehicle flies a plan that is still free by all that is known."""
    plan = task.agenda.plan
    if not task.is_moving or plan is None:
        return False
    points = plan.positions(np.linspace(0.0, plan.duration_s, _N_SAMPLES))
    room_m = task.seen.field.distance_m[tuple(task.seen.cells(points).T)]
    return bool(np.all(room_m >= task.craft.cfg.vehicle_radius_m))


def _require_news(task: Task) -> None:
    """Refuse a new search with every image while there is a plan to fly."""
    seen = task.seen
    n_new = seen.n_looks - task.agenda.searched_at
    if n_new < SEARCH_IMAGES and _has_plan(task):
        raise PlanningError(
            f"{n_new} images were taken since the last search; valid: fly the plan on and plan "
            f"again after {SEARCH_IMAGES}"
        )
    task.agenda.searched_at = seen.n_looks


def _require_place(task: Task) -> None:
    shape = task.seen.evidence.shape
    for name, point in (("start", task.start.position_enu_m), ("goal", task.goal_enu_m)):
        cell = task.seen.cells(np.array(point))
        if np.any(cell < 0) or np.any(cell >= shape):
            low = task.seen.corner_enu_m
            high = low + np.array(shape) * task.seen.cfg.resolution_m
            raise BlockedError(
                f"{name} {in_words(point)} is outside the map; valid: {low.round(1)} to "
                f"{high.round(1)}"
            )
    goal = np.array([task.goal_enu_m])
    room_m = float(task.seen.distance_to_seen_m(goal, HIT)[0])
    least_m = task.craft.cfg.vehicle_radius_m + task.craft.cfg.min_margin_m
    if room_m <= least_m:
        raise BlockedError(
            f"goal {in_words(task.goal_enu_m)} is {room_m:.2f} m from what was seen; "
            f"valid: more than {least_m:.2f} m"
        )


def _way(task: Task) -> Int[np.ndarray, "n 3"]:
    """Cells of a way from start to goal, through unseen space as well."""
    route = dataclasses.replace(task.seen.field, distance_m=task.seen.route_m(task.needed_m))
    start, goal = task.start_cell, task.seen.cells(np.array(task.goal_enu_m))
    at_ends_m = min(float(route.distance_m[tuple(cell)]) for cell in (start, goal))
    return shortest_path(
        route,
        start,
        goal,
        required_m=min(task.needed_m, max(at_ends_m, route.resolution_m / 4)),
        comfortable_m=task.seen.cfg.cap_m,
        seen=task.seen.seen_room(task.needed_m),
        climb_price=_CLIMB_PRICE,
    )


def _n_open(task: Task, path: np.ndarray) -> int:
    """Number of cells, from the beginning of a way, around which enough room was seen free."""
    distance_m = task.seen.field.distance_m[tuple(path.T)]
    # Where the start itself has less room, the way out of there may have as little.
    needed = np.full(len(path), task.needed_m)
    away = np.linalg.norm(path - path[0], axis=1) * task.seen.cfg.resolution_m
    needed[away < 2 * task.craft.cfg.vehicle_radius_m] = min(float(distance_m[0]), task.needed_m)
    is_closed = distance_m < needed
    return int(np.argmax(is_closed)) if is_closed.any() else len(path)


def _fly_some(task: Task, path: Int[np.ndarray, "n 3"]) -> Trajectory:
    """Plan as far along a way as can be proved."""
    end = task.point(path[-1])
    plan = task.agenda.plan
    if plan is not None and _has_plan(task):
        last = plan.sample(plan.duration_s).position_enu_m
        if math.dist(end, last) < FURTHER_M:
            raise PlanningError(
                f"the way on from {in_words(last)} is not seen yet; valid: fly the plan to its end "
                "and plan again"
            )
    half = path[: len(path) // 2 + 1]
    for part in (path, half):
        try:
            return task.fly(part, task.point(part[-1]))
        except PlanningError:
            continue
    return _straight(task, half)


def _straight(task: Task, path: Int[np.ndarray, "n 3"]) -> Trajectory:
    """Plan a straight leg from rest to a point on a way, where clutter allows no better plan.

    Raises:
        PlanningError: If the leg cannot be proved, or the vehicle moves.
    """
    end = task.point(path[-1])
    start = task.start
    if task.is_moving or task.away_m(end) < WORTHWHILE_M:
        raise PlanningError(
            f"no plan leads on from {in_words(start.position_enu_m)}; valid: plan from rest"
        )
    leg = plan_leg(
        start.position_enu_m, end, start.yaw_rad, task.craft.limits, task.craft.quadrotor
    )
    return task.proved(leg, task.craft.cfg.min_margin_m)
