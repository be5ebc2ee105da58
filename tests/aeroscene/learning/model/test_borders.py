"""Borders of boxes as the network sees them."""

from __future__ import annotations

import numpy as np
import pytest
import torch

from aeroscene.corpus.curation import curate_scene
from aeroscene.learning.model.borders import N_BORDER_FEATURES, border_features
from aeroscene.learning.tokens.batch import slots_of
from aeroscene.learning.tokens.decode import TreeDecoder
from aeroscene.learning.tokens.training_set import TrainingSet, training_set


@pytest.fixture(scope="module")
def known() -> TrainingSet:
    return training_set([curate_scene(311)])


def test_rooms_of_a_building_share_borders_in_its_frame(known: TrainingSet) -> None:
    batch = known.collator.examples(list(known.examples))
    boxes = TreeDecoder(known.vocabulary, known.statistics).decode(batch.x0, batch)
    features = border_features(boxes, batch)
    assert features.shape[-1] == N_BORDER_FEATURES
    assert torch.isfinite(features).all()
    skeleton = known.examples[0].skeleton
    names = np.array([known.vocabulary.kinds[k].category for k in skeleton.kind_id])
    slots = slots_of(skeleton, batch)
    roof = slots[names == "roof"][0]
    # A roof reaches from border to border of its building.
    torch.testing.assert_close(
        features[0, roof, :4], torch.tensor([-1.0, -1.0, 1.0, 1.0]), atol=0.02, rtol=0
    )
    rooms = features[0, slots[names == "room"]][:, :4]
    assert (rooms[:, :2] < rooms[:, 2:]).all()
    assert rooms.abs().max() <= 1.0


def test_noise_gives_finite_features(known: TrainingSet) -> None:
    batch = known.collator.examples(list(known.examples))
    noise = 30 * torch.randn(batch.x0.shape, generator=torch.Generator().manual_seed(0))
    boxes = TreeDecoder(known.vocabulary, known.statistics).decode(noise, batch)
    assert torch.isfinite(border_features(boxes, batch)).all()
