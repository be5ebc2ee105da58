"""Borders that meet, on real scenes whose coarse tokens are off by a little."""

from __future__ import annotations

import pytest
import torch
from torch import Tensor

from aeroscene.corpus.curation import curate_scene
from aeroscene.learning.diffusion.sampling import Moment
from aeroscene.learning.diffusion.schedule import DiffusionError
from aeroscene.learning.guidance.borders import BorderGuidance, BordersCfg, GuidanceChain
from aeroscene.learning.guidance.containment import contained
from aeroscene.learning.tokens.batch import TokenBatch
from aeroscene.learning.tokens.boxes import footprints_of
from aeroscene.learning.tokens.decode import TreeDecoder
from aeroscene.learning.tokens.training_set import TrainingSet, training_set
from aeroscene.scene.catalogue import by_name

LAST = Moment(index=29, n_steps=30, time=0.03, alpha_bar=0.99, fixed=None)
FIRST = Moment(index=0, n_steps=30, time=1.0, alpha_bar=0.0, fixed=None)


@pytest.fixture(scope="module")
def known() -> TrainingSet:
    """An outdoor, a mixed and two indoor scenes."""
    return training_set([curate_scene(index) for index in (7, 42, 311, 320)])


def decoder_of(known: TrainingSet) -> TreeDecoder:
    return TreeDecoder(known.vocabulary, known.statistics)


def guidance(known: TrainingSet) -> BorderGuidance:
    return BorderGuidance(decoder_of(known), known.vocabulary)


def shaken(batch: TokenBatch, spread: float, seed: int = 0) -> Tensor:
    """Places and extents of coarse tokens off by so many standard deviations."""
    noise = torch.randn(batch.x0.shape, generator=torch.Generator().manual_seed(seed))
    noise[:, batch.n_coarse_slots :] = 0
    noise[:, 0] = 0
    noise[..., 2:5] = 0
    noise[..., 8:] = 0
    return batch.x0 + spread * noise * (batch.weight > 0)


def border_overlap_m(known: TrainingSet, x0: Tensor, batch: TokenBatch) -> float:
    """Sum over rooms that share a storey of how deep they reach into each other."""
    boxes = decoder_of(known).decode(x0, batch)
    outlines = footprints_of(boxes, batch)
    names = [kind.category for kind in known.vocabulary.kinds]
    total = 0.0
    for row in range(len(x0)):
        rooms = [i for i, k in enumerate(batch.kind[row].tolist()) if names[k] == "room"]
        for place, i in enumerate(rooms):
            for j in rooms[place + 1 :]:
                apart = (outlines.middle_m[row, i] - outlines.middle_m[row, j]).abs()
                shared = outlines.reach_m[row, i] + outlines.reach_m[row, j] - apart
                rise = (boxes.center_enu_m[row, i, 2] - boxes.center_enu_m[row, j, 2]).abs()
                height = (boxes.size_m[row, i, 2] + boxes.size_m[row, j, 2]) / 2 - rise
                is_kin = batch.parent[row, i] == batch.parent[row, j]
                if is_kin and height > 0.01:
                    total += max(0.0, float(shared.min()))
    return total


def n_too_small(known: TrainingSet, x0: Tensor, batch: TokenBatch) -> int:
    """Ground and rooms, square to their parents, that are shorter or narrower than there are."""
    size = decoder_of(known).decode(x0, batch).size_m
    tiles = {"lawn", "plaza", "parking_lot", "road", "sidewalk", "terrain", "water", "room"}
    count = 0
    for row, column in batch.mask.nonzero().tolist():
        kind = known.vocabulary.kinds[int(batch.kind[row, column])]
        if kind.category in tiles and not kind.is_site and kind.is_aligned:
            least = by_name()[kind.category]
            length, width, _ = size[row, column].tolist()
            count += length < least.length_m[0] - 0.01 or width < least.width_m[0] - 0.01
    return count


