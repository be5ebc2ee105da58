"""Plan through any map: straight to the goal in a given one, step by step in one that grows."""

from __future__ import annotations

from autonomy.mapping.agenda import Agenda
from autonomy.mapping.exploring import plan_towards
from autonomy.mapping.map import Map
from autonomy.mapping.seen_map import SeenMap
from autonomy.mapping.wide_map import WideMap
from autonomy.planning.craft import Craft
from autonomy.planning.planner import plan_trajectory
from autonomy.planning.trajectory import Trajectory
from autonomy.types import FlatReference, Vector3


def plan_within(
    known: Map, agenda: Agenda, start: FlatReference, goal_enu_m: Vector3, craft: Craft
) -> Trajectory:
    """Plan a certified trajectory to a goal, or towards it as far as space is known to be free.

    Args:
        known: Map of the place.
        agenda: Memory of the vehicle from plan to plan; used and changed in a map that grows.
        start: State of the vehicle.
        goal_enu_m: Position to go to.
        craft: Vehicle that flies.

    Returns:
        A trajectory that ends at rest. In a map that grows it may end short of the goal, or be a
        turn or a nod on the spot, see `plan_towards`.

    Raises:
        PlanningError: If there is none, with the reason.
    """
    if isinstance(known, SeenMap):
        return plan_towards(known, agenda, start, goal_enu_m, craft)
    if isinstance(known, WideMap):
        return known.plan(start, goal_enu_m, craft)
    return plan_trajectory(start, goal_enu_m, known.field, known.obstacles, craft)
