"""Redoing a region of a scene: its fine objects are drawn anew, and everything else stays."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from aeroscene.feasibility.region import Region
from aeroscene.learning.wishes import RequestError
from aeroscene.scene import Scene, SceneObject
from aeroscene.solids.shapes import scene_primitives
from aeroscene.solids.solids import colliding
from aeroscene.validation.support import floating

MOST_ROUNDS = 5
"""Draws in a region, each beside the objects of those before it."""
NEARLY = 0.15
"""Share of the wished objects that may be missing."""


@dataclass(frozen=True, kw_only=True)
class Redo:
    """A region of a scene whose fine objects are drawn anew.

    Raises:
        RequestError: If the region lies outside of the scene.
    """

    scene: Scene
    region: Region

    def __post_init__(self) -> None:
        low, high = self.scene.extent_min_enu_m, self.scene.extent_max_enu_m
        is_high = self.region.low_enu_m[2] <= high[2] and self.region.high_enu_m[2] >= low[2]
        if self.region.share_of(self.scene) <= 0 or not is_high:
            spans = ", ".join(
                f"{x} {a:g} to {b:g}" for x, a, b in zip("xyz", low, high, strict=True)
            )
            raise RequestError(
                f"region {self.region} lies outside of scene {self.scene.scene_id!r}; valid: some "
                f"of {spans}"
            )

    @cached_property
    def gone(self) -> frozenset[int]:
        """Ids of the objects that go: fine ones with their middles in the region, and their load.

        The pad from which the flight starts stays, and so does every object that bears it or
        anything coarse.
        """
        scene = self.scene
        stays = {obj.id for obj in scene.objects if _must_stay(obj)}
        stays |= {above for each in stays for above in scene.ancestors(each)}
        gone: set[int] = set()
        for obj in scene.objects:
            # Parents come before children, so a child sees that its parent goes.
            is_in = obj.parent_id in gone or self.region.holds(obj.bbox.p)
            if is_in and obj.id not in stays:
                gone.add(obj.id)
        # Without their support further objects would float: they go too, until none is left.
        while lost := self._unborne(gone) - stays:
            gone |= lost
        return frozenset(gone)

    def _unborne(self, gone: set[int]) -> set[int]:
        """Return the objects that float when some are gone, with their children."""
        left = _left(self.scene, gone)
        found = _floating(left)
        if found:
            # Objects that floated before are not lost: the scene came so.
            found -= _floating(self.scene)
        for obj in left.objects:
            if obj.parent_id in found:
                found.add(obj.id)
        return found

    @cached_property
    def kept(self) -> Scene:
        """The scene without the objects that go, and without areas, wishes and measures."""
        return replace(_left(self.scene, self.gone), wishes={}, measured={})

    @property
    def first_id(self) -> int:
        """Least id of new objects, beyond all ids of the scene."""
        return 1 + max((obj.id for obj in self.scene.objects), default=-1)

    @property
    def n_kept_fine(self) -> int:
        """Number of fine objects that stay."""
        return sum(not obj.is_coarse for obj in self.kept.objects)

    def n_wanted(self, n_usual: int) -> int:
        """Number of objects to draw.

        It is the number of objects that go. If none does, it is the region's share of the usual
        number.
        """
        return len(self.gone) or max(1, round(n_usual * self.region.share_of(self.scene)))

    def kept_in(self, known: Scene, drawn: Scene) -> Scene:
        """Add to a known scene those drawn objects that lie in the region and have a parent.

        Args:
            known: The scene so far.
            drawn: The same objects, followed by new ones.
        """
        ids = {obj.id for obj in known.objects}
        found: list[SceneObject] = []
        # New objects follow the known ones, see `furnish`.
        for obj in drawn.objects[len(known.objects) :]:
            is_borne = obj.parent_id is None or obj.parent_id in ids
            if is_borne and self.region.holds(obj.bbox.p):
                ids.add(obj.id)
                found.append(obj)
        return replace(known, objects=(*known.objects, *found))


@dataclass(frozen=True, eq=False)
class RedoneProposal:
    """A scene that stays, with the objects that were drawn in its region."""

    found: Scene

    def scene(self, scene_id: str, seed: int, rng: np.random.Generator) -> Scene:
        """Return the raw scene under another name; its looks are drawn already."""
        del rng
        objects = tuple(replace(obj, scene_id=scene_id) for obj in self.found.objects)
        return replace(self.found, scene_id=scene_id, seed=seed, objects=objects)


def _must_stay(obj: SceneObject) -> bool:
    return obj.is_coarse or obj.attributes.get("is_start") is True


def _left(scene: Scene, gone: set[int] | frozenset[int]) -> Scene:
    objects = tuple(obj for obj in scene.objects if obj.id not in gone)
    return replace(scene, objects=objects, interaction_areas=())


def _floating(scene: Scene) -> set[int]:
    found = floating(scene, colliding(scene_primitives(scene)))
    return {finding.object_id for finding in found if finding.object_id is not None}
