from __future__ import annotations

import numpy as np
import pytest
import torch

from aeroscene.learning.tokens.channels import geometry_of
from aeroscene.learning.tokens.codec import CodecCfg, quarter_turns
from aeroscene.learning.tokens.decode import TreeDecoder
from aeroscene.learning.tokens.examples import mirrored, quarter_turned
from aeroscene.learning.tokens.training_set import TrainingSet, training_set
from aeroscene.scene import Scene
from tests.aeroscene.learning.tokens.decoding import decoded

CODECS = (
    CodecCfg(frame="parent"),
    CodecCfg(frame="scene"),
    CodecCfg(yaw="angle"),
    CodecCfg(size="linear"),
    CodecCfg(frame="scene", yaw="angle", size="linear"),
)


@pytest.fixture(params=CODECS, ids=lambda codec: f"{codec.frame}-{codec.yaw}-{codec.size}")
def known(request: pytest.FixtureRequest, scenes: list[Scene]) -> TrainingSet:
    return training_set(scenes[:5], request.param)


def test_boxes_come_back_where_they_were(known: TrainingSet, scenes: list[Scene]) -> None:
    for scene, example in zip(scenes, known.examples, strict=False):
        truth, found = geometry_of(scene), decoded(known, example)
        assert np.abs(found.center_enu_m - truth.center_enu_m)[1:].max() < 0.03
        assert np.abs(found.size_m - truth.size_m)[1:].max() < 0.03
        assert np.abs(np.exp(1j * found.yaw_rad) - np.exp(1j * truth.yaw_rad)).max() < 0.01


def test_symmetries_turn_and_mirror_the_scene(known: TrainingSet) -> None:
    codec = known.statistics.codec
    for example in known.examples:
        first, turned = decoded(known, example), decoded(known, quarter_turned(example, codec))
        x, y = first.center_enu_m[:, :2].T
        np.testing.assert_allclose(turned.center_enu_m[:, :2], np.stack([-y, x], 1), atol=1e-3)
        difference = np.exp(1j * (turned.yaw_rad - first.yaw_rad))[1:]
        np.testing.assert_allclose(difference, 1j, atol=1e-3)
        seen = decoded(known, mirrored(example))
        np.testing.assert_allclose(seen.center_enu_m, first.center_enu_m * (1, -1, 1), atol=1e-3)


def test_turned_and_mirrored_scenes_stay_within_the_bounds(known: TrainingSet) -> None:
    decoder = TreeDecoder(known.vocabulary, known.statistics)
    rng = np.random.default_rng(3)
    for _ in range(3):
        batch = known.sample_batch(4, rng)
        assert batch.x0 is not None
        low, high = decoder.bounds(batch)
        beyond = torch.maximum(batch.x0 - high, low - batch.x0) * batch.mask[..., None]
        assert float(beyond.max()) < 1e-4


def test_angles_are_counted_in_quarters_from_minus_two() -> None:
    yaw = np.radians([0.0, 90.0, 180.0, -180.0, 269.0, 360.0])
    np.testing.assert_allclose(quarter_turns(yaw), [0, 1, -2, -2, -91 / 90, 0], atol=1e-12)
