"""Bearers of objects: covers under objects without a parent, and objects behind built boxes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from aeroscene.learning.program.program import ProgramError
from aeroscene.relations.plane import footprint
from aeroscene.scene import OrientedBox, Scene, SceneObject
from aeroscene.scene.catalogue import GROUND, WALLS

BUILT_M = 0.02
"""A partition rebuilds the boxes that it was read from to within this distance."""
_ON_M = 0.5
"""Greatest distance of an object's underside from the top of the cover that bears it."""


@dataclass(frozen=True, slots=True)
class Bearers:
    """Covers of the ground, and the cover that bears each object without a parent."""

    covers: frozenset[int]
    bearer: dict[int, int]


def covers_under(scene: Scene, given: Sequence[int]) -> Bearers:
    """Find the cover under the middle of each object without a parent.

    Among several the one with the nearest top counts.

    Args:
        scene: The scene.
        given: Ids of objects that partitions build.
    """
    objects = scene.object_by_id
    covers = [objects[i] for i in given if objects[i].category in GROUND]
    # Floors in buildings are covers, too, but stand in their own hierarchy.
    covers = [cover for cover in covers if cover.domain == "outdoor"]
    known = frozenset(given)
    found: dict[int, int] = {}
    for obj in scene.objects:
        if obj.parent_id is not None or obj.id in known:
            continue
        base_m = obj.bbox.p[2] - obj.bbox.s[2] / 2
        under = [
            (abs(base_m - cover.bbox.p[2] - cover.bbox.s[2] / 2), cover.id)
            for cover in covers
            if _is_over(obj.bbox, cover.bbox)
        ]
        if under and min(under)[0] <= _ON_M:
            found[obj.id] = min(under)[1]
    return Bearers(frozenset(cover.id for cover in covers), found)


def _is_over(box: OrientedBox, cover: OrientedBox) -> bool:
    """True if the middle of a box is over a cover."""
    outline = footprint(cover)
    u_m, v_m, _ = outline.place.local(footprint(box).place)
    return abs(u_m) <= outline.half_m[0] and abs(v_m) <= outline.half_m[1]


def find_boxes(boxes: Sequence[OrientedBox], objects: Sequence[SceneObject]) -> list[SceneObject]:
    """Return the object that each built box was read from: the nearest, each once.

    Raises:
        ProgramError: If a box is further from its object than it may be, or two boxes share an
            object.
    """
    if len(boxes) != len(objects):
        raise ProgramError(
            f"partition builds {len(boxes)} boxes of {len(objects)}; valid: one for each object"
        )
    if not boxes:
        return []
    built, wanted = (
        np.array([box.corners() for box in some]) for some in (boxes, [obj.bbox for obj in objects])
    )
    # Distance of the lower and of the upper corners: the larger one counts.
    low = np.linalg.norm(built.min(1)[:, None] - wanted.min(1), axis=2)
    far = np.maximum(low, np.linalg.norm(built.max(1)[:, None] - wanted.max(1), axis=2))
    nearest = far.argmin(axis=1)
    for index, place in enumerate(nearest.tolist()):
        most_m = BUILT_M + _joint_m(objects[place])
        if far[index, place] > most_m:
            raise ProgramError(
                f"object {objects[place].id} is {far[index, place]:.3f} m off the box that its "
                f"partition builds; valid: at most {most_m:g} m"
            )
    if len(set(nearest.tolist())) < len(objects):
        raise ProgramError("partition builds a box twice; valid: one for each object")
    return [objects[place] for place in nearest.tolist()]


def _joint_m(obj: SceneObject) -> float:
    """Allowance for the ends of walls: either of two walls may own their common corner."""
    return min(obj.bbox.s[:2]) if obj.category in WALLS else 0.0