def test_scenes_of_the_corpus_stay_as_they_are(known: TrainingSet) -> None:
    batch = known.collator.examples(list(known.examples))
    moved = guidance(known).on_x0(batch.x0, batch, LAST)
    decode = decoder_of(known).decode
    first, second = decode(batch.x0, batch), decode(moved, batch)
    away = (first.center_enu_m - second.center_enu_m).norm(dim=-1)[batch.mask]
    assert float(away.median()) < 0.001
    # Rooms that are as thin a wall apart as others touch are drawn to that wall.
    assert float(away.max()) < 0.1


def test_rooms_that_reach_into_each_other_give_way(known: TrainingSet) -> None:
    batch = known.collator.examples(list(known.examples))
    x0 = shaken(batch, 0.15)
    before = border_overlap_m(known, x0, batch)
    after = border_overlap_m(known, guidance(known).on_x0(x0, batch, LAST), batch)
    assert before > 5.0
    # Those that are as small as any of the few here do not give way.
    assert after < 0.25 * before


def test_nothing_is_left_smaller_than_its_category_can_be(known: TrainingSet) -> None:
    batch = known.collator.examples(list(known.examples))
    x0 = shaken(batch, 0.3)
    x0[:, 1 : batch.n_coarse_slots, 5:7] -= 4.0
    assert n_too_small(known, x0, batch) >= 4
    assert n_too_small(known, guidance(known).on_x0(x0, batch, LAST), batch) == 0


def test_nothing_moves_early(known: TrainingSet) -> None:
    batch = known.collator.examples(list(known.examples))
    x0 = shaken(batch, 0.2)
    assert torch.equal(guidance(known).on_x0(x0, batch, FIRST), x0)


def test_given_tokens_keep_their_borders(known: TrainingSet) -> None:
    batch = known.collator.examples(list(known.examples))
    x0 = shaken(batch, 0.2)
    fixed = batch.mask.clone()
    fixed[:, batch.n_coarse_slots :] = False
    given = Moment(index=29, n_steps=30, time=0.03, alpha_bar=0.99, fixed=fixed)
    extents = slice(5, 7)
    moved = guidance(known).on_x0(x0, batch, given)
    torch.testing.assert_close(moved[..., extents], x0[..., extents], atol=1e-3, rtol=1e-3)
    assert not torch.equal(guidance(known).on_x0(x0, batch, LAST)[..., extents], x0[..., extents])


def test_what_lies_outside_comes_within_and_the_rest_stays(known: TrainingSet) -> None:
    batch = known.collator.examples(list(known.examples))
    x0 = batch.x0.clone()
    fine = batch.n_coarse_slots + 5
    x0[:, fine, 0] += 6.0
    boxes = decoder_of(known).decode(x0, batch)
    before = footprints_of(boxes, batch)
    none = torch.zeros_like(batch.mask)
    after = contained(before, boxes, batch, none)
    assert (before.middle_m[:, fine].abs() > before.parent_half_m[:, fine]).any()
    assert (after.middle_m[:, fine].abs() <= after.parent_half_m[:, fine]).all()
    others = batch.mask.clone()
    others[:, fine] = False
    shift = (after.middle_m - before.middle_m).norm(dim=-1)[others]
    assert float(shift.quantile(0.95)) == 0.0


def test_chain_applies_one_guidance_after_the_other(known: TrainingSet) -> None:
    batch = known.collator.examples(list(known.examples[:1]))
    part = guidance(known)
    x0 = shaken(batch, 0.2)
    twice = part.on_x0(part.on_x0(x0, batch, LAST), batch, LAST)
    assert torch.equal(GuidanceChain((part, part)).on_x0(x0, batch, LAST), twice)
    assert torch.equal(GuidanceChain((part,)).on_mean(x0, x0, batch, LAST), x0)


def test_configuration_out_of_range_says_what_is_valid() -> None:
    with pytest.raises(DiffusionError, match=r"borders\.least_share is 2, valid: 0\.1 to 1"):
        BordersCfg(least_share=2.0)
