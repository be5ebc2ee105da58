"""Plans towards a goal through a place that is still being seen.

A search leads to the goal also through what nobody has looked at, at a price. What is flown of it
is the part before it leaves what was seen free, planned and proved against all the rest, and it
ends at rest: the vehicle can always stay where its plan ends. As more is seen, a new plan takes
over. Where the way leads on to cells that the camera does not see from there, because they are
above, below or behind, the vehicle turns, or flies to the nearest place from which it sees them.
What stays unseen though it was looked at is taken for occupied.

Source: a plan that may use the unknown together with one that stops in the known, as in Tordesillas
et al. 2019 (FASTER), here one after the other and each proved exactly.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from jaxtyping import Float, Int

from autonomy.mapping.rays import FREE_AT, HIT, OCCUPIED_AT
from autonomy.mapping.seen_map import Errand, SeenMap, slices
from autonomy.mapping.views import Sight, nearest_viewpoint, visible
from autonomy.model.quadrotor import QuadrotorParams, Vector3
from autonomy.planning.certificate import certify
from autonomy.planning.errors import BlockedError, PlanningError, UnreachableError
from autonomy.planning.limits import FlightLimits
from autonomy.planning.planner import PlannerCfg, as_node, plan_trajectory
from autonomy.planning.search import shortest_path
from autonomy.planning.trajectory import Trajectory, YawProfile, coefficients_from_nodes
from autonomy.planning.yaw import STEP_S
from autonomy.types import ZERO3, FlatReference

WORTHWHILE_M = 0.5
"""Shorter ways are not flown: the vehicle rather looks where the way goes on."""
LOOK_IMAGES = 4
"""After so many images of cells that are still unknown, no more is expected."""
_AROUND_M = 2.0
"""Beyond the way to fly, what the plan may use."""
_SEARCHED_M = 14.0
"""How far away a place to look from may be."""
_FACING_RAD = math.radians(8.0)
_AT_REST_MPS = 0.3
_EDGE_RAD = math.radians(4.0)
"""What lies so near to the edge of the image is not counted on."""
_STAY_S = 0.4
_LONGEST_S = 60.0
_MOST_GIVEN_UP = 12
_CLIMB_PRICE = 2.0
"""Cells, of a rise by one cell through what was not seen."""


@dataclasses.dataclass(frozen=True, slots=True)
class _Task:
    seen: SeenMap
    start: FlatReference
    goal_enu_m: Vector3
    limits: FlightLimits
    quadrotor: QuadrotorParams
    cfg: PlannerCfg

    @property
    def needed_m(self) -> float:
        """Distance to what was not seen free, below which no way is looked for."""
        return self.cfg.vehicle_radius_m + self.cfg.margins_m[-1]

    @property
    def start_cell(self) -> Int[np.ndarray, " 3"]:
        return self.seen.cells(np.array(self.start.position_enu_m))


def plan_towards(
    seen: SeenMap,
    start: FlatReference,
    goal_enu_m: Vector3,
    limits: FlightLimits,
    quadrotor: QuadrotorParams,
    cfg: PlannerCfg,
) -> Trajectory:
    """A certified trajectory within what was seen free: to the goal, or towards it, or a look.

    Args:
        seen: What was seen so far; what stays unseen though looked at is taken for occupied.
        start: Where the vehicle is and how it moves.
        goal_enu_m: Where it shall go.
        limits: Of the motion.
        quadrotor: Mass, thrust and drag of the vehicle.
        cfg: Vehicle's size, margins and method.

    Returns:
        A plan that ends at rest; at the goal, if that is within what was seen free.

    Raises:
        BlockedError: If start or goal is off the map, or the goal too near to what was seen.
        UnreachableError: If no way is left that may lead to the goal.
        PlanningError: If nothing better can be planned while the vehicle moves, or proved.
    """
    cfg = dataclasses.replace(cfg, comfortable_m=seen.cfg.cap_m - cfg.vehicle_radius_m)
    task = _Task(seen, start, goal_enu_m, limits, quadrotor, cfg)
    _require_place(task)
    for _ in range(_MOST_GIVEN_UP):
        look = None if seen.errand is None else _pursue(task, seen.errand)
        if look is not None:
            return look
        path = _way(task)
        n_open = _n_open(task, path)
        if n_open == len(path):
            return _fly(task, path, goal_enu_m)
        reached = seen.centres(path[n_open - 1])
        if math.dist(start.position_enu_m, reached) < WORTHWHILE_M:
            _look(task, path[n_open])
            continue
        try:
            return _fly_some(task, path[:n_open])
        except PlanningError:
            if math.hypot(*start.velocity_enu_mps) > _AT_REST_MPS:
                raise
            seen.give_up(path[n_open - 1 : n_open])
    raise UnreachableError(
        f"goal {_text(goal_enu_m)} stays out of sight: {_MOST_GIVEN_UP} ways on were looked at in "
        "vain; valid: another goal, or plan again from elsewhere"
    )


def _require_place(task: _Task) -> None:
    shape = task.seen.evidence.shape
    for name, point in (("start", task.start.position_enu_m), ("goal", task.goal_enu_m)):
        cell = task.seen.cells(np.array(point))
        if np.any(cell < 0) or np.any(cell >= shape):
            low = task.seen.corner_enu_m
            high = low + np.array(shape) * task.seen.cfg.resolution_m
            raise BlockedError(
                f"{name} {_text(point)} is outside the map; valid: {low.round(1)} to "
                f"{high.round(1)}"
            )
    goal = np.array([task.goal_enu_m])
    room_m = float(task.seen.distance_to_seen_m(goal, HIT)[0])
    least_m = task.cfg.vehicle_radius_m + task.cfg.min_margin_m
    if room_m <= least_m:
        raise BlockedError(
            f"goal {_text(task.goal_enu_m)} is {room_m:.2f} m from what was seen; "
            f"valid: more than {least_m:.2f} m"
        )


def _way(task: _Task) -> Int[np.ndarray, "n 3"]:
    """Cells from start to goal, through what was not seen as well."""
    route = dataclasses.replace(task.seen.field, distance_m=task.seen.route_m(task.needed_m))
    start, goal = task.start_cell, task.seen.cells(np.array(task.goal_enu_m))
    at_ends_m = min(float(route.distance_m[tuple(cell)]) for cell in (start, goal))
    return shortest_path(
        route,
        start,
        goal,
        required_m=min(task.needed_m, max(at_ends_m, route.resolution_m / 4)),
        comfortable_m=task.seen.cfg.cap_m,
        is_seen=task.seen.field.distance_m >= task.needed_m,
        climb_price=_CLIMB_PRICE,
    )


def _n_open(task: _Task, path: np.ndarray) -> int:
    """How many cells of a way, from its beginning, have room that was seen free."""
    distance_m = task.seen.field.distance_m[tuple(path.T)]
    # Where the start itself has less room, the way out of there may have as little.
    needed = np.full(len(path), task.needed_m)
    away = np.linalg.norm(path - path[0], axis=1) * task.seen.cfg.resolution_m
    needed[away < 2 * task.cfg.vehicle_radius_m] = min(float(distance_m[0]), task.needed_m)
    is_closed = distance_m < needed
    return int(np.argmax(is_closed)) if is_closed.any() else len(path)


def _fly_some(task: _Task, path: np.ndarray) -> Trajectory:
    """As far along a way as can be proved."""
    try:
        return _fly(task, path, _point(task, path[-1]))
    except PlanningError:
        half = path[: len(path) // 2 + 1]
        if math.dist(task.start.position_enu_m, _point(task, half[-1])) < WORTHWHILE_M:
            raise
    return _fly(task, half, _point(task, half[-1]))


def _fly(task: _Task, path: np.ndarray, goal_enu_m: Vector3) -> Trajectory:
    """A trajectory about a way through what was seen free."""
    block = task.seen.block_about(path, _AROUND_M)
    return plan_trajectory(
        task.start,
        goal_enu_m,
        task.seen.field_in(block),
        task.seen.obstacles_in(block),
        task.limits,
        task.quadrotor,
        task.cfg,
    )


def _look(task: _Task, at: np.ndarray) -> None:
    """Set out to see what keeps a cell from being flown to, or give that up."""
    seen, start = task.seen, task.start
    if math.hypot(*start.velocity_enu_mps) > _AT_REST_MPS:
        raise PlanningError(
            f"nothing was seen yet of the way on from {_text(start.position_enu_m)}; valid: fly "
            "the plan to its end and plan again"
        )
    unknown = _unknown_about(task, at)
    if len(unknown) == 0:
        seen.give_up(at[None])
        return
    sight = _sight(seen)
    eye = (np.array(start.position_enu_m) - seen.corner_enu_m) / seen.cfg.resolution_m - 0.5
    is_visible = visible(eye, unknown, seen.evidence, sight)
    if is_visible.any():
        seen.errand = Errand(path=task.start_cell[None], targets=unknown[is_visible])
        return
    block = seen.block_about(task.start_cell[None], _SEARCHED_M)
    part = np.ascontiguousarray(seen.evidence[slices(block)])
    back = nearest_viewpoint(
        seen.field_in(block).distance_m,
        task.start_cell - block[0],
        task.needed_m,
        unknown - block[0],
        part,
        sight,
    )
    if len(back) == 0:
        seen.give_up(unknown)
        return
    is_visible = visible(back[0].astype(float), unknown - block[0], part, sight)
    seen.errand = Errand(path=back[::-1] + block[0], targets=unknown[is_visible])


def _pursue(task: _Task, errand: Errand) -> Trajectory | None:
    """Fly to where cells can be seen from, and look at them; None when that is done."""
    seen, start = task.seen, task.start
    evidence = seen.evidence[tuple(errand.targets.T)]
    targets = errand.targets[(evidence > FREE_AT) & (evidence < OCCUPIED_AT)]
    seen.errand = None
    if len(targets) == 0:
        return None
    place = _point(task, errand.path[-1])
    is_moving = math.hypot(*start.velocity_enu_mps) > _AT_REST_MPS
    if len(errand.path) > 1 and math.dist(place, start.position_enu_m) > seen.cfg.resolution_m:
        try:
            plan = _fly(task, np.concatenate([task.start_cell[None], errand.path]), place)
        except PlanningError:
            if is_moving:
                seen.errand = errand
                raise
            seen.give_up(targets)
            return None
        seen.errand = errand
        return plan
    if is_moving:
        seen.errand = errand
        raise PlanningError(
            f"still moving at {_text(start.position_enu_m)}, from where to look around; valid: fly "
            "the plan to its end and plan again"
        )
    way = seen.centres(targets).mean(axis=0) - start.position_enu_m
    turn = math.remainder(math.atan2(way[1], way[0]) - start.yaw_rad, math.tau)
    if abs(turn) > _FACING_RAD:
        seen.errand = dataclasses.replace(errand, facing_since=None)
        return _turn(task, turn)
    since = seen.n_images if errand.facing_since is None else errand.facing_since
    if seen.n_images - since >= LOOK_IMAGES:
        seen.give_up(targets)
        return None
    seen.errand = dataclasses.replace(errand, facing_since=since)
    return _turn(task, 0.0)


def _unknown_about(task: _Task, at: np.ndarray) -> Int[np.ndarray, "n 3"]:
    """Cells that were not seen and are too near to a cell for the vehicle to be there."""
    seen = task.seen
    block = seen.block_about(at[None], task.needed_m)
    part = seen.evidence[slices(block)]
    cells = np.argwhere((part > FREE_AT) & (part < OCCUPIED_AT)) + block[0]
    # As distances are told: from the centre to the surface of the other cell.
    away = np.maximum(np.abs(cells - at) - 0.5, 0.0) * seen.cfg.resolution_m
    return cells[np.linalg.norm(away, axis=1) < task.needed_m]


def _sight(seen: SeenMap) -> Sight:
    cfg = seen.cfg
    half = cfg.camera_vertical_fov_rad / 2 - _EDGE_RAD
    most = (cfg.max_range_m - 1.0) / cfg.resolution_m
    return (
        math.tan(-cfg.camera_pitch_down_rad - half),
        math.tan(-cfg.camera_pitch_down_rad + half),
        1.5,
        most,
    )


def _turn(task: _Task, turn_rad: float) -> Trajectory:
    """Come to rest on the spot while turning."""
    limits, start = task.limits, task.start
    duration_s = max(
        _STAY_S,
        math.sqrt(10 / math.sqrt(3) * abs(turn_rad) / limits.yaw_acceleration_radps2),
    )
    yaw = _eased(start, turn_rad, duration_s)
    while np.abs(np.diff(yaw)).max() > limits.yaw_rate_radps * STEP_S and duration_s < _LONGEST_S:
        duration_s *= 1.2
        yaw = _eased(start, turn_rad, duration_s)
    rest = np.array([start.position_enu_m, ZERO3, ZERO3])
    durations_s = np.array([STEP_S * (len(yaw) - 1)])
    trajectory = Trajectory(
        durations_s=durations_s,
        coefficients=coefficients_from_nodes(np.array([as_node(start), rest]), durations_s),
        yaw=YawProfile(step_s=STEP_S, yaw_rad=yaw),
    )
    block = task.seen.block_about(task.start_cell[None], _AROUND_M)
    proof = certify(
        trajectory,
        task.seen.obstacles_in(block),
        task.cfg.vehicle_radius_m,
        limits,
        task.quadrotor,
    )
    return dataclasses.replace(trajectory, min_clearance_m=proof.min_clearance_m)


def _eased(start: FlatReference, turn_rad: float, duration_s: float) -> Float[np.ndarray, " n"]:
    """Headings of degree 5 that begin as the vehicle turns already and end at rest."""
    s = np.linspace(0.0, 1.0, math.ceil(duration_s / STEP_S) + 1)
    run_out = start.yaw_rate_radps * duration_s * (s - 6 * s**3 + 8 * s**4 - 3 * s**5)
    return start.yaw_rad + run_out + turn_rad * s**3 * (10 - 15 * s + 6 * s**2)


def _point(task: _Task, cell: np.ndarray) -> Vector3:
    x, y, z = task.seen.centres(cell).tolist()
    return (x, y, z)


def _text(point: Vector3 | Float[np.ndarray, " 3"]) -> str:
    return f"({point[0]:.2f}, {point[1]:.2f}, {point[2]:.2f}) m"
