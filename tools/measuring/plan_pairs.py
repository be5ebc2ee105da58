"""Random starts and goals in the free space of scenes."""

from __future__ import annotations

import math

import numpy as np

from aeroscene.solids.freespace import VoxelField, reachable
from autonomy.types import Vector3, vector3
from scenarios.mission.surroundings import Surroundings

SHIPPED_SCENES = 1016
FAR_ENOUGH_M = 10.0
_TRIES = 60
_CLOSE_M = 1.5


def scene_numbers(count: int) -> list[int]:
    """Numbers of shipped scenes, evenly spread, the first and the last among them."""
    return np.linspace(0, SHIPPED_SCENES - 1, count).round().astype(int).tolist()


def draw_pairs(
    world: Surroundings, count: int, rng: np.random.Generator
) -> list[tuple[Vector3, Vector3]]:
    """Draw starts and goals connected by free space, 10 m apart where the scene allows.

    Every second end lies within 1.5 m of an obstacle.

    Args:
        world: Surroundings of the vehicle.
        count: Number of pairs.
        rng: Source of the draws.

    Returns:
        Pairs of start and goal, fewer than asked for if the scene has hardly any room.
    """
    needed_m = world.radius_m + world.planner.min_margin_m
    field = world.field
    voxels = VoxelField(
        origin_enu_m=field.origin_enu_m,
        resolution_m=field.resolution_m,
        distance_m=field.distance_m,
    )
    # Reachable from the scene's start: all such cells are connected with each other.
    is_free = reachable(voxels, world.scene.start_position_enu_m, needed_m)
    cells = np.argwhere(is_free)
    is_close = field.distance_m[is_free] < _CLOSE_M
    pairs = []
    for _ in range(count):
        # The best of the tries, unless one is far enough.
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
    """Random point of a free cell; None if the obstacles themselves leave too little room."""
    among = cells[is_close] if rng.random() < 0.5 and is_close.any() else cells
    point = world.field.centres(among[rng.integers(len(among))])
    # Within the cell, and off its centre, where the planner's own search has its nodes.
    point = point + rng.uniform(-0.4, 0.4, 3) * world.field.resolution_m
    if world.clearance_m(point[None])[0] <= world.planner.min_margin_m:
        return None
    return vector3(point)
