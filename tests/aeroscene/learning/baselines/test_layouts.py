"""Flat layouts: what a scene becomes and comes back as."""

from dataclasses import replace

import numpy as np
import pytest

from aeroscene.learning.baselines.layouts import (
    CATEGORY,
    EMPTY,
    LayoutCode,
    LayoutSet,
    layouts_of,
)
from aeroscene.learning.baselines.marginals import Marginals
from aeroscene.learning.paper.boxes import FlatBoxes
from aeroscene.learning.training.config import TrainingError
from aeroscene.scene import DOMAINS
from tests.aeroscene.conftest import cached_scene, sampled_scenes


@pytest.fixture(scope="module")
def code():
    return LayoutCode.from_scenes(sampled_scenes())


def test_boxes_survive_encoding_and_decoding(code):
    for boxes in layouts_of(sampled_scenes()):
        found = code.decode(code.encode(boxes))
        assert (found.category == boxes.category).all()
        assert found.center_enu_m == pytest.approx(boxes.center_enu_m, abs=1e-6)
        assert found.size_m == pytest.approx(boxes.size_m, rel=1e-6)
        assert np.cos(found.yaw_rad - boxes.yaw_rad) == pytest.approx(1.0)


def test_a_decoded_scene_has_the_same_boxes_in_two_levels(code):
    scene = cached_scene(42)
    (boxes,) = layouts_of([scene])
    made = code.scene(boxes_of(boxes), scene.domain, 42, np.random.default_rng(0))
    (again,) = layouts_of([made])
    for name in ("category", "center_enu_m", "size_m"):
        order, order_again = (
            np.lexsort((*b.center_enu_m.round(3).T, b.category)) for b in (boxes, again)
        )
        whole = getattr(boxes, name)[order], getattr(again, name)[order_again]
        # No document has an extent below MIN_SIZE_M.
        assert whole[1] == pytest.approx(whole[0], abs=2e-3 if name != "size_m" else 0.0101)
    assert made.domain == scene.domain
    coarse = {obj.id for obj in made.objects if obj.is_coarse}
    assert all((obj.parent_id in coarse) != obj.is_coarse for obj in made.objects)


def boxes_of(layout):
    return FlatBoxes(layout.category, layout.center_enu_m, layout.yaw_rad, layout.size_m)


def test_sites_are_turned_as_those_of_training_are(code):
    scene = cached_scene(42)
    (layout,) = layouts_of([scene])
    along = replace(code, site_yaw_rad=np.full_like(code.site_yaw_rad, 0.3))
    made = along.scene(boxes_of(layout), scene.domain, 42, np.random.default_rng(0))
    assert layouts_of([made])[0].site_yaw_rad == pytest.approx(0.3, abs=1e-6)
    outdoor = DOMAINS.index("outdoor")
    known = [each.site_yaw_rad for each in layouts_of(sampled_scenes())]
    assert set(code.site_yaw_rad[outdoor].tolist()) <= set(known)
    assert len(set(code.site_yaw_rad[outdoor].tolist())) > 1


def test_empty_slots_are_no_objects_and_a_layout_has_one_at_least(code):
    (boxes,) = layouts_of(sampled_scenes()[:1])
    x = code.encode(boxes)
    x[1:, CATEGORY], x[1:, EMPTY] = -1.0, 1.0
    assert len(code.decode(x).category) == 1
    x[0, CATEGORY], x[0, EMPTY] = -0.9, 1.0
    assert len(code.decode(x).category) == 1


def test_batches_are_turned_and_mirrored_as_one_and_keep_their_content(code):
    data = LayoutSet.from_scenes(sampled_scenes()[:1], code)
    (boxes,) = layouts_of(sampled_scenes()[:1])
    away = np.linalg.norm(boxes.center_enu_m[:, None] - boxes.center_enu_m, axis=-1)
    away = np.sort(away, axis=None)
    seen = set()
    for seed in range(12):
        batch = data.sample_batch(1, np.random.default_rng(seed))
        found = code.decode(batch.x0[0, batch.mask[0]].double().numpy())
        between = np.linalg.norm(found.center_enu_m[:, None] - found.center_enu_m, axis=-1)
        # Each has the order that belongs to it.
        assert np.sort(between, axis=None) == pytest.approx(away, abs=1e-3)
        assert sorted(found.category) == sorted(boxes.category)
        seen.add(tuple(found.center_enu_m[0].round(2).tolist()))
    assert len(seen) >= 4
    assert int(batch.domain) == DOMAINS.index(sampled_scenes()[0].domain)


def test_scenes_with_more_objects_than_slots_are_left_out():
    code = LayoutCode.from_scenes([min(sampled_scenes(), key=lambda scene: len(scene.objects))])
    assert 0 < len(LayoutSet.from_scenes(sampled_scenes(), code).examples) < len(sampled_scenes())


def test_marginals_keep_what_there_is_and_break_what_goes_together():
    marginals = Marginals(sampled_scenes())
    made = marginals.sample(3, "outdoor")
    assert made == marginals.sample(3, "outdoor")
    assert made != marginals.sample(4, "outdoor")
    outdoor = [scene for scene in sampled_scenes() if scene.domain == "outdoor"]
    assert len(made.objects) in {len(scene.objects) for scene in outdoor}
    sizes = {obj.bbox.s for scene in outdoor for obj in scene.objects}
    known = np.array(sorted(sizes))
    for obj in made.objects:
        assert np.abs(known - obj.bbox.s).max(axis=1).min() < 2e-3
    with pytest.raises(TrainingError, match="domain is 'indoor'; valid: outdoor"):
        Marginals(outdoor).sample(0, "indoor")


def test_an_empty_set_of_boxes_is_never_decoded(code):
    nothing = np.full((4, EMPTY + 1), -1.0)
    assert isinstance(code.decode(nothing), FlatBoxes)
