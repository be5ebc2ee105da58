"""Walls behind units at the edge of a room, because some edges of open rooms have none."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from jaxtyping import Bool, Float

from aeroscene.feasibility.place_search import Blocks
from aeroscene.learning.program.decoding.draft import Draft
from aeroscene.relations import Kind, Unit
from aeroscene.relations.plane import QUARTER, footprint, turned_reach_m
from aeroscene.scene import OrientedBox
from aeroscene.scene.catalogue import ROOMS, SEATS, SHELLS, WALLS
from aeroscene.solids.shapes.facade import WALL_M

_BACK = 2
"""Quarter turns from the outward direction of a room to the heading of a unit with its back
there."""
# Greatest distance of a back from its wall.
_OFF_WALL_M = 0.3
_SAME_ROW_M = 0.1
"""The foremost members of a group within this distance stand in one row."""


def asks_for_wall(draft: Draft, unit: Unit, category: str) -> bool:
    """True if a unit has its back to an edge of a room and its category needs a wall there."""
    relation = unit.relation
    has_back = relation.kind == Kind.EDGE and relation.quadrant == _BACK
    is_in_room = draft.standing.category(unit.host_id) in ROOMS
    # Seats do not need one: a third of the corpus' chairs at edges of open rooms have no wall.
    return has_back and is_in_room and category not in SEATS


def has_wall(draft: Draft, unit: Unit, boxes: Sequence[OrientedBox]) -> bool:
    """True if each of the foremost members of a group at an edge of a room has a wall there.

    Args:
        draft: Objects so far.
        unit: The group, with the side of the room that it is at.
        boxes: Boxes of the group at the tried place.
    """
    walls, shells = (draft.neighbours.of(names) for names in (WALLS, SHELLS))
    room, side = draft.outline(unit.host_id), unit.relation.side
    outwards_rad = room.place.yaw_rad + side * QUARTER
    c, s = math.cos(outwards_rad), math.sin(outwards_rad)
    ends = []
    for box in boxes:
        at = footprint(box)
        reach_m, _ = turned_reach_m(at.half_m, at.place.yaw_rad - outwards_rad)
        low_m = box.p[2] - box.s[2] / 2
        # The outermost point of each box, towards the edge, with the heights of the box.
        end = box.p[0] + c * reach_m, box.p[1] + s * reach_m
        ends.append((*end, low_m, low_m + box.s[2]))
    found = np.array(ends)
    along_m = found[:, :2] @ (c, s)
    front = found[along_m > along_m.max() - _SAME_ROW_M]
    is_at_wall = (_outside_m(front, walls) <= _OFF_WALL_M) & _shares_height(front, walls)
    # The shell of a building counts as a wall from either side of its outline.
    is_at_rim = (np.abs(_outside_m(front, shells)) <= _OFF_WALL_M + WALL_M) & _shares_height(
        front, shells
    )
    return bool(np.all(is_at_wall.any(axis=1) | is_at_rim.any(axis=1)))


def _outside_m(points: Float[np.ndarray, "n 4"], rows: Blocks) -> Float[np.ndarray, "n k"]:
    """Distances of points from the outlines of boxes, negative inside."""
    offset = points[:, None, :2] - np.column_stack([rows["x_m"], rows["y_m"]])[None]
    c, s = rows["cos"], rows["sin"]
    u_m = np.abs(c * offset[..., 0] + s * offset[..., 1]) - rows["half_x_m"]
    v_m = np.abs(c * offset[..., 1] - s * offset[..., 0]) - rows["half_y_m"]
    return np.hypot(np.maximum(u_m, 0.0), np.maximum(v_m, 0.0)) + np.minimum(
        np.maximum(u_m, v_m), 0.0
    )


def _shares_height(points: Float[np.ndarray, "n 4"], rows: Blocks) -> Bool[np.ndarray, "n k"]:
    top_m = np.minimum(points[:, None, 3], rows["top_m"])
    return top_m > np.maximum(points[:, None, 2], rows["base_m"])
