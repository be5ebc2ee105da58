"""Furniture along the walls: storage and kitchen furniture should have its back to one."""

from __future__ import annotations

import numpy as np
import shapely
from jaxtyping import Bool

from aeroscene.metrics.places.top_view import TopView, near_pairs
from aeroscene.scene.catalogue import BACKED, SHELLS, WALLS
from aeroscene.solids.shapes.facade import WALL_M

OFF_WALL_M = 0.3
"""Greatest distance of furniture from the face of the wall at its back."""


def backs_off_walls(view: TopView) -> Bool[np.ndarray, " furniture"]:
    """True for each piece of storage or kitchen furniture whose back is off every wall.

    The back is the middle of the face towards -x of the box. It is off if it is over `OFF_WALL_M`
    from the outlines of walls and from the inner faces of outer walls, which lie `WALL_M` within
    the rims of buildings.
    """
    rows, walls, shells = view.rows(BACKED), view.rows(WALLS), view.rows(SHELLS)
    backs = shapely.points(view.face(rows, 0, -1).mean(axis=1))
    rims = shapely.boundary(view.outline[shells])
    is_off = np.ones(len(rows), dtype=bool)
    for others, outlines, apart_m in (
        (walls, view.outline[walls], OFF_WALL_M),
        (shells, rims, OFF_WALL_M + WALL_M),
    ):
        index, other = near_pairs(backs, outlines, apart_m)
        # Walls of other storeys do not count.
        is_off[index[view.shared_height_m(rows[index], others[other]) > 0]] = False
    return is_off
