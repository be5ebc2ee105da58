"""Walls: do they meet, do they close rooms, does furniture stand with its back to them?

An outer wall lies within the rim of a building's box; every other wall is a box of its own. A wall
counts for what it shares height with.
"""

from __future__ import annotations

import numpy as np
import shapely
from jaxtyping import Bool, Float

from aeroscene.metrics.places.top_view import SHELLS, TopView, near_pairs
from aeroscene.solids.shapes.facade import WALL_M

TO_WALL_M = 0.2
"""Farthest that a wall's outline is from what touches it."""
TO_RIM_M = 0.6
"""Farthest that the rim of a building's box is from what touches the outer wall within it."""
OFF_WALL_M = 0.3
"""Farthest that furniture stands off the face of the wall in its back."""
WALLED_USES = frozenset(
    {"office", "meeting", "kitchen", "store", "bedroom", "living", "dining"}
    | {"classroom", "workshop", "changing"}
)
"""Uses of rooms that have walls all around; halls and galleries flow into each other."""
BACKED = ("cabinet", "wardrobe", "shelf", "counter", "fridge", "stove")
"""Storage and kitchen furniture, which has a wall in its back."""


def loose_wall_ends(view: TopView) -> Bool[np.ndarray, " ends"]:
    """Whether each end of each wall touches neither another wall nor an outer wall.

    An end is the whole upright face at either end of the longer side of the wall's box. It touches
    where it lies at most `TO_WALL_M` from another wall's outline or at most `TO_RIM_M` from the rim
    of a building, inside or out. Parapets on raised land are not judged: they end at stairs.
    """
    walls, shells = view.rows("wall"), view.rows(*SHELLS)
    judged = walls[~view.is_on("terrain")[walls]]
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
    """Share of the outline of each room with a name that walls close.

    A stretch is closed where it lies at most `TO_WALL_M` from the outline of a wall or at most
    `TO_RIM_M` from the rim of a building, of those that share at least half of the room's height.
    Doors and windows are parts of their walls. Judged are rooms whose use is one of `WALLED_USES`,
    and rooms that are in no building: their walls are all boxes, as in layouts from elsewhere.
    """
    walls, shells = view.rows("wall"), view.rows(*SHELLS)
    is_in_shell = view.is_in(*SHELLS)
    rooms = [r for r in view.rows("room") if view.use[r] in WALLED_USES or not is_in_shell[r]]
    rooms = np.array(rooms, dtype=int)
    barriers = np.concatenate(
        [
            shapely.buffer(view.outline[walls], TO_WALL_M, join_style="mitre"),
            shapely.buffer(shapely.boundary(view.outline[shells]), TO_RIM_M, join_style="mitre"),
        ]
    )
    barrier_rows = np.concatenate([walls, shells])
    rings = shapely.boundary(view.outline[rooms])
    room, barrier = shapely.STRtree(barriers).query(rings, predicate="intersects")
    least_m = (view.top_m - view.base_m)[rooms[room]] / 2
    counts = view.shared_height_m(rooms[room], barrier_rows[barrier]) >= least_m
    shares = np.zeros(len(rooms))
    for index, ring in enumerate(rings):
        closing = shapely.union_all(barriers[barrier[counts & (room == index)]])
        shares[index] = shapely.intersection(ring, closing).length / ring.length
    return shares


def backs_off_walls(view: TopView) -> Bool[np.ndarray, " furniture"]:
    """Whether each piece of storage or kitchen furniture has its back off every wall.

    The back is the middle of the face towards -x of the box. It is off where it lies over
    `OFF_WALL_M` from the outlines of walls and from the inner faces of outer walls, `WALL_M` within
    the rims of buildings.
    """
    rows, walls, shells = view.rows(*BACKED), view.rows("wall"), view.rows(*SHELLS)
    backs = shapely.points(view.face(rows, 0, -1).mean(axis=1))
    rims = shapely.boundary(view.outline[shells])
    is_off = np.ones(len(rows), dtype=bool)
    for others, outlines, apart_m in (
        (walls, view.outline[walls], OFF_WALL_M),
        (shells, rims, OFF_WALL_M + WALL_M),
    ):
        index, other = near_pairs(backs, outlines, apart_m)
        is_off[index[view.shared_height_m(rows[index], others[other]) > 0]] = False
    return is_off
