"""Boxes as scene documents."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aeroscene.learning.paper.boxes import FlatBoxes, _regions
from aeroscene.learning.paper.layouts import flat_layout
from aeroscene.learning.paper.looks import Looks
from aeroscene.learning.wishes import Wish
from aeroscene.scene import Scene, SceneObject
from aeroscene.scene.catalogue import CATALOGUE, category_id


def boxes_of(scene: Scene, *, has_regions: bool) -> FlatBoxes:
    layout = flat_layout(scene, Wish.from_scene(scene), has_regions=True)
    return FlatBoxes(
        layout.category,
        layout.center_enu_m,
        layout.yaw_rad,
        layout.size_m,
        layout.region if has_regions else None,
    )


def made_of(boxes: FlatBoxes, scene: Scene, seed: int = 0) -> Scene:
    looks = Looks.from_scenes([scene])
    return boxes.scene(scene.domain, looks, "made", 7, np.random.default_rng(seed))


def test_regions_are_the_parents(scene_42: Scene) -> None:
    boxes = boxes_of(scene_42, has_regions=True)
    made = made_of(boxes, scene_42)
    assert (made.scene_id, made.seed, made.domain) == ("made", 7, scene_42.domain)
    assert boxes.region is not None
    for obj, center, size, region in zip(
        made.objects, boxes.center_enu_m, boxes.size_m, boxes.region, strict=True
    ):
        assert obj.bbox.p == pytest.approx(center, abs=1e-4)
        assert obj.bbox.s == pytest.approx(np.maximum(size, 0.01), abs=1e-3)
        assert obj.parent_id == (None if region < 0 else region)
        assert obj.is_coarse == (obj.id < sum(o.is_coarse for o in made.objects))


def test_without_regions_fine_objects_belong_to_the_smallest_coarse_one_that_they_are_in(
    scene_42: Scene,
) -> None:
    boxes = boxes_of(scene_42, has_regions=False)
    made = made_of(boxes, scene_42)
    coarse = [obj for obj in made.objects if obj.is_coarse]
    n_within = 0
    for obj in (obj for obj in made.objects if not obj.is_coarse):
        around = [other for other in coarse if _is_over(other, obj)]
        if around:
            own = min(around, key=lambda other: other.bbox.s[0] * other.bbox.s[1])
            n_within += 1
        else:
            own = min(coarse, key=lambda other: math.dist(other.bbox.p, obj.bbox.p))
        assert obj.parent_id == own.id
    assert n_within > 50


def _is_over(region: SceneObject, obj: SceneObject) -> bool:
    """Whether the middle of an object is within a region's outline, and not below it."""
    east_m, north_m = obj.bbox.p[0] - region.bbox.p[0], obj.bbox.p[1] - region.bbox.p[1]
    c, s = math.cos(region.bbox.yaw_rad), math.sin(region.bbox.yaw_rad)
    along_m, across_m = abs(c * east_m + s * north_m), abs(c * north_m - s * east_m)
    is_in = along_m <= region.bbox.s[0] / 2 and across_m <= region.bbox.s[1] / 2
    return is_in and obj.bbox.p[2] >= region.bbox.p[2] - region.bbox.s[2] / 2


def test_a_chair_by_a_wall_belongs_to_the_room() -> None:
    wall, room, chair = (category_id(name) for name in ("wall", "room", "chair"))
    boxes = FlatBoxes(
        np.array([room, wall, chair]),
        np.array([[0.0, 0.0, 0.05], [2.0, 0.0, 1.25], [1.7, 0.0, 0.55]]),
        np.zeros(3),
        np.array([[4.0, 4.0, 0.1], [0.1, 4.0, 2.5], [0.5, 0.5, 0.9]]),
    )
    assert _regions(boxes.center_enu_m, boxes.size_m, boxes.yaw_rad, 2).tolist() == [0]


def test_flights_start_on_the_pad(scene_42: Scene) -> None:
    made = made_of(boxes_of(scene_42, has_regions=True), scene_42)
    (pad,) = [obj for obj in made.objects if obj.attributes.get("is_start")]
    assert made.start_position_enu_m[:2] == pytest.approx(pad.bbox.p[:2])


def test_what_is_alike_in_one_room_looks_alike(scene_42: Scene) -> None:
    made = made_of(boxes_of(scene_42, has_regions=True), scene_42)
    seen: dict[tuple[int, int | None], object] = {}
    n_alike = 0
    for obj in made.objects:
        if obj.domain == "indoor":
            key = obj.category_id, obj.parent_id
            n_alike += key in seen
            assert seen.setdefault(key, obj.attributes) == obj.attributes
    assert n_alike > 3
    assert made != made_of(boxes_of(scene_42, has_regions=True), scene_42, seed=1)


def test_any_boxes_make_a_document(scene_42: Scene) -> None:
    rng = np.random.default_rng(1)
    boxes = FlatBoxes(
        rng.integers(1, 1 + len(CATALOGUE), 30),
        rng.normal(size=(30, 3)),
        rng.normal(size=30),
        rng.uniform(0.1, 2.0, (30, 3)),
    )
    made = made_of(boxes, scene_42)
    assert len(made.objects) == 30
    assert {obj.category for obj in made.objects} <= set(Looks.from_scenes([scene_42]).by_category)
