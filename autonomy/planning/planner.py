"""Planner from a state to a goal through free space: search, corridor, optimisation, proof.

Each stage hands a simpler problem to the next: the search finds which gaps to pass, the corridor
makes that choice convex, the optimiser finds the best motion within it, and the proof trusts none
of them. If an attempt fails, a smaller margin is tried.
"""

from __future__ import annotations

import dataclasses
import functools
import math
from dataclasses import dataclass

import numpy as np

from autonomy.model.quadrotor import QuadrotorParams
from autonomy.planning.corridor import build_corridor, refine, straighten
from autonomy.planning.craft import Craft
from autonomy.planning.demand import excess
from autonomy.planning.errors import BlockedError, CertificateError, LimitsError, PlanningError
from autonomy.planning.field import DistanceField
from autonomy.planning.limits import FlightLimits, MotionBounds
from autonomy.planning.obstacles import Obstacles
from autonomy.planning.optimiser import optimise
from autonomy.planning.passages import path_through_openings
from autonomy.planning.primitives import fly_primitives
from autonomy.planning.program import pieces_to_fill
from autonomy.planning.search import shortest_path
from autonomy.planning.trajectory import Trajectory, YawProfile, coefficients_from_nodes
from autonomy.planning.yaw import STEP_S, yaw_along_path
from autonomy.types import ZERO3, FlatReference, Vector3

_START_TOLERANCE = 5e-3
"""Share by which a plan's own states may be beyond its limits after many replans. The proof grants
twice that."""
_MOVING_MPS = 0.3
"""Speed above which a start gets a short first piece, because its velocity fixes that piece."""


def plan_trajectory(
    start: FlatReference,
    goal_enu_m: Vector3,
    field: DistanceField,
    obstacles: Obstacles,
    craft: Craft,
) -> Trajectory:
    """Plan a certified trajectory from the vehicle's state to rest at the goal.

    Args:
        start: State of the vehicle; the heading begins at its yaw.
        goal_enu_m: Position to stop at.
        field: Distances for search and corridor.
        obstacles: Exact obstacles of the same space, for the proof.
        craft: Vehicle that flies.

    Raises:
        BlockedError: If start or goal has no room.
        UnreachableError: If free space does not join them.
        LimitsError: If the limits contradict themselves or the start's velocity.
        CertificateError: If no attempt could be proved.
    """
    cfg = craft.cfg
    bounds = bounds_for(start, craft.limits, craft.quadrotor)
    _require_room(start.position_enu_m, "start", field, obstacles, craft.keep_m)
    _require_room(goal_enu_m, "goal", field, obstacles, craft.keep_m)
    task = _Task(start, goal_enu_m, field, obstacles, bounds, craft)
    # A cell may report too little room, never too much. So before giving up, also search cells that
    # may be wrong by half a cell: the exact obstacles decide in the end whether that can be flown.
    attempts = [(margin_m, 0.0) for margin_m in cfg.margins_m]
    attempts.append((cfg.margins_m[-1], field.resolution_m / 2))
    reason: PlanningError | None = None
    for margin_m, doubt_m in attempts:
        try:
            return craft.prove(_attempt(task, margin_m, doubt_m), obstacles)
        except PlanningError as error:
            # The failure of a path that was found says more than "cut off" for a narrower one.
            reason = error if reason is None or not isinstance(reason, CertificateError) else reason
    assert reason is not None
    raise reason


def bounds_for(
    start: FlatReference, limits: FlightLimits, quadrotor: QuadrotorParams
) -> MotionBounds:
    """Return the bounds of a motion that continues from a start, raised to include it.

    Raises:
        LimitsError: If the limits contradict themselves or the start is beyond them.
    """
    bounds = limits.motion_bounds(quadrotor)
    speed = math.hypot(*start.velocity_enu_mps[:2])
    acceleration = math.hypot(*start.acceleration_enu_mps2[:2])
    raised: dict[str, float] = {}
    for name, value in (
        ("speed_horizontal_mps", speed),
        ("speed_vertical_mps", abs(start.velocity_enu_mps[2])),
        ("acceleration_horizontal_mps2", acceleration),
        ("acceleration_vertical_mps2", abs(start.acceleration_enu_mps2[2])),
    ):
        limit = getattr(bounds, name)
        # "Not at most" instead of "above", so that NaN fails.
        if not value <= limit * (1 + _START_TOLERANCE):
            what = " ".join(reversed(name.split("_")[:2]))
            raise LimitsError(f"start has a {what} of {value:.2f}; valid: at most {limit:.2f}")
        raised[name] = max(limit, value)
    return dataclasses.replace(bounds, **raised)


