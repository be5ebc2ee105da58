"""Heights of objects: undersides are set onto the surfaces that carry them.

Sampled heights are slightly off, so that objects float or sink. The surface follows from
the shape of the bearer: the floor of a room, the slope of a roof, a shelf's board nearest to the
sampled height.
"""

from __future__ import annotations

from functools import lru_cache
from math import inf

import numpy as np
from jaxtyping import Float, Int

from aeroscene.feasibility.boxes import footprint_depth
from aeroscene.feasibility.ground import covered
from aeroscene.feasibility.layout import Layout
from aeroscene.feasibility.roles import is_chained, is_fitting
from aeroscene.landform import standing_points
from aeroscene.scene import SceneObject
from aeroscene.scene.catalogue import (
    BOARDED,
    BRIDGES,
    BUILDINGS,
    CANOPIES,
    CHIMNEYS,
    COVERS,
    DECKS,
    ROOFS,
    ROOMS,
    TERRAIN,
    WALLS,
    WATER,
)
from aeroscene.scene.hanging import is_hung
from aeroscene.solids.shapes.build import object_primitives
from aeroscene.solids.shapes.shell import FINISH_M
from aeroscene.solids.shapes.storage import shelf_boards
from aeroscene.solids.solids import Solids, colliding
from aeroscene.validation.columns import spans

DRAUGHT_M = 0.03
"""Height of a keel above the bed of its water."""
_PATH_M = 0.02
"""Height of a path's paving above the slope that it climbs."""
_UNDER_M = 0.05
"""Share of an outline over ground from which a bridge is lifted onto it."""
_ROOFED = 0.5
"""Share of a room's outline under a roof that the room carries."""
_SAME_M = 2e-4
"""Difference up to which heights are equal."""
# Corners are probed slightly inside, where the surface of the bearer is well defined.
_INNER = 0.999
_SIGNS = np.array([(1, 1), (-1, 1), (-1, -1), (1, -1)], dtype=float)


def set_heights(layout: Layout, rows: Int[np.ndarray, " k"]) -> None:
    """Set objects, with all they carry, onto the surfaces below them.

    Args:
        layout: Layout; changed.
        rows: Objects, each after the one that carries it, because a host's new height decides.
    # Hosts come first, and carry their objects along.
    """
    for row in rows.tolist():
        if layout.is_pinned[row] or not layout.is_present[row]:
            continue
        base_m = _bearing_m(layout, row)
        rise_m = base_m - float(layout.boxes.base_m[row])
        if abs(rise_m) > _SAME_M:
            layout.shift(row, np.array([0.0, 0.0, rise_m]))


def _bearing_m(layout: Layout, row: int) -> float:
    """Height at which the underside of an object belongs."""
    obj, parent, host = layout.objects[row], layout.parent_of(row), int(layout.host[row])
    if parent is not None:
        return _within_m(layout, row, parent)
    if obj.category in BRIDGES:
        return _highest_cover(layout, row)
    if obj.category in ROOFS:
        return _highest_room(layout, row)
    return _earth_m(layout, row) if host < 0 else surface_m(layout, host, row)


def _earth_m(layout: Layout, row: int, cover_m: float = -inf) -> float:
    """Height at which an object stands on the bare earth: the lowest ground below its outline.

    Args:
        layout: The scene.
        row: The object.
        cover_m: Height of a cover through which the earth may rise.
    """
    relief = layout.scene.relief
    if relief is None:
        return max(0.0, cover_m)
    points = standing_points(layout.object(row))
    return float(np.maximum(relief.height_m(*points.T), cover_m).min())


