"""Rooms that are no rectangles: several objects of category room, the tiles of one room."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from jaxtyping import Int

from aeroscene.scene.scene import SceneObject

NO_ROOM = -1


def tile_groups(objects: Sequence[SceneObject]) -> Int[np.ndarray, " n"]:
    """For each object the group of tiles that it is one of, `NO_ROOM` where it is no tile.

    Tiles of one room have the same attribute `room` and the same parent.
    """
    numbers: dict[tuple[object, int | None], int] = {}
    groups = np.full(len(objects), NO_ROOM)
    for row, obj in enumerate(objects):
        if obj.category == "room" and "room" in obj.attributes:
            key = obj.attributes["room"], obj.parent_id
            groups[row] = numbers.setdefault(key, len(numbers))
    return groups