def _require_room(
    point_enu_m: Vector3, name: str, field: DistanceField, obstacles: Obstacles, needed_m: float
) -> None:
    x, y, z = point_enu_m
    where = f"{name} ({x:.2f}, {y:.2f}, {z:.2f}) m"
    if not all(map(math.isfinite, point_enu_m)):
        raise BlockedError(f"{where} is no place; valid: finite numbers")
    if not field.contains(np.array(point_enu_m)):
        low, high = field.bounds_enu_m
        raise BlockedError(f"{where} is outside the map; valid: {low.round(1)} to {high.round(1)}")
    distance_m, nearest = obstacles.signed_distance(np.array([point_enu_m]))
    if distance_m[0] <= needed_m:
        raise BlockedError(
            f"{where} is {distance_m[0]:.2f} m from obstacle {nearest[0]}; "
            f"valid: more than {needed_m:.2f} m"
        )


@dataclass(frozen=True, slots=True)
class _Task:
    """The arguments of a plan."""

    start: FlatReference
    goal_enu_m: Vector3
    field: DistanceField
    obstacles: Obstacles
    bounds: MotionBounds
    craft: Craft


def _attempt(task: _Task, margin_m: float, doubt_m: float) -> Trajectory:
    """Plan a trajectory that keeps a margin where it can; not proved yet.

    The search also enters cells whose distance lacks `doubt_m`.
    """
    start, field, craft, cfg = task.start, task.field, task.craft, task.craft.cfg
    ends = np.array([start.position_enu_m, task.goal_enu_m])
    start_cell, goal_cell = field.cells(ends)
    wanted_m = cfg.vehicle_radius_m + margin_m
    # Start and goal may be closer to obstacles than the rest of the path.
    at_ends_m = min(float(field.distance_m[tuple(cell)]) for cell in (start_cell, goal_cell))
    required_m = min(wanted_m - doubt_m, max(at_ends_m, field.resolution_m / 4))
    search = functools.partial(
        shortest_path,
        start_cell=start_cell,
        goal_cell=goal_cell,
        required_m=required_m,
        comfortable_m=cfg.vehicle_radius_m + cfg.comfortable_m,
        excess=cfg.search_excess,
    )
    if doubt_m > 0.0:
        points = path_through_openings(search, field, task.obstacles, max(craft.keep_m, required_m))
    else:
        points = field.centres(search(field))
    # Cells' centres are near the ends, not on them.
    points = np.concatenate([ends[:1], points[1:-1], ends[1:]])
    way = straighten(points, task.obstacles, enough_m=wanted_m + 0.1)
    if cfg.method == "primitives":
        flown = fly_primitives(as_node(start), way, task.obstacles, task.bounds, craft)
        return with_yaw(*flown, start.yaw_rad, craft.limits)
    corridor = build_corridor(
        way,
        task.obstacles,
        field.bounds_enu_m,
        wanted_m=wanted_m,
        least_m=craft.keep_m,
        max_leg_m=cfg.max_piece_m,
    )
    if math.hypot(*start.velocity_enu_mps) > _MOVING_MPS:
        corridor = refine(corridor, np.array([2] + [1] * (len(corridor) - 1)))
    lengths_m = np.linalg.norm(np.diff(corridor.gates_enu_m, axis=0), axis=1)
    corridor = refine(corridor, pieces_to_fill(lengths_m, cfg.min_pieces))
    solution = optimise(
        as_node(start),
        np.array([task.goal_enu_m, ZERO3, ZERO3]),
        corridor,
        task.bounds,
        excess=functools.partial(excess, limits=craft.limits, quadrotor=craft.quadrotor),
    )
    coefficients = coefficients_from_nodes(solution.nodes, solution.durations_s)
    trajectory = with_yaw(coefficients, solution.durations_s, start.yaw_rad, craft.limits)
    return dataclasses.replace(trajectory, corridor=corridor)


def as_node(state: FlatReference) -> np.ndarray:
    """Return position, velocity and acceleration of a reference as rows."""
    return np.array([state.position_enu_m, state.velocity_enu_mps, state.acceleration_enu_mps2])


def with_yaw(
    coefficients: np.ndarray,
    durations_s: np.ndarray,
    start_yaw_rad: float,
    limits: FlightLimits,
    start_rate_radps: float = 0.0,
) -> Trajectory:
    """Return a trajectory whose heading follows its direction of flight.

    Args:
        coefficients: Coefficients of the pieces, as of `Trajectory`.
        durations_s: Durations of the pieces.
        start_yaw_rad: Heading at the start.
        limits: Limits of the yaw's rate and acceleration.
        start_rate_radps: Yaw rate at the start.
    """
    still = YawProfile(step_s=STEP_S, yaw_rad=np.array([start_yaw_rad]))
    trajectory = Trajectory(durations_s=durations_s, coefficients=coefficients, yaw=still)
    times = np.arange(0.0, trajectory.duration_s + STEP_S, STEP_S)
    yaw = yaw_along_path(
        trajectory.positions(times),
        start_yaw_rad,
        start_rate_radps=start_rate_radps,
        max_rate_radps=limits.yaw_rate_radps,
        max_acceleration_radps2=limits.yaw_acceleration_radps2,
    )
    return dataclasses.replace(trajectory, yaw=yaw)
