"""Rooms that are not rectangles: several objects of category room are the tiles of one room.

A box cannot describe an L-shaped room. Its tiles share a name in the attribute `room`, and modules
that ask for walls, floors or contents treat them as one.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from jaxtyping import Int

from aeroscene.scene.box import OrientedBox
from aeroscene.scene.catalogue import ROOMS
from aeroscene.scene.scene import AttributeValue, SceneObject

NO_ROOM = -1


def room_of(obj: SceneObject) -> tuple[AttributeValue, int | None] | None:
    """Name and parent of the room that an object is a tile of; None if it is no tile.

    Tiles of one room have the same attribute `room` and the same parent.
    """
    name = obj.attributes.get("room") if obj.category in ROOMS else None
    return None if name is None else (name, obj.parent_id)


def tile_groups(objects: Sequence[SceneObject]) -> Int[np.ndarray, " n"]:
    """Group of tiles for each object, numbered from 0; `NO_ROOM` for an object that is no tile."""
    numbers: dict[tuple[AttributeValue, int | None], int] = {}
    groups = np.full(len(objects), NO_ROOM)
    for row, obj in enumerate(objects):
        if (room := room_of(obj)) is not None:
            groups[row] = numbers.setdefault(room, len(numbers))
    return groups


def strayed_to(
    groups: Int[np.ndarray, " n"], parent: Sequence[int | None], boxes: Sequence[OrientedBox]
) -> dict[int, int]:
    """Find objects that stand in another tile of their room than the one that is their parent.

    Args:
        groups: Group of tiles that each object belongs to, see `tile_groups`.
        parent: Row of each object's parent; None without one.
        boxes: Boxes of the objects.

    Returns:
        Row of the tile around the object's middle, under the row of each such object.
    """
    found: dict[int, int] = {}
    for row, above in enumerate(parent):
        if above is None or groups[above] == NO_ROOM or _holds(boxes[above], boxes[row]):
            continue
        tiles = np.flatnonzero(groups == groups[above]).tolist()
        tile = next((tile for tile in tiles if _holds(boxes[tile], boxes[row])), None)
        if tile is not None:
            found[row] = tile
    return found


def _holds(tile: OrientedBox, box: OrientedBox) -> bool:
    """Return true if the middle of a box is in a tile, seen from above."""
    u_m, v_m = box.p[0] - tile.p[0], box.p[1] - tile.p[1]
    c, s = math.cos(tile.yaw_rad), math.sin(tile.yaw_rad)
    return abs(c * u_m + s * v_m) <= tile.s[0] / 2 and abs(c * v_m - s * u_m) <= tile.s[1] / 2
