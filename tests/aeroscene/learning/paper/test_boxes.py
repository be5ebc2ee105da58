"""Boxes as skeletons."""

from __future__ import annotations

import numpy as np
import pytest

from aeroscene.learning.paper.boxes import FlatBoxes, as_skeleton, usable_categories
from aeroscene.learning.paper.layouts import flat_layout
from aeroscene.learning.tokens.assembly import assemble
from aeroscene.learning.tokens.kinds import count_kinds
from aeroscene.learning.tokens.skeleton import Wish
from aeroscene.scene import Scene
from aeroscene.scene.catalogue import CATALOGUE, COARSE_COUNT


def boxes_of(scene: Scene, *, has_regions: bool) -> FlatBoxes:
    layout = flat_layout(scene, Wish.of(scene), has_regions=True)
    return FlatBoxes(
        layout.category,
        layout.center_enu_m,
        layout.yaw_rad,
        layout.size_m,
        layout.region if has_regions else None,
    )


def test_regions_are_the_parents(scene_42: Scene) -> None:
    boxes, vocabulary = boxes_of(scene_42, has_regions=True), count_kinds([scene_42])
    skeleton, geometry = as_skeleton(boxes, "mixed", vocabulary, np.random.default_rng(0))
    np.testing.assert_allclose(geometry.center_enu_m[1:], boxes.center_enu_m)
    n = skeleton.n_coarse
    assert (skeleton.parent[:n] == 0).all()
    assert (skeleton.parent[n:] == 1 + boxes.region[n - 1 :]).all()


def test_without_regions_fine_objects_belong_to_the_nearest_coarse_one(scene_42: Scene) -> None:
    boxes, vocabulary = boxes_of(scene_42, has_regions=False), count_kinds([scene_42])
    skeleton, geometry = as_skeleton(boxes, "mixed", vocabulary, np.random.default_rng(0))
    n = skeleton.n_coarse
    for token in range(n, len(skeleton), 7):
        away = np.linalg.norm(geometry.center_enu_m[1:n] - geometry.center_enu_m[token], axis=1)
        assert away[skeleton.parent[token] - 1] == pytest.approx(away.min())


def test_any_boxes_make_a_document(scene_42: Scene) -> None:
    vocabulary, rng = count_kinds([scene_42]), np.random.default_rng(1)
    boxes = FlatBoxes(
        rng.integers(1, 1 + len(CATALOGUE), 30),
        rng.normal(size=(30, 3)),
        rng.normal(size=30),
        rng.uniform(0.1, 2.0, (30, 3)),
    )
    skeleton, geometry = as_skeleton(boxes, "outdoor", vocabulary, rng)
    scene = assemble(skeleton, geometry, vocabulary, scene_id="noise", seed=0, rng=rng)
    assert len(scene.objects) == 30
    n_coarse = sum(obj.category_id <= COARSE_COUNT for obj in scene.objects)
    assert n_coarse == skeleton.n_coarse - 1
    assert usable_categories(vocabulary)[[obj.category_id for obj in scene.objects]].all()
