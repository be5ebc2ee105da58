"""Validity of the objects of a scene: free of others, and rightly supported.

Raw scenes are hardly ever sound as a whole, so a yes or no for each scene would say nothing. This
measure gives the share of their sound objects.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from aeroscene.feasibility.boxes import Boxes, boxes_of, footprint_depth, forbidden_overlaps
from aeroscene.scene import Scene
from aeroscene.scene.catalogue import ROOFS, WATER
from aeroscene.solids.shapes import Primitive, scene_primitives
from aeroscene.solids.solids import Solids, colliding
from aeroscene.validation.columns import spans
from aeroscene.validation.support import floating

OVERLAP_M = 0.01
"""Deepest permitted overlap of two strangers, boxes of which neither is the other's ancestor."""
SUNK_M = 0.03
"""Depth from which an object whose whole outline lies inside its base has sunk into it."""
AWAY_M = 0.05
"""Distance by which an object may lie beside its parent: its middle, or the edge of a coarse one.
"""
OUTSIDE_M = 0.01
"""Distance by which a box may extend beyond the flight volume."""
_INNER = 0.98
"""Share of the half extents at which outlines are probed: a wall beside one does not count."""


@dataclass(frozen=True, slots=True, eq=False)
class ObjectValidity:
    """Verdict for each object of a scene, in their order."""

    overlap_m: Float[np.ndarray, " n"]
    """Depth of the deepest overlap with a stranger; 0 without one."""
    is_standing: Bool[np.ndarray, " n"]
    """True if its feet are on something, or it is a part of a building that holds it."""
    is_sunk: Bool[np.ndarray, " n"]
    """True if all of its underside is within something solid."""
    is_away: Bool[np.ndarray, " n"]
    """True if it is not at its parent, or not within the flight volume."""

    @property
    def is_free(self) -> Bool[np.ndarray, " n"]:
        """True for objects without a forbidden overlap deeper than `OVERLAP_M`."""
        return self.overlap_m <= OVERLAP_M

    @property
    def is_supported(self) -> Bool[np.ndarray, " n"]:
        """True for objects that stand on a base that can carry them."""
        return self.is_standing & ~self.is_sunk & ~self.is_away

    @property
    def is_valid(self) -> Bool[np.ndarray, " n"]:
        """True for objects that are free and rightly supported."""
        return self.is_free & self.is_supported


def validity(scene: Scene, primitives: Sequence[Primitive] | None = None) -> ObjectValidity:
    """Judge every object of a scene, sound or not.

    Args:
        scene: Scene.
        primitives: The scene's primitives, if the caller has them already.
    """
    boxes = boxes_of(scene.objects)
    solids = colliding(scene_primitives(scene) if primitives is None else primitives)
    row = {obj.id: i for i, obj in enumerate(scene.objects)}
    is_standing = np.ones(len(boxes), dtype=bool)
    is_standing[[row[f.object_id] for f in floating(scene, solids) if f.object_id in row]] = False
    return ObjectValidity(
        forbidden_overlaps(boxes).by_box(len(boxes)),
        is_standing,
        _sunk(scene, boxes, solids, row),
        _away(scene, boxes) | _outside(scene, boxes),
    )


def _sunk(
    scene: Scene, boxes: Boxes, solids: Solids, row: dict[int, int]
) -> Bool[np.ndarray, " n"]:
    owner = np.array([row[i] for i in solids.object_id.tolist()], dtype=int)
    probes = (boxes.corners() - boxes.centre_m[:, None, :2]) * _INNER
    probes = np.concatenate([np.zeros((len(boxes), 1, 2)), probes], axis=1)
    probes += boxes.centre_m[:, None, :2]
    is_sunk = np.zeros(len(boxes), dtype=bool)
    objects = scene.objects
    for i, above in enumerate(boxes.parent.tolist()):
        # A boat sinks into water, a chimney into the slope of a roof.
        if above < 0 or objects[above].category not in WATER | ROOFS:
            is_sunk[i] = _is_buried(solids, owner, boxes, i, probes[i])
    return is_sunk


def _is_buried(
    solids: Solids, owner: Int[np.ndarray, " s"], boxes: Boxes, i: int, probes: np.ndarray
) -> bool:
    """Return true if every probe, at the height to which feet may sink, is in another's solid."""
    height_m = boxes.base_m[i] + SUNK_M
    low, high = probes.min(axis=0), probes.max(axis=0)
    near = solids.near(np.array([*low, height_m]), np.array([*high, height_m]))
    # Neither the object itself nor objects that it carries.
    is_other = ~boxes.is_kin[i, owner[near]] | (owner[near] < i)
    is_free = np.ones(len(probes), dtype=bool)
    for index in near[is_other].tolist():
        span = spans(solids, index, probes)
        is_free &= ~((span[:, 0] < height_m) & (height_m < span[:, 1]))
        if not is_free.any():
            return True
    return False


def _away(scene: Scene, boxes: Boxes) -> Bool[np.ndarray, " n"]:
    """Fine objects whose middle is beside their parent, coarse ones that do not even touch it."""
    objects, parent = scene.objects, boxes.parent
    child = np.flatnonzero(parent >= 0)
    offset = boxes.centre_m[child, :2] - boxes.centre_m[parent[child], :2]
    local = np.abs(np.einsum("nai,ni->na", boxes.axes_of(parent[child]), offset))
    beyond_m = (local - boxes.half_m[parent[child], :2]).max(axis=1, initial=-np.inf)
    is_coarse = np.array([obj.is_coarse for obj in objects], dtype=bool)[child]
    beyond_m[is_coarse] = -footprint_depth(boxes, child, parent[child])[is_coarse]
    is_away = np.zeros(len(boxes), dtype=bool)
    is_away[child] = beyond_m > AWAY_M
    return is_away


def _outside(scene: Scene, boxes: Boxes) -> Bool[np.ndarray, " n"]:
    low, high = np.asarray(scene.extent_min_enu_m), np.asarray(scene.extent_max_enu_m)
    corners = boxes.corners()
    least = np.column_stack([corners.min(axis=1, initial=np.inf), boxes.base_m])
    most = np.column_stack([corners.max(axis=1, initial=-np.inf), boxes.top_m])
    return np.maximum(low - least, most - high).max(axis=1, initial=-np.inf) > OUTSIDE_M
