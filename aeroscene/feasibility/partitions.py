"""Partitions that run beside each other: in the corpus one wall separates two rooms, never two.

Parting two such walls along their thin side moves them by decimetres and leaves a double wall.
Instead the shorter one ends where the longer one begins, in line with it if they are near. If
nothing of it would be left, it is dropped, and the longer one serves for both.
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

from aeroscene.feasibility.layout import Layout
from aeroscene.feasibility.roles import least_m
from aeroscene.scene.catalogue import BUILDINGS, WALLS

_APART_M = 1.1
"""Distance of middle lines from which walls leave room between them."""
_IN_LINE_M = 0.5
"""Distance from the line of another wall up to which a wall continues it."""
_SHARED_M = 0.3
"""Common length from which walls count as running beside each other."""
_LEAST_HEIGHT_M = 0.5
"""Common height from which walls are on one storey."""
_PARALLEL = 0.05
"""Sine of the angle up to which walls are parallel."""
_GAP_M = 0.0005


def merge_walls(layout: Layout) -> None:
    """Keep the longest of all walls of a building that run beside each other."""
    half = layout.boxes.half_m
    walls = [
        row for row in range(len(half)) if layout.is_present[row] and _is_partition(layout, row)
    ]
    # The longest first, so that each wall meets those that give way to no other.
    walls.sort(key=lambda row: -float(half[row, 1]))
    for place, longer in enumerate(walls):
        for other in walls[place + 1 :]:
            if layout.is_present[longer] and layout.is_present[other]:
                away = _from(layout, longer, other)
                if _is_doubled(layout, longer, other, away):
                    _give_way(layout, longer, other, away)


def _is_partition(layout: Layout, row: int) -> bool:
    parent = layout.parent_of(row)
    is_part = parent is not None and parent.category in BUILDINGS
    return is_part and layout.objects[row].category in WALLS


def _from(layout: Layout, longer: int, other: int) -> Float[np.ndarray, " 2"]:
    """Position of one wall's middle from another's: across that wall and along it."""
    boxes = layout.boxes
    return boxes.frame(longer) @ (boxes.centre_m[other, :2] - boxes.centre_m[longer, :2])


def _is_doubled(layout: Layout, longer: int, other: int, away: Float[np.ndarray, " 2"]) -> bool:
    boxes = layout.boxes
    pair = [longer, other]
    across, along = np.abs(away)
    return bool(
        boxes.parent[longer] == boxes.parent[other]
        and abs(np.sin(boxes.yaw_rad[longer] - boxes.yaw_rad[other])) < _PARALLEL
        and boxes.top_m[pair].min() - boxes.base_m[pair].max() > _LEAST_HEIGHT_M
        and across < _APART_M
        and boxes.half_m[pair, 1].sum() - along > _SHARED_M
    )


def _give_way(layout: Layout, longer: int, other: int, away: Float[np.ndarray, " 2"]) -> None:
    """Cut one wall to the part beyond another, or drop it if that is too short."""
    boxes, (across, along) = layout.boxes, away
    end_m = float(boxes.half_m[longer, 1]) + _GAP_M
    left_m = abs(along) + float(boxes.half_m[other, 1]) - end_m
    if left_m < least_m(layout.objects[other])[1]:
        layout.drop(other)
        return
    # In line with the longer wall, or on its own line if that is too far away.
    wanted = np.array(
        [0.0 if abs(across) < _IN_LINE_M else across, np.copysign(end_m + left_m / 2, along)]
    )
    layout.shift(other, np.array([*(boxes.frame(longer).T @ (wanted - away)), 0.0]))
    boxes.half_m[other, 1] = left_m / 2
