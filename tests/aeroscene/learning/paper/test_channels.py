"""Channels of layouts: standardised by category, and read back as the same boxes."""

from __future__ import annotations

import numpy as np
import pytest
import torch

from aeroscene.learning.paper.channels import N_GEOMETRY
from aeroscene.learning.paper.guidance.layout import FlatReader
from aeroscene.learning.paper.layouts import IS_TWO_SIDED, NO_REGION
from aeroscene.learning.paper.training_set import COARSE_PASS_SHARE, flat_training_set
from aeroscene.scene import Scene

BOTH = pytest.mark.parametrize("has_regions", [False, True])


@BOTH
def test_layouts_are_read_back_as_the_boxes_that_were_written(
    scenes: list[Scene], has_regions: bool
) -> None:
    data = flat_training_set(scenes, has_regions=has_regions)
    # With regions every other scene shows all its objects.
    for number in range(0, len(scenes), 2):
        batch = data.in_order(number, 1)
        boxes = FlatReader(data.statistics)(batch.x0.double(), batch)
        layout = data.examples[number]
        there = batch.mask[0]
        np.testing.assert_allclose(boxes.center_enu_m[0][there], layout.center_enu_m, atol=2e-3)
        np.testing.assert_allclose(boxes.size_m[0][there], layout.size_m, rtol=1e-4, atol=1e-4)
        yaw = np.column_stack([np.cos(layout.yaw_rad), np.sin(layout.yaw_rad)])
        # Half a turn of what looks the same after it is none.
        found = boxes.heading[0][there].numpy()
        flip = IS_TWO_SIDED[layout.category] & ((found * yaw).sum(axis=1) < 0)
        np.testing.assert_allclose(np.where(flip[:, None], -found, found), yaw, atol=1e-4)
        assert boxes.category[0][there].tolist() == layout.category.tolist()
        assert int(boxes.is_coarse.sum()) == layout.n_coarse


@BOTH
def test_channels_have_the_mean_and_variance_that_the_statistics_say(
    scenes: list[Scene], has_regions: bool
) -> None:
    data = flat_training_set(scenes, has_regions=has_regions)
    chair = np.bincount(np.concatenate([each.category for each in data.examples])).argmax()
    rows = [
        batch.x0[0][batch.mask[0] & (batch.kind[0] == chair)].numpy()
        for batch in (data.in_order(n, 1) for n in range(0, len(scenes), 2))
    ] + [
        batch.x0[0][batch.mask[0] & (batch.kind[0] == chair)].numpy()
        for batch in (
            data.with_examples(data.examples[1:]).in_order(n, 1)
            for n in range(0, len(scenes) - 1, 2)
        )
    ]
    found = np.concatenate(rows)
    variance = data.statistics.variance[chair]
    sizes = slice(7, N_GEOMETRY)
    assert found[:, sizes].mean(axis=0) == pytest.approx(np.zeros(3), abs=1e-4)
    assert found[:, sizes].var(axis=0) == pytest.approx(variance[sizes], rel=1e-3)
    places = (found[:, :2] ** 2).mean()
    assert places == pytest.approx(variance[0], rel=1e-3)


def test_a_coarse_pass_shows_coarse_objects_alone_and_the_fine_pass_gives_them(
    scenes: list[Scene],
) -> None:
    data = flat_training_set(scenes, has_regions=True)
    rng = np.random.default_rng(0)
    batches = [data.sample_batch(3, rng) for _ in range(40)]
    for batch in batches:
        coarse = torch.arange(batch.mask.shape[1]) < batch.n_coarse_slots
        gives = bool(batch.given.any())
        assert (batch.given == (batch.mask & coarse & gives)).all()
        assert gives or not batch.mask[:, ~coarse].any()
        # What is given is not learned; what is learned is noised.
        assert (batch.weight[batch.given] == 0).all()
        assert (batch.weight[batch.mask & ~batch.given][:, :2] > 0).all()
    share = np.mean([bool(batch.given.any()) for batch in batches])
    assert share == pytest.approx(1 - COARSE_PASS_SHARE, abs=0.2)


def test_fine_objects_stand_in_the_frame_of_their_region(scenes: list[Scene]) -> None:
    data = flat_training_set(scenes, has_regions=True)
    for number in range(0, len(scenes), 2):
        layout, batch = data.examples[number], data.in_order(number, 1)
        frame = batch.frame[0][batch.mask[0]].numpy()
        inside = layout.region != NO_REGION
        region = layout.region[inside]
        np.testing.assert_allclose(frame[inside, :2], layout.center_enu_m[region, :2], atol=1e-4)
        np.testing.assert_allclose(frame[inside, 3], np.cos(layout.yaw_rad[region]), atol=1e-5)
        np.testing.assert_allclose(
            frame[~inside, 5:], np.tile(layout.half_m, (sum(~inside), 1)), rtol=1e-5
        )


def test_batches_hold_scenes_of_about_as_many_objects(scenes: list[Scene]) -> None:
    data = flat_training_set(scenes * 24)
    share = [
        float(data.sample_batch(4, np.random.default_rng(seed)).mask.float().mean())
        for seed in range(8)
    ]
    assert np.mean(share) > 0.8


def test_encoder_makes_the_examples_again(scenes: list[Scene]) -> None:
    for has_regions in (False, True):
        data = flat_training_set(scenes, has_regions=has_regions)
        again = data.encoder(scenes[0], data.examples[0].wish)
        assert again.category.tolist() == data.examples[0].category.tolist()
        assert again.region.tolist() == data.examples[0].region.tolist()
