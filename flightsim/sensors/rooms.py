"""Where satellites are not heard: the rooms of a scene, as rows that a kernel can look through."""

from __future__ import annotations

import math

import numpy as np
from jaxtyping import Float

from aeroscene.scene import Scene
from autonomy.jit import kernel

ROOM_COLUMNS = ("x", "y", "z", "cos yaw", "sin yaw", "half length", "half width", "half height")
_WALL_M = 0.4
"""Rooms reach this far into what is around them: walls, door frames and ceilings belong to them."""


def indoor_rooms(scene: Scene) -> Float[np.ndarray, "n 8"]:
    """The rooms of a scene and the walls about them, a row of `ROOM_COLUMNS` for each."""
    rows = [
        (
            *room.bbox.p,
            math.cos(room.bbox.yaw_rad),
            math.sin(room.bbox.yaw_rad),
            *(0.5 * side + _WALL_M for side in room.bbox.s),
        )
        for room in scene.objects
        if room.category == "room"
    ]
    return np.array(rows, dtype=float).reshape(-1, len(ROOM_COLUMNS))


@kernel
def is_in_room(rooms: np.ndarray, position_enu_m: np.ndarray) -> bool:
    """Whether a position (3,) lies in one of the rooms (n, 8)."""
    for k in range(rooms.shape[0]):
        room = rooms[k]
        dx, dy = position_enu_m[0] - room[0], position_enu_m[1] - room[1]
        along, across = room[3] * dx + room[4] * dy, room[3] * dy - room[4] * dx
        is_beside = abs(along) > room[5] or abs(across) > room[6]
        if not is_beside and abs(position_enu_m[2] - room[2]) <= room[7]:
            return True
    return False
