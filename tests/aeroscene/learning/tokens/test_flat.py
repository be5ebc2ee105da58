from __future__ import annotations

import numpy as np
import pytest

from aeroscene.learning.paper.tokens import (
    N_FLAT_CHANNELS,
    encode_flat,
    flat_training_set,
    random_flat_symmetry,
    read_flat,
)
from aeroscene.learning.tokens.assembly import assemble
from aeroscene.learning.tokens.skeleton import Wish, token_order
from aeroscene.scene import Scene
from aeroscene.scene.catalogue import COARSE_COUNT


def test_flat_layout_keeps_boxes_and_categories(scenes: list[Scene]) -> None:
    flat = flat_training_set(scenes)
    for scene, example in zip(scenes, flat.examples, strict=True):
        skeleton, geometry = read_flat(
            example.x0,
            Wish.of(scene),
            flat.statistics,
            flat.vocabulary,
            np.random.default_rng(0),
        )
        order = token_order(scene)
        centers = np.array([obj.bbox.p for obj in order])
        np.testing.assert_allclose(geometry.center_enu_m[1:], centers, atol=1e-6)
        np.testing.assert_allclose(geometry.size_m[1:], [obj.bbox.s for obj in order], atol=0.02)
        found = flat.vocabulary.category_id[skeleton.kind_id[1:]]
        assert found.tolist() == [obj.category_id for obj in order]


def test_fine_objects_belong_to_the_nearest_coarse_one(scene_42: Scene) -> None:
    flat = flat_training_set([scene_42])
    skeleton, geometry = read_flat(
        flat.examples[0].x0,
        Wish.of(scene_42),
        flat.statistics,
        flat.vocabulary,
        np.random.default_rng(0),
    )
    n = skeleton.n_coarse
    for token in range(n, len(skeleton), 7):
        away = np.linalg.norm(geometry.center_enu_m[1:n] - geometry.center_enu_m[token], axis=1)
        assert away[skeleton.parent[token] - 1] == pytest.approx(away.min())
    assert (skeleton.parent[:n] == 0).all()


def test_statistics_bound_every_layout_however_it_is_turned(scenes: list[Scene]) -> None:
    flat, rng = flat_training_set(scenes), np.random.default_rng(2)
    known = flat.statistics
    for example in flat.examples:
        for _ in range(8):
            x0 = random_flat_symmetry(example, rng).x0
            assert (x0 >= known.low - 1e-9).all()
            assert (x0 <= known.high + 1e-9).all()
    assert known.high[2] == pytest.approx(max(e.x0[:, 2].max() for e in flat.examples))


def test_sampled_noise_still_makes_a_document(scene_42: Scene) -> None:
    flat = flat_training_set([scene_42])
    rng = np.random.default_rng(1)
    noise = rng.standard_normal((30, N_FLAT_CHANNELS))
    wish = Wish("outdoor", 10, 20, 5)
    skeleton, geometry = read_flat(noise, wish, flat.statistics, flat.vocabulary, rng)
    scene = assemble(skeleton, geometry, flat.vocabulary, scene_id="noise", seed=0, rng=rng)
    assert len(scene.objects) == 30
    n_coarse = sum(obj.category_id <= COARSE_COUNT for obj in scene.objects)
    assert n_coarse == skeleton.n_coarse - 1


def test_symmetries_keep_distances_and_unit_quaternions(scene_42: Scene) -> None:
    statistics = flat_training_set([scene_42]).statistics
    example = encode_flat(scene_42, Wish.of(scene_42), statistics=statistics)
    rng = np.random.default_rng(0)
    for _ in range(8):
        other = random_flat_symmetry(example, rng)
        first = np.linalg.norm(example.x0[:, None, :2] - example.x0[None, :, :2], axis=-1)
        second = np.linalg.norm(other.x0[:, None, :2] - other.x0[None, :, :2], axis=-1)
        np.testing.assert_allclose(first, second, atol=1e-9)
        np.testing.assert_allclose(np.linalg.norm(other.x0[:, 3:7], axis=1), 1.0, atol=1e-6)
