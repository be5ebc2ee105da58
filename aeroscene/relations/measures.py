"""Figures about scenes by their relations, and the null that says what chance alone gives."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from aeroscene.relations.parsing.reading import scene_relations
from aeroscene.relations.placing import place
from aeroscene.relations.plane import footprint, turned_reach_m
from aeroscene.relations.relation import Kind, Unit
from aeroscene.scene import OrientedBox, Scene
from aeroscene.scene.catalogue import CATALOGUE

MIN_ROW = 3
"""Fewer are no row."""
STREWN = frozenset({"tree", "bush"})
"""What grows where it likes: no other relation is expected of it."""
_EQUAL_M = 0.02


@dataclass(frozen=True, slots=True, kw_only=True)
class RelationShares:
    """Shares of the fine objects of scenes; zeros where there are none."""

    n_objects: int
    explained: float
    """In a relation other than SCATTER, or in a row or grid."""
    expected: float
    """Explained, or of the kinds that are strewn, see `STREWN`."""
    pinned: float
    """With a place that a relation pins in both axes."""
    in_rows: float
    """In rows and grids of at least three equal ones."""
    n_groups: int
    """Rows, grids, and tables with chairs."""
    n_members: int


def relation_shares(scenes: Iterable[Scene]) -> RelationShares:
    """What relations hold in scenes."""
    counts: defaultdict[str, int] = defaultdict(int)
    for unit in (unit for scene in scenes for unit in scene_relations(scene)):
        n_members = len(unit.members)
        is_related = unit.relation.kind != Kind.SCATTER or unit.is_group
        is_strewn = CATALOGUE[unit.members[0].category_id].name in STREWN
        counts["objects"] += n_members
        counts["explained"] += n_members * is_related
        counts["expected"] += n_members * (is_related or is_strewn)
        counts["pinned"] += sum(all(unit.pins(index)[:2]) for index in range(n_members))
        counts["in_rows"] += n_members * is_row_of_equals(unit)
        counts["groups"] += n_members > 1
        counts["members"] += n_members * (n_members > 1)
    n_objects = max(1, counts["objects"])
    return RelationShares(
        n_objects=counts["objects"],
        explained=counts["explained"] / n_objects,
        expected=counts["expected"] / n_objects,
        pinned=counts["pinned"] / n_objects,
        in_rows=counts["in_rows"] / n_objects,
        n_groups=counts["groups"],
        n_members=counts["members"],
    )


def is_row_of_equals(unit: Unit) -> bool:
    """Whether a unit is a row or grid of at least three objects of one size."""
    if unit.relation.kind == Kind.SEAT or len(unit.members) < MIN_ROW:
        return False
    sizes_m = np.array([member.size_m[:2] for member in unit.members])
    return bool(np.ptp(sizes_m, axis=0).max() <= _EQUAL_M)


@dataclass(frozen=True, slots=True, kw_only=True)
class PinnedError:
    """Root mean squares over the axes that relations pin, m."""

    before_m: float
    """About the middle of the parent."""
    after_m: float
    """About the place that the relation gives."""


def pinned_error(scenes: Iterable[Scene]) -> PinnedError:
    """How far places are off where relations put them, from hosts that stand where they are."""
    before: list[float] = []
    after: list[float] = []
    for scene in scenes:
        boxes = {obj.id: obj.bbox for obj in scene.objects}
        for unit in scene_relations(scene):
            if unit.parent_id is None or unit.host_id is None:
                continue
            given = place([without_noise(unit)], boxes)
            frame = footprint(boxes[unit.host_id]).from_side(unit.relation.side)
            middle = frame.local(footprint(boxes[unit.parent_id]).place)
            for index, member in enumerate(unit.members):
                at, to = (frame.local(footprint(b[member.id]).place) for b in (boxes, given))
                axes = [axis for axis in (0, 1) if unit.pins(index)[axis]]
                before += [at[axis] - middle[axis] for axis in axes]
                after += [at[axis] - to[axis] for axis in axes]
    return PinnedError(before_m=_rms(before), after_m=_rms(after))


def without_noise(unit: Unit) -> Unit:
    """A unit with only what its relation leaves open."""
    members = tuple(
        replace(member, residual=member.residual.unpinned((True, True, True)))
        for member in unit.members
    )
    residual = unit.residual.unpinned(unit.relation.pinned)
    return replace(unit, members=members, residual=residual)


def _rms(values: list[float]) -> float:
    return float(np.sqrt(np.mean(np.square(values)))) if values else math.nan


def strewn(scene: Scene, rng: np.random.Generator) -> Scene:
    """The null: fine objects at random places within their parents, headed as they were."""
    boxes: dict[int, OrientedBox] = {}
    for obj in scene.objects:
        box = boxes[obj.id] = obj.bbox
        if obj.is_coarse or obj.parent_id is None:
            continue
        before = footprint(scene.object_by_id[obj.parent_id].bbox)
        parent = footprint(boxes[obj.parent_id])
        turn_rad = before.place.local(footprint(box).place)[2]
        reach_m = turned_reach_m(footprint(box).half_m, turn_rad)
        play_m = np.maximum(0.0, np.subtract(parent.half_m, reach_m))
        u_m, v_m = rng.uniform(-play_m, play_m).tolist()
        spot = parent.place.moved(u_m, v_m)
        boxes[obj.id] = OrientedBox((spot.x_m, spot.y_m, box.p[2]), box.q, box.s)
    objects = tuple(replace(obj, bbox=boxes[obj.id]) for obj in scene.objects)
    return replace(scene, objects=objects, interaction_areas=())
