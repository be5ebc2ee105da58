"""Rooms of a scene, without satellite signals and wind, as rows for a kernel."""

from __future__ import annotations

import math

import numpy as np
from jaxtyping import Float

from aeroscene.scene import Scene
from aeroscene.scene.catalogue import ROOMS
from autonomy.jit import kernel

# Middle, turn and half extents of a room, m.
ROOM_COLUMNS = ("x", "y", "z", "cos yaw", "sin yaw", "half length", "half width", "half height")
DRAUGHT_M = 1.0
"""Distance from the walls at which the wind reaches its full strength."""
_WALL_M = 0.4
"""Amount by which rooms are enlarged, so that walls, door frames and ceilings belong to them."""


def indoor_rooms(scene: Scene) -> Float[np.ndarray, "n 8"]:
    """Return the rooms of a scene with their walls, a row of `ROOM_COLUMNS` each."""
    rows = [
        (
            *room.bbox.p,
            math.cos(room.bbox.yaw_rad),
            math.sin(room.bbox.yaw_rad),
            *(0.5 * side + _WALL_M for side in room.bbox.s),
        )
        for room in scene.objects
        if room.category in ROOMS
    ]
    return np.array(rows, dtype=float).reshape(-1, len(ROOM_COLUMNS))


@kernel
def is_in_room(rooms: np.ndarray, position_enu_m: np.ndarray) -> bool:
    """Return true if a position (3,) lies in one of the rooms (n, 8)."""
    return exposure(rooms, position_enu_m) == 0.0


@kernel
def exposure(rooms: np.ndarray, position_enu_m: np.ndarray) -> float:
    """Return the share of the wind at a position: 0 in a room, 1 at `DRAUGHT_M` and beyond.

    Args:
        rooms: Rooms (n, 8).
        position_enu_m: The position (3,).
    """
    nearest = DRAUGHT_M
    for k in range(rooms.shape[0]):
        room = rooms[k]
        dx, dy = position_enu_m[0] - room[0], position_enu_m[1] - room[1]
        # Distances to the walls in the room's own axes; negative inside.
        along = abs(room[3] * dx + room[4] * dy) - room[5]
        across = abs(room[3] * dy - room[4] * dx) - room[6]
        above = abs(position_enu_m[2] - room[2]) - room[7]
        nearest = min(nearest, max(along, across, above, 0.0))
    return nearest / DRAUGHT_M
