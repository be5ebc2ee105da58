"""What bears what: covers under objects without a parent, and objects that boxes were read off."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from aeroscene.learning.program.program import ProgramError
from aeroscene.relations.plane import footprint
from aeroscene.scene import OrientedBox, Scene, SceneObject
from aeroscene.scene.catalogue import GROUND, WALLS

BUILT_M = 0.02
"""A partition builds what it was read off again within so much."""
_ON_M = 0.5
"""Farthest above or below a cover's top that what stands on it begins."""


@dataclass(frozen=True, slots=True)
class Bearers:
    """Covers of the ground, and which of them bears each object that has no parent."""

    covers: frozenset[int]
    bearer: dict[int, int]


def covers_under(scene: Scene, given: Sequence[int]) -> Bearers:
    """The cover under the middle of each object without a parent: whose top is nearest to it."""
    objects = scene.object_by_id
    covers = [objects[i] for i in given if objects[i].category in GROUND]
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
    """Whether the middle of a box is over a cover."""
    outline = footprint(cover)
    u_m, v_m, _ = outline.place.local(footprint(box).place)
    return abs(u_m) <= outline.half_m[0] and abs(v_m) <= outline.half_m[1]


def find_boxes(boxes: Sequence[OrientedBox], objects: Sequence[SceneObject]) -> list[SceneObject]:
    """The object that each box was read off: the nearest, each once.

    Raises:
        ProgramError: If an object and its box are further apart than they may be.
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
    """How far the ends of a wall may differ: which of two walls has their corner is no matter."""
    return min(obj.bbox.s[:2]) if obj.category in WALLS else 0.0
