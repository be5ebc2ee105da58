"""Plans towards a goal through a place that is only partly seen.

A search finds a path to the goal, at a price also through unseen cells. The vehicle flies only the
part of that path that lies in space seen free. This part is planned, proved against everything else
as an obstacle, and ends at rest, so that the vehicle can always stay where its plan ends. As more
is seen, a new plan takes over. If the path goes on to cells that the camera does not see from
there, because they are above, below or behind, the vehicle looks at them first (`errands`). Cells
that stay unseen although it looked at them are taken for occupied.

Source: a plan that may use the unknown together with one that stops in the known, as in Tordesillas
et al. 2019 (FASTER), here one after the other and each proved exactly.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from jaxtyping import Int

from autonomy.mapping.agenda import Agenda
from autonomy.mapping.coarse_path import nearest_cell
from autonomy.mapping.errands import pursue, set_out
from autonomy.mapping.rays import HIT
from autonomy.mapping.seen_map import SeenMap
from autonomy.mapping.task import Task, in_words
from autonomy.planning.craft import Craft
from autonomy.planning.errors import BlockedError, PlanningError, UnreachableError
from autonomy.planning.field import DistanceField
from autonomy.planning.legs import plan_leg
from autonomy.planning.search import shortest_path
from autonomy.planning.trajectory import Trajectory
from autonomy.types import FlatReference, Vector3

WORTHWHILE_M = 0.5
"""Length below which a path is not flown: the vehicle looks where the path goes on instead."""
FURTHER_M = 1.0
"""Distance beyond the end of the present plan that a new plan must gain during flight."""
SEARCH_IMAGES = 3
"""Number of images between two searches for a path during flight."""
_N_SAMPLES = 50
"""Number of places along a plan at which it is checked against what was seen since."""
_MOST_GIVEN_UP = 12
"""Number of paths that one call tries: each may give up some cells and search again."""
_CLIMB_PRICE = 2.0
"""Price in cells of a rise by one cell through unseen space."""
_WIDE_EXCESS = 0.3
"""Share by which a path through a wide map may cost more than the cheapest one. Unseen cells cost a
quarter more than the estimate of a search expects, so that an exact one looks at nearly all."""


def plan_towards(
    seen: SeenMap, agenda: Agenda, start: FlatReference, goal_enu_m: Vector3, craft: Craft
) -> Trajectory:
    """Plan a certified trajectory within seen free space: to the goal, towards it, or for a look.

    Args:
        seen: Map so far; cells that stay unseen though looked at become occupied in it.
        agenda: Memory of the vehicle from plan to plan, changed by each.
        start: State of the vehicle.
        goal_enu_m: Position to go to.
        craft: Vehicle that flies.

    Returns:
        A plan that ends at rest; at the goal, if that is within seen free space.

    Raises:
        BlockedError: If start or goal is off the map, or the goal too near to what was seen.
        UnreachableError: If no path is left that may lead to the goal.
        PlanningError: If nothing better can be planned while the vehicle moves, or proved.
    """
    # The map knows no distance above its cap, so none above it can be more comfortable.
    comfortable_m = seen.cfg.cap_m - craft.cfg.vehicle_radius_m
    cfg = dataclasses.replace(craft.cfg, comfortable_m=comfortable_m)
    task = Task(seen, agenda, start, goal_enu_m, dataclasses.replace(craft, cfg=cfg))
    _require_place(task)
    plan = _next_plan(task)
    agenda.plan = plan
    return plan


def _next_plan(task: Task) -> Trajectory:
    """Pursue the errand, or search a path and plan along it, until something can be flown."""
    seen = task.seen
    for _ in range(_MOST_GIVEN_UP):
        look = None if task.agenda.errand is None else pursue(task, task.agenda.errand)
        if look is not None:
            return look
        _require_news(task)
        path = _way(task)
        n_open = _n_open(task, path)
        is_near = task.away_m(task.point(path[n_open - 1])) < WORTHWHILE_M
        # In a wide map the path may end before the goal; then it is flown like any part of a path.
        if n_open == len(path) and np.array_equal(path[-1], task.goal_cell):
            try:
                return task.fly(path, task.goal_enu_m)
            except PlanningError:
                # From nearer, or past the clutter, there may be a plan for the rest.
                if is_near:
                    raise
        elif is_near and n_open < len(path):
            set_out(task, path[n_open:])
            continue
        try:
            return _fly_some(task, path[:n_open])
        except PlanningError:
            if task.is_moving or n_open == len(path):
                raise
            # At rest nothing would change until the next attempt, so the path must.
            seen.give_up(path[n_open - 1 : n_open])
    raise UnreachableError(
        f"goal {in_words(task.goal_enu_m)} stays out of sight: {_MOST_GIVEN_UP} ways on were "
        "looked at in vain; valid: another goal, or plan again from elsewhere"
    )


def _has_plan(task: Task) -> bool:
    """Return whether the vehicle flies a plan that is still free by all that is known."""
    plan = task.agenda.plan
    if not task.is_moving or plan is None:
        return False
    points = plan.positions(np.linspace(0.0, plan.duration_s, _N_SAMPLES))
    # Not from the distance field, which would be computed anew about all that has changed: this is
    # asked with every image, but only every third leads to a search, which needs the field.
    room_m = task.seen.distance_m(task.seen.centres(task.seen.cells(points)))
    return bool(np.all(room_m >= task.craft.cfg.vehicle_radius_m))


def _require_news(task: Task) -> None:
    """Refuse a search if too few images came since the last one and there is a plan to fly.

    The present plan ends at rest in free space, so that nothing is lost by waiting for images.

    Raises:
        PlanningError: If the present plan should be flown on.
    """
    seen = task.seen
    n_new = seen.n_looks - task.agenda.searched_at
    if n_new < SEARCH_IMAGES and _has_plan(task):
        raise PlanningError(
            f"{n_new} images were taken since the last search; valid: fly the plan on and plan "
            f"again after {SEARCH_IMAGES}"
        )
    task.agenda.searched_at = seen.n_looks


def _require_place(task: Task) -> None:
    """Refuse a start or goal off the map, and a goal too near to what was seen.

    Raises:
        BlockedError: With the place and what would be valid.
    """
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
    """Return the cells of a path from start to goal, through unseen space as well.

    In a wide map it ends short of a goal that is farther than a search reaches.

    Raises:
        UnreachableError: If nothing that may be free joins them.
    """
    seen, needed_m = task.seen, task.needed_m
    block = seen.search_block(task.start_cell)
    route = seen.route_in(block, needed_m)
    start, goal = task.start_cell - block[0], _goal_in(task, block, route)
    # An end may have less room than the vehicle needs, as where it stands beside a wall. The path
    # may then be as narrow, but not through the wall: a quarter of a cell is the least.
    at_ends_m = min(float(route.distance_m[tuple(cell)]) for cell in (start, goal))
    path = shortest_path(
        route,
        start,
        goal,
        required_m=min(needed_m, max(at_ends_m, route.resolution_m / 4)),
        comfortable_m=seen.cfg.cap_m,
        seen=seen.seen_room(block, needed_m),
        climb_price=_CLIMB_PRICE,
        excess=_WIDE_EXCESS if seen.is_wide else 0.0,
    )
    return path + block[0]


def _goal_in(task: Task, block: np.ndarray, route: DistanceField) -> Int[np.ndarray, " 3"]:
    """Return the index in a block of the goal's cell, or of one at the border on the way there.

    Raises:
        UnreachableError: If nothing is free where the line to the goal leaves the block.
    """
    start, goal = task.start_cell, task.goal_cell
    if np.all((goal >= block[0]) & (goal < block[1])):
        return goal - block[0]
    way = (goal - start).astype(float)
    # The share of the line within the block, by the border that it meets first.
    borders = np.where(way > 0.0, block[1] - 1, block[0]) - start
    leaves = np.all([way != 0.0, (goal < block[0]) | (goal >= block[1])], axis=0)
    share = float(np.min(borders[leaves] / way[leaves]))
    # The cell there may be occupied: any free one around it leads on as well.
    at = np.rint(start + share * way).astype(np.int64) - block[0]
    found = nearest_cell(route.distance_m >= task.needed_m, at)
    if found is None:
        raise UnreachableError(
            f"the way to {in_words(task.goal_enu_m)} is closed at {in_words(route.centres(at))}; "
            "valid: another goal, or plan again from elsewhere"
        )
    return found


def _n_open(task: Task, path: np.ndarray) -> int:
    """Count the cells from the beginning of a path around which enough room was seen free.

    Returns:
        Number of cells that may be flown; the length of the path if all of it may.
    """
    distance_m = task.seen.field.distance_m[tuple(path.T)]
    # If the start itself has less room, the path out of there may have as little.
    needed = np.full(len(path), task.needed_m)
    away = np.linalg.norm(path - path[0], axis=1) * task.seen.cfg.resolution_m
    needed[away < 2 * task.craft.cfg.vehicle_radius_m] = min(float(distance_m[0]), task.needed_m)
    # `argmax` gives the first closed cell, and 0 if none is closed, hence the second question.
    is_closed = distance_m < needed
    return int(np.argmax(is_closed)) if is_closed.any() else len(path)


def _fly_some(task: Task, path: Int[np.ndarray, "n 3"]) -> Trajectory:
    """Plan as far along a path as can be proved: all of it, half of it, or a straight leg.

    Raises:
        PlanningError: If nothing can be proved, or the plan gains too little over the present one.
    """
    end = task.point(path[-1])
    plan = task.agenda.plan
    if plan is not None and _has_plan(task):
        last = plan.sample(plan.duration_s).position_enu_m
        if math.dist(end, last) < FURTHER_M:
            raise PlanningError(
                f"the way on from {in_words(last)} is not seen yet; valid: fly the plan to its end "
                "and plan again"
            )
    # The first half may be proved where the whole cannot.
    half = path[: len(path) // 2 + 1]
    for part in (path, half):
        try:
            return task.fly(part, task.point(part[-1]))
        except PlanningError:
            continue
    return _straight(task, half)


def _straight(task: Task, path: Int[np.ndarray, "n 3"]) -> Trajectory:
    """Plan a straight leg from rest to the end of a path, where clutter allows no better plan.

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
