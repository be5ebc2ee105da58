"""The prior of contents: its sentences, and what it draws."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest
import torch

from aeroscene.learning.paper.contents.config import ContentsCfg
from aeroscene.learning.paper.contents.lessons import ContentsLessons
from aeroscene.learning.paper.contents.model import ContentsModel
from aeroscene.learning.paper.contents.sentences import (
    Reading,
    allowed,
    bin_of,
    half_of,
    sentence_of,
)
from aeroscene.learning.paper.training_set import flat_training_set
from aeroscene.learning.training.contents_stage import contents_loss
from aeroscene.scene import Scene
from aeroscene.scene.catalogue import COARSE_COUNT

BOTH = pytest.mark.parametrize("has_regions", [False, True])


@BOTH
def test_sentences_are_read_as_what_was_said(scenes: list[Scene], has_regions: bool) -> None:
    data = flat_training_set(scenes, has_regions=has_regions)
    for number, layout in enumerate(data.examples):
        sentence = sentence_of(layout, data.statistics)
        reading = Reading(data.statistics)
        for token, place in zip(sentence.token.tolist(), sentence.place.tolist(), strict=True):
            assert not reading.is_done
            assert reading.place == place
            assert allowed(reading.step, place)[token]
            reading.take(token, 0.5)
        assert reading.is_done
        contents = reading.contents
        assert contents.category.tolist() == layout.category.tolist()
        assert contents.region.tolist() == layout.region.tolist()
        assert contents.n_coarse == layout.n_coarse
        assert contents.half_m == pytest.approx(layout.half_m, rel=0.1)
        if number % 2 == 0:
            batch = data.in_order(number, 1)
            assert contents.turn.tolist() == batch.turn[0][batch.mask[0]].tolist()


def test_bins_of_half_extents_are_read_back_within_a_tenth() -> None:
    for half_m in (0.6, 2.0, 17.0, 240.0):
        assert half_of(bin_of(half_m), 0.5) == pytest.approx(half_m, rel=0.1)
    assert bin_of(1e9) == bin_of(249.0)


@BOTH
def test_a_prior_that_has_learned_few_scenes_draws_them(
    scenes: list[Scene], has_regions: bool
) -> None:
    data = flat_training_set(scenes[:2], has_regions=has_regions)
    lessons = ContentsLessons(data)
    torch.manual_seed(0)
    model = ContentsModel(ContentsCfg(width=48, layers=1))
    optimiser = torch.optim.Adam(model.parameters(), lr=1e-2)
    batch, seen = lessons.in_order(0, 2), []
    for _ in range(160):
        loss = contents_loss(model, batch, torch.Generator())["total"]
        optimiser.zero_grad()
        loss.backward()
        optimiser.step()
        seen.append(float(loss.detach()))
    assert seen[-1] < 0.2 * seen[0]
    layout = data.examples[0]
    drawn = model.eval().draw(
        layout.wish,
        data.statistics,
        data.looks.is_known,
        torch.Generator().manual_seed(0),
    )
    assert len(drawn.category) == pytest.approx(len(layout.category), rel=0.3)
    shared = Counter(drawn.category.tolist()) & Counter(layout.category.tolist())
    assert shared.total() > 0.6 * len(layout.category)


def test_what_is_drawn_is_usable_and_coarse_objects_come_first(scenes: list[Scene]) -> None:
    data = flat_training_set(scenes, has_regions=True)
    torch.manual_seed(0)
    model = ContentsModel(ContentsCfg(width=16, layers=1)).eval()
    is_usable = data.looks.is_known
    for seed in range(4):
        generator = torch.Generator().manual_seed(seed)
        drawn = model.draw(data.examples[0].wish, data.statistics, is_usable, generator)
        assert is_usable[drawn.category].all()
        assert (drawn.category[: drawn.n_coarse] <= COARSE_COUNT).all()
        assert (drawn.category[drawn.n_coarse :] > COARSE_COUNT).all()
        held = drawn.region[drawn.region >= 0]
        assert data.statistics.holds[drawn.category[held]].all()
        again = model.draw(
            data.examples[0].wish, data.statistics, is_usable, torch.Generator().manual_seed(seed)
        )
        assert again.category.tolist() == drawn.category.tolist()


def test_padding_says_nothing(scenes: list[Scene]) -> None:
    lessons = ContentsLessons(flat_training_set(scenes))
    torch.manual_seed(0)
    model = ContentsModel(ContentsCfg(width=16, layers=1)).eval()
    with torch.no_grad():
        together = model(lessons.in_order(0, len(scenes)))
        alone = [float(model(lessons.in_order(n, 1))[0]) for n in range(len(scenes))]
    assert together.tolist() == pytest.approx(alone, rel=1e-4)
    assert np.isfinite(together.numpy()).all()
