"""Starts and goals in the free space of scenes, and obstacles that cross a plan, by seed."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass

import numpy as np

from aeroscene.freespace import VoxelField, reachable
from autonomy.model.quadrotor import Vector3
from autonomy.planning import MovingObstacles, PlanningError, Trajectory
from scenarios.surroundings import Surroundings

SHIPPED_SCENES = 1016
FAR_ENOUGH_M = 10.0
_TRIES = 60
_CLOSE_M = 1.5
_PERSON_RADIUS_M = 0.35
_PERSON_HALF_HEIGHT_M = 0.6
_MOST_SPEED_MPS = 3.0
_REPLAN_EVERY_S = 0.5
_GROWTH_MPS = 0.1


def scene_numbers(count: int) -> list[int]:
    """Shipped scenes, evenly spread, the first and the last among them."""
    return np.linspace(0, SHIPPED_SCENES - 1, count).round().astype(int).tolist()


def draw_pairs(
    world: Surroundings, count: int, rng: np.random.Generator
) -> list[tuple[Vector3, Vector3]]:
    """Starts and goals that cells of free space join, 10 m apart where the scene allows.

    One end in two lies within 1.5 m of something.
    """
    needed_m = world.radius_m + world.planner.min_margin_m
    field = world.field
    voxels = VoxelField(
        origin_enu_m=field.origin_enu_m,
        resolution_m=field.resolution_m,
        distance_m=field.distance_m,
    )
    is_free = reachable(voxels, world.scene.start_position_enu_m, needed_m)
    cells = np.argwhere(is_free)
    is_close = field.distance_m[is_free] < _CLOSE_M
    pairs = []
    for _ in range(count):
        best: tuple[float, Vector3, Vector3] | None = None
        for _ in range(_TRIES):
            a, b = _point(world, cells, is_close, rng), _point(world, cells, is_close, rng)
            if a is None or b is None:
                continue
            if best is None or math.dist(a, b) > best[0]:
                best = (math.dist(a, b), a, b)
            if best[0] >= FAR_ENOUGH_M:
                break
        if best is not None:
            pairs.append((best[1], best[2]))
    return pairs


def _point(
    world: Surroundings, cells: np.ndarray, is_close: np.ndarray, rng: np.random.Generator
) -> Vector3 | None:
    """A point of a free cell; None where the obstacles themselves leave too little room."""
    among = cells[is_close] if rng.random() < 0.5 and is_close.any() else cells
    point = world.field.centres(among[rng.integers(len(among))])
    point = point + rng.uniform(-0.4, 0.4, 3) * world.field.resolution_m
    if world.clearance_m(point[None])[0] <= world.planner.min_margin_m:
        return None
    x, y, z = point.tolist()
    return (x, y, z)


@dataclass(frozen=True, kw_only=True, slots=True)
class Crossing:
    """How a flight past somebody who walks across the plan went."""

    is_avoided: bool
    n_refused: int
    """Replans without a result."""
    replans_ms: tuple[float, ...]


def fly_past_a_crossing(
    world: Surroundings, plan: Trajectory, rng: np.random.Generator
) -> Crossing | None:
    """Follow a plan exactly, replanning twice a second, while somebody crosses it.

    Somebody is an upright capsule that moves at .5 to 3 m/s on a straight line through a point of
    the plan and is there when the vehicle would be, 2 to 4 s after the beginning. What cannot be
    replanned is flown as planned before. None where the plan is too short for that, or somebody
    would begin in the vehicle.
    """
    at_s = rng.uniform(2.0, 4.0)
    speed, heading = rng.uniform(0.5, _MOST_SPEED_MPS), rng.uniform(-math.pi, math.pi)
    if plan.duration_s < at_s + 0.5:
        return None
    velocity = speed * np.array([math.cos(heading), math.sin(heading), 0.0])
    meet = plan.positions(np.array([at_s]))[0]
    somebody = _capsule(meet - velocity * at_s, velocity, growth_mps=0.0)
    begin = plan.positions(np.zeros(1))
    if somebody.distances(begin, np.zeros(1))[0][0, 0] < world.radius_m + 0.6:
        return None
    since_s, now_s, n_refused, spent = 0.0, 0.0, 0, []
    is_avoided = True
    while now_s < at_s + 2.0 and now_s - since_s < plan.duration_s:
        seen = _capsule(somebody.position_enu_m[0] + velocity * now_s, velocity)
        begun = time.process_time()
        try:
            plan, since_s = world.replan(plan, now_s - since_s, moving=seen), now_s
        except PlanningError:
            n_refused += 1
        spent.append(1e3 * (time.process_time() - begun))
        t = np.arange(0.0, _REPLAN_EVERY_S, 0.02) + now_s
        gap = somebody.distances(plan.positions(t - since_s), t)[0][0]
        is_avoided &= bool(np.all(gap > world.radius_m))
        now_s += _REPLAN_EVERY_S
    return Crossing(is_avoided=is_avoided, n_refused=n_refused, replans_ms=tuple(spent))


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
