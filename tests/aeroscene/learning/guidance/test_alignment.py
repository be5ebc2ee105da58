"""Siblings in line: by hand, and in scenes of the corpus that are off by a little."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import torch
from torch import Tensor

from aeroscene.learning.diffusion.sampling import Moment
from aeroscene.learning.diffusion.schedule import DiffusionError
from aeroscene.learning.guidance.alignment import AlignmentCfg, AlignmentGuidance, in_line
from aeroscene.learning.tokens.batch import TokenBatch
from aeroscene.learning.tokens.boxes import footprints_of
from aeroscene.learning.tokens.decode import TreeDecoder
from aeroscene.learning.tokens.training_set import TrainingSet, training_set
from tests.aeroscene.conftest import cached_scene

LAST = Moment(index=29, n_steps=30, time=0.03, alpha_bar=0.99, fixed=None)
FIRST = Moment(index=0, n_steps=30, time=1.0, alpha_bar=0.0, fixed=None)
NEAR = AlignmentCfg(most_m=0.3, most_share=1.0)


@pytest.fixture(scope="module")
def known() -> TrainingSet:
    """An outdoor, a mixed and two indoor scenes."""
    return training_set([cached_scene(index) for index in (7, 42, 311, 320)])


def all_tokens(known: TrainingSet) -> tuple[TokenBatch, Tensor, Tensor]:
    """All scenes with their channels, and where one of these is free."""
    batch = known.collator.examples(list(known.examples))
    assert batch.x0 is not None
    assert batch.weight is not None
    return batch, batch.x0, batch.weight > 0


def guidance(known: TrainingSet, cfg: AlignmentCfg | None = None) -> AlignmentGuidance:
    return AlignmentGuidance(TreeDecoder(known.vocabulary, known.statistics), known.vocabulary, cfg)


def middles(known: TrainingSet, x0: Tensor, batch: TokenBatch) -> Tensor:
    boxes = TreeDecoder(known.vocabulary, known.statistics).decode(x0, batch)
    return footprints_of(boxes, batch).middle_m


def aligned(
    middle: list[tuple[float, float]],
    *,
    fixed: tuple[int, ...] = (),
    strangers: tuple[int, ...] = (),
    cfg: AlignmentCfg = NEAR,
) -> np.ndarray:
    """Metre-wide boxes in line; strangers have no habit."""
    places = np.array(middle)
    n = len(places)
    may = ~np.isin(np.arange(n), strangers)
    is_fixed = np.isin(np.arange(n), fixed)
    return in_line(places, np.full((n, 2), 0.5), is_fixed, np.outer(may, may), cfg)


def test_row_comes_in_line_and_keeps_its_spacing() -> None:
    moved = aligned([(0.0, 0.1), (1.5, -0.1), (3.1, 0.03)])
    np.testing.assert_allclose(moved[:, 1], 0.01, atol=1e-9)
    np.testing.assert_array_equal(moved[:, 0], [0.0, 1.5, 3.1])


def test_grid_comes_in_line_along_both_axes() -> None:
    moved = aligned([(0.0, 0.0), (2.0, 0.1), (0.1, 2.0), (2.1, 2.1)])
    np.testing.assert_allclose(moved, [(0.05, 0.05), (2.05, 0.05), (0.05, 2.05), (2.05, 2.05)])


def test_far_off_the_line_stays() -> None:
    places = [(0.0, 0.0), (1.5, 0.31)]
    np.testing.assert_array_equal(aligned(places), places)
    small = AlignmentCfg(most_share=0.2)
    np.testing.assert_array_equal(aligned([(0.0, 0.0), (1.5, 0.21)], cfg=small)[:, 1], [0, 0.21])


def test_many_small_steps_do_not_make_one_line() -> None:
    moved = aligned([(1.5 * i, 0.2 * i) for i in range(8)])
    assert len(np.unique(moved[:, 1])) >= 4
    assert np.abs(moved[:, 1] - 0.2 * np.arange(8)).max() <= 0.3


def test_far_along_the_line_and_on_one_another_stay() -> None:
    apart, stacked = [(0.0, 0.0), (6.5, 0.1)], [(0.0, 0.0), (0.3, 0.1)]
    np.testing.assert_array_equal(aligned(apart), apart)
    np.testing.assert_array_equal(aligned(stacked), stacked)


def test_without_the_habit_nothing_moves() -> None:
    moved = aligned([(0.0, 0.1), (1.5, 0.0), (3.0, 0.1)], strangers=(1,))
    np.testing.assert_array_equal(moved[:, 1], [0.1, 0.0, 0.1])


def test_given_ones_stay_and_the_others_come_to_them() -> None:
    moved = aligned([(0.0, 0.1), (1.5, 0.0)], fixed=(1,))
    np.testing.assert_allclose(moved[:, 1], 0.0, atol=1e-6)
    assert moved[1, 1] == 0.0


def test_scenes_of_the_corpus_hardly_move(known: TrainingSet) -> None:
    batch, x0, _ = all_tokens(known)
    moved = guidance(known).on_x0(x0, batch, LAST)
    away = (middles(known, moved, batch) - middles(known, x0, batch)).norm(dim=-1)
    # What by chance is as near a line as blurred ones are comes to it, too.
    assert float((away[batch.mask] > 0.01).float().mean()) < 0.12


def test_blurred_scenes_come_back_in_line(known: TrainingSet) -> None:
    batch, x0, is_free = all_tokens(known)
    is_fine = torch.arange(batch.mask.shape[1]) >= batch.n_coarse_slots
    noise = torch.randn(x0.shape, generator=torch.Generator().manual_seed(0))
    noise[..., 2:] = 0
    blurred = x0 + 0.03 * noise * is_free * is_fine[:, None]
    moved = guidance(known).on_x0(blurred, batch, LAST)
    shares = [in_line_share(known, each, batch) for each in (x0, blurred, moved)]
    assert shares[1] < 0.2 * shares[0]
    assert shares[2] > 0.7 * shares[0]


def in_line_share(known: TrainingSet, x0: Tensor, batch: TokenBatch) -> float:
    """Of the pairs of siblings of one kind, how many are within a centimetre of a line."""
    middle = middles(known, x0, batch)
    apart = (middle[:, :, None] - middle[:, None]).abs().amin(dim=-1)
    twins = (batch.kind[:, :, None] == batch.kind[:, None]) & batch.mask[:, :, None]
    twins &= (batch.parent[:, :, None] == batch.parent[:, None]) & batch.mask[:, None]
    twins &= torch.arange(batch.mask.shape[1]) >= batch.n_coarse_slots
    return float((apart[twins.triu(1)] < 0.01).float().mean())


def test_nothing_moves_early(known: TrainingSet) -> None:
    batch, x0, _ = all_tokens(known)
    assert torch.equal(guidance(known).on_x0(x0, batch, FIRST), x0)
    always = guidance(known, AlignmentCfg(late_share=1.0))
    assert not torch.equal(always.on_x0(x0, batch, FIRST), x0)


def test_given_tokens_of_a_scene_stay(known: TrainingSet) -> None:
    batch, x0, _ = all_tokens(known)
    given = replace(LAST, fixed=batch.mask)
    moved = guidance(known).on_x0(x0, batch, given)
    torch.testing.assert_close(moved, x0, atol=1e-4, rtol=1e-4)


def test_configuration_out_of_range_says_what_is_valid() -> None:
    with pytest.raises(DiffusionError, match=r"alignment\.most_share is 2, valid: 0 to 1"):
        AlignmentCfg(most_share=2.0)
