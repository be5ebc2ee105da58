"""Walls, which should meet each other and close rooms.

An outer wall lies within the rim of a building's box; every other wall is a box of its own. A wall
counts for objects with which it shares height.
"""

from __future__ import annotations

import numpy as np
import shapely
from jaxtyping import Bool, Float, Int

from aeroscene.metrics.places.top_view import TopView, near_pairs
from aeroscene.scene.catalogue import ROOMS, SHELLS, TERRAIN, WALLS

TO_WALL_M = 0.2
"""Greatest distance of a wall's outline from the end that touches it."""
TO_RIM_M = 0.6
"""Greatest distance of the rim of a building's box from the end that touches its outer wall."""
_JOINT_M = 0.005
"""Half of the widest gap between boxes of one room."""
WALLED_USES = frozenset(
    {"office", "meeting", "kitchen", "store", "bedroom", "living", "dining"}
    | {"classroom", "workshop", "changing"}
)
"""Uses of rooms that have walls all around; halls and galleries flow into each other."""


def loose_wall_ends(view: TopView) -> Bool[np.ndarray, " ends"]:
    """True for each end of each wall that touches neither another wall nor an outer wall.

    An end is the whole upright face at either end of the longer side of the wall's box. It touches
    if it lies at most `TO_WALL_M` from another wall's outline, or at most `TO_RIM_M` from the rim
    of a building, inside or outside. Parapets on raised land are not judged, because they end at
    stairs.
    """
    walls, shells = view.rows(WALLS), view.rows(SHELLS)
    judged = walls[~view.is_on(TERRAIN)[walls]]
    size_m = view.arrays.size_m[judged]
    is_long = (size_m[:, 1] >= size_m[:, 0])[:, None, None]
    faces = [
        np.where(is_long, view.face(judged, 1, sign), view.face(judged, 0, sign))
        for sign in (1, -1)
    ]
    ends, owner = shapely.linestrings(np.concatenate(faces)), np.concatenate([judged, judged])
    is_loose = np.ones(len(owner), dtype=bool)
    end, other = near_pairs(ends, view.outline[walls], TO_WALL_M)
    touches = (owner[end] != walls[other]) & (view.shared_height_m(owner[end], walls[other]) > 0)
    is_loose[end[touches]] = False
    end, shell = near_pairs(ends, shapely.boundary(view.outline[shells]), TO_RIM_M)
    is_loose[end[view.shared_height_m(owner[end], shells[shell]) > 0]] = False
    return is_loose


def closed_shares(view: TopView) -> Float[np.ndarray, " rooms"]:
    """Share of the outline of each named room that walls close.

    A stretch is closed if it lies at most `TO_WALL_M` from the outline of a wall or at most
    `TO_RIM_M` from the rim of a building, and that one shares at least half of the room's height.
    Doors and windows are parts of their walls. Rooms are judged whose use is one of `WALLED_USES`.
    Rooms in no building, as in layouts from elsewhere, are judged whatever their use. Those that
    touch count as one, because there several boxes make a room.
    """
    walls, shells = view.rows(WALLS), view.rows(SHELLS)
    barriers = np.concatenate(
        [
            shapely.buffer(view.outline[walls], TO_WALL_M, join_style="mitre"),
            shapely.buffer(shapely.boundary(view.outline[shells]), TO_RIM_M, join_style="mitre"),
        ]
    )
    barrier_rows, (rooms, outlines) = np.concatenate([walls, shells]), _judged_rooms(view)
    rings = np.asarray(shapely.boundary(outlines))
    room, barrier = shapely.STRtree(barriers).query(rings, predicate="intersects")
    least_m = (view.top_m - view.base_m)[rooms[room]] / 2
    counts = view.shared_height_m(rooms[room], barrier_rows[barrier]) >= least_m
    shares = np.zeros(len(rooms))
    for index, ring in enumerate(rings):
        # Barriers are joined first: where two of them overlap, the outline counts once.
        closing = shapely.union_all(barriers[barrier[counts & (room == index)]])
        shares[index] = shapely.intersection(ring, closing).length / ring.length
    return shares


def _judged_rooms(view: TopView) -> tuple[Int[np.ndarray, " k"], np.ndarray]:
    """Return a row and the outline of each room whose walls are judged."""
    rooms, is_in_shell = view.rows(ROOMS), view.is_in(SHELLS)
    named = [row for row in rooms[is_in_shell[rooms]] if view.use[row] in WALLED_USES]
    free = rooms[~is_in_shell[rooms]]
    # Widened a little, so that boxes of one room join.
    tiles = shapely.buffer(view.outline[free], _JOINT_M, join_style="mitre")
    joined = shapely.get_parts(shapely.union_all(tiles))
    tile, whole = near_pairs(shapely.points(view.centre_m[free]), joined, 0.0)
    first = np.unique(whole, return_index=True)[1]
    rows = np.array([*named, *free[tile[first]]], dtype=int)
    return rows, np.array([*view.outline[rows[: len(named)]], *joined[whole[first]]], dtype=object)