def _within_m(layout: Layout, row: int, parent: SceneObject) -> float:
    """Height at which the underside of an object with a parent belongs."""
    boxes, obj, host = layout.boxes, layout.objects[row], int(layout.host[row])
    base_m = float(boxes.base_m[row])
    low_m, top_m = float(boxes.base_m[host]), float(boxes.top_m[host])
    # Possible heights by the kind of parent; the one nearest to the present height wins.
    faces_m: tuple[float, ...] = ()
    if is_chained(obj, parent):
        faces_m = (low_m,)
    elif is_fitting(obj, parent):
        faces_m = (base_m,)
    elif is_hung(obj):
        faces_m = (top_m - 2 * float(boxes.half_m[row, 2]),)
    elif parent.category in ROOMS:
        faces_m = (low_m + FINISH_M,)
    elif parent.category in WATER:
        # Boats float; the piers of a deck stand on the bed.
        faces_m = (low_m + DRAUGHT_M, *((low_m,) if obj.category in DECKS else ()))
    elif parent.category in BOARDED and parent.attributes.get("form") == "open":
        boards_m = shelf_boards(top_m - low_m)
        faces_m = (*(low_m + board_m for board_m in boards_m), top_m)
    elif parent.category in CANOPIES:
        faces_m = (low_m, top_m)
    elif parent.category in BUILDINGS:
        faces_m = (top_m,)
    elif obj.category in TERRAIN and _is_sloped(parent):
        faces_m = (low_m + _PATH_M,)
    elif obj.category in CHIMNEYS and parent.attributes.get("form") != "flat":
        # A stack rises through the slope of its roof.
        faces_m = (min(max(base_m, low_m), surface_m(layout, host, row)),)
    if not faces_m:
        return surface_m(layout, host, row)
    return min(faces_m, key=lambda face_m: abs(face_m - base_m))


def _is_sloped(obj: SceneObject) -> bool:
    return obj.category in TERRAIN and obj.attributes.get("form") != "terrace"


def surface_m(layout: Layout, bearer: int, row: int) -> float:
    """Height at which an object stands on a bearer: the lowest ground below its outline, m.

    Args:
        layout: Layout.
        bearer: Row of the bearer.
        row: Row of the object.
    """
    top_m = float(layout.boxes.top_m[bearer])
    category = layout.objects[bearer].category
    if category in COVERS and layout.scene.relief is not None:
        return _earth_m(layout, row, top_m)
    if category not in ROOFS | TERRAIN:
        return top_m  # all others carry at the upper face of their box
    probes = _probes(layout, row)
    solids = _solids_of(layout.object(bearer))
    # Upper ends of all solids of the bearer at each probe; NaN if a solid is not there.
    heights = np.stack([spans(solids, i, probes)[:, 1] for i in range(len(solids))])
    with np.errstate(invalid="ignore"):
        # The upper end of what is highest at a probe; a probe beside all solids has none.
        highest = np.fmax.reduce(heights, axis=0)
    highest = highest[~np.isnan(highest)]
    return float(highest.min()) if len(highest) else top_m


@lru_cache(maxsize=256)
def _solids_of(obj: SceneObject) -> Solids:
    return colliding(object_primitives(obj))


def _probes(layout: Layout, row: int) -> Float[np.ndarray, "5 2"]:
    """Middle and corners of an outline."""
    middle = layout.boxes.centre_m[row, :2]
    corners = _SIGNS * layout.boxes.half_m[row, :2] @ layout.boxes.frame(row)
    return np.vstack([middle, middle + _INNER * corners])


def _highest_cover(layout: Layout, row: int) -> float:
    """Top of the highest cover below an object's outline."""
    return max(
        (
            float(layout.boxes.top_m[ground])
            for ground in layout.rows(COVERS)
            if covered(layout, row, ground) > _UNDER_M
        ),
        default=_earth_m(layout, row),
    )


def _highest_room(layout: Layout, row: int) -> float:
    """Top of the highest room or wall below most of a roof that belongs to no building.

    Without such a room, the highest one below any part of the roof counts, so that no roof falls
    into its house.
    """
    tops_m = {
        part: float(layout.boxes.top_m[part])
        for part in layout.rows(ROOMS | WALLS)
        if _meet(layout, part, row)
    }
    under = [part for part in tops_m if covered(layout, part, row) > _ROOFED]
    return max((tops_m[part] for part in under or tops_m), default=_earth_m(layout, row))


def _meet(layout: Layout, part: int, row: int) -> bool:
    """Return true if the outlines of two objects overlap."""
    return bool(footprint_depth(layout.boxes, np.array([part]), np.array([row]))[0] > 0)


def post(layout: Layout, row: int) -> tuple[Float[np.ndarray, " 2"], float]:
    """Foot of an object on a single post.

    Args:
        layout: The scene.
        row: The object.

    Returns:
        Middle of the foot from the box's middle, in the world's axes, and radius of the foot, m.
    """
    solids = _solids_of(layout.object(row))
    # The lowest solid is the post.
    lowest = int(solids.low_m[:, 2].argmin())
    middle = solids.centre_m[lowest, :2] - layout.boxes.centre_m[row, :2]
    return middle, float(solids.half_m[lowest, :2].max())
