"""Stairs, which should lead to a level."""

from __future__ import annotations

import numpy as np
import shapely
from jaxtyping import Bool, Float

from aeroscene.feasibility.stairs import REACH_M, STEP_M
from aeroscene.metrics.places.top_view import TopView, near_pairs
from aeroscene.scene.catalogue import BRIDGES, COVERS, LEVELS, ROOMS, SHELLS, STAIRS, WATER
from aeroscene.solids.shapes.structures import RAIL_M

_BORNE_BY_TOP = (COVERS | SHELLS | LEVELS) - WATER - BRIDGES
"""Categories on whose tops people walk."""


def dead_end_stairs(view: TopView) -> Bool[np.ndarray, " stairs"]:
    """True for each flight of stairs whose top meets no level.

    The top is the upper edge of the face towards +x of the box. It meets a level if the level's
    outline is at most `REACH_M` away and its height differs by at most `STEP_M`. Levels are the
    upper sides of covers, terrain, floors, decks, roofs, containers and buildings, the undersides
    of rooms, and the decks of bridges, `RAIL_M` below their upper sides.
    """
    stairs = view.rows(STAIRS)
    levels, height_m = _levels(view)
    tops = shapely.linestrings(view.face(stairs, 0, 1))
    flight, level = near_pairs(tops, view.outline[levels], REACH_M)
    step_m = np.abs(view.top_m[stairs[flight]] - height_m[level])
    is_dead_end = np.ones(len(stairs), dtype=bool)
    is_dead_end[flight[step_m <= STEP_M]] = False
    return is_dead_end


def _levels(view: TopView) -> tuple[np.ndarray, Float[np.ndarray, " k"]]:
    """Return rows and heights of the levels that stairs may lead to."""
    tops, rooms, bridges = view.rows(_BORNE_BY_TOP), view.rows(ROOMS), view.rows(BRIDGES)
    heights_m = (view.top_m[tops], view.base_m[rooms], view.top_m[bridges] - RAIL_M)
    return np.concatenate([tops, rooms, bridges]), np.concatenate(heights_m)
