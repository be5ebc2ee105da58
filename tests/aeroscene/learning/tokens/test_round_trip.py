"""Scene to tokens and back: nothing is lost but what the look of an object draws."""

from __future__ import annotations

import numpy as np
import pytest
import torch

from aeroscene.learning.tokens.assembly import assemble
from aeroscene.learning.tokens.batch import TokenBatch, slots_of
from aeroscene.learning.tokens.boxes import Boxes
from aeroscene.learning.tokens.channels import geometry_of
from aeroscene.learning.tokens.decode import TreeDecoder
from aeroscene.learning.tokens.examples import mirrored, quarter_turned
from aeroscene.learning.tokens.kinds import OPENINGS
from aeroscene.learning.tokens.skeleton import Wish, skeleton_of, token_order
from aeroscene.learning.tokens.training_set import TrainingSet
from aeroscene.scene import Scene
from aeroscene.validation import validate
from tests.aeroscene.learning.tokens.decoding import decoded


def test_boxes_come_back_where_they_were(known: TrainingSet, scenes: list[Scene]) -> None:
    for scene, example in zip(scenes, known.examples, strict=True):
        truth, found = geometry_of(scene), decoded(known, example)
        # What stands 5 spreads off is cut; nothing in these scenes does by more than this.
        assert np.abs(found.center_enu_m - truth.center_enu_m)[1:].max() < 0.03
        assert np.abs(found.size_m - truth.size_m)[1:].max() < 0.03
        turn = np.abs(np.exp(1j * found.yaw_rad) - np.exp(1j * truth.yaw_rad))
        assert turn.max() < 0.01
        has_opening = ~np.isnan(truth.openings_m)
        assert np.abs(found.openings_m - truth.openings_m)[has_opening].max(initial=0) < 0.02


def test_assembled_scene_is_as_sound_as_the_first(known: TrainingSet, scenes: list[Scene]) -> None:
    for scene, example in zip(scenes[:3], known.examples, strict=False):
        again = assemble(
            example.skeleton,
            geometry_of(scene),
            known.vocabulary,
            scene_id="again",
            seed=1,
            rng=np.random.default_rng(0),
        )
        assert validate(again) == ()
        assert again.start_position_enu_m == pytest.approx(scene.start_position_enu_m, abs=1e-3)
        assert again.extent_max_enu_m == pytest.approx(scene.extent_max_enu_m, abs=0.02)
        order = token_order(scene)
        for obj, first in zip(again.objects, order, strict=True):
            assert (obj.category, obj.domain) == (first.category, first.domain)
            assert obj.attributes.get("form") == first.attributes.get("form")
            for name in OPENINGS:
                if name in obj.attributes:
                    assert obj.attributes[name] == pytest.approx(first.attributes[name], abs=1e-3)


def test_skeleton_is_coarse_first_and_parents_come_before_children(
    known: TrainingSet, scenes: list[Scene]
) -> None:
    for scene in scenes:
        skeleton = skeleton_of(scene, known.vocabulary)
        is_coarse = known.vocabulary.is_coarse[skeleton.kind_id]
        assert is_coarse[: skeleton.n_coarse].all()
        assert not is_coarse[skeleton.n_coarse :].any()
        assert (skeleton.parent[1:] < np.arange(1, len(skeleton))).all()
        assert len(skeleton) == 1 + len(scene.objects)
        wish = Wish.of(scene)
        assert wish.n_coarse == skeleton.n_coarse - 1
        assert wish.n_fine == len(skeleton) - skeleton.n_coarse


def test_quarter_turn_turns_the_scene(known: TrainingSet) -> None:
    for example in known.examples[:4]:
        first, turned = decoded(known, example), decoded(known, quarter_turned(example))
        x, y = first.center_enu_m[:, :2].T
        np.testing.assert_allclose(turned.center_enu_m[:, :2], np.stack([-y, x], 1), atol=2e-4)
        np.testing.assert_allclose(turned.size_m[1:], first.size_m[1:], atol=1e-4)
        difference = np.exp(1j * (turned.yaw_rad - first.yaw_rad))[1:]
        np.testing.assert_allclose(difference, 1j, atol=1e-4)


def test_four_quarter_turns_and_two_mirrors_change_nothing(known: TrainingSet) -> None:
    example = known.examples[1]
    again = example
    for _ in range(4):
        again = quarter_turned(again)
    np.testing.assert_allclose(mirrored(mirrored(again)).x0, example.x0)


def test_mirror_swaps_north_and_south(known: TrainingSet) -> None:
    for example in known.examples[:4]:
        first, seen = decoded(known, example), decoded(known, mirrored(example))
        np.testing.assert_allclose(seen.center_enu_m, first.center_enu_m * (1, -1, 1), atol=2e-4)


def test_turned_and_mirrored_scenes_stay_within_the_bounds(known: TrainingSet) -> None:
    decoder = TreeDecoder(known.vocabulary, known.statistics)
    rng = np.random.default_rng(3)
    for _ in range(4):
        batch = known.sample_batch(4, rng)
        assert batch.x0 is not None
        low, high = decoder.bounds(batch)
        beyond = torch.maximum(batch.x0 - high, low - batch.x0) * batch.mask[..., None]
        assert float(beyond.max()) < 1e-4


def test_channels_are_standardised(known: TrainingSet) -> None:
    rows = np.concatenate([e.x0 for e in known.examples])
    kind = np.concatenate([e.skeleton.kind_id for e in known.examples])
    spread = np.array([rows[known.statistics.is_free[kind][:, c], c].std() for c in range(8)])
    assert ((spread > 0.5) & (spread < 1.2)).all()
    assert not np.isnan(rows).any()


def test_padding_and_company_do_not_change_a_scene(known: TrainingSet) -> None:
    alone = known.collator.examples([known.examples[2]])
    together = known.collator.examples(list(known.examples))
    skeleton = known.examples[2].skeleton
    decoder = TreeDecoder(known.vocabulary, known.statistics)
    assert alone.x0 is not None
    assert together.x0 is not None
    first = decoder.decode(alone.x0, alone).center_enu_m[0, slots_of(skeleton, alone)]
    second = decoder.decode(together.x0, together).center_enu_m[2, slots_of(skeleton, together)]
    torch.testing.assert_close(first, second)
    assert int(together.mask.sum()) == sum(len(e.skeleton) for e in known.examples)


def test_places_have_gradients_and_carry_children_along(known: TrainingSet) -> None:
    batch = known.collator.examples([known.examples[0]])
    assert batch.x0 is not None
    x0 = batch.x0.clone().requires_grad_()
    decoder = TreeDecoder(known.vocabulary, known.statistics)
    boxes = decoder.decode(x0, batch)
    child = int((batch.depth[0] == 2).nonzero()[0])
    boxes.center_enu_m[0, child, 0].backward()
    assert x0.grad is not None
    parent = int(batch.parent[0, child])
    # What moves the parent moves its child by as much.
    reach = boxes.play_m[0, parent] * _east_of_axes(boxes, batch, parent)
    torch.testing.assert_close(x0.grad[0, parent, :2], reach.detach(), rtol=1e-3, atol=1e-4)


def _east_of_axes(boxes: Boxes, batch: TokenBatch, token: int) -> torch.Tensor:
    """How far east one metre along each axis of the parent's frame is."""
    cos, sin = boxes.heading[0, int(batch.parent[0, token])]
    return torch.stack([cos, -sin])
