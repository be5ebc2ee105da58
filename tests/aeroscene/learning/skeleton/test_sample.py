from __future__ import annotations

from collections import Counter

import numpy as np
import pytest
import torch

from aeroscene.learning.skeleton.config import SkeletonError, SkeletonTrainingCfg
from aeroscene.learning.skeleton.sample import sample_skeletons
from aeroscene.learning.skeleton.train import TrainedSkeletonModel, train_skeleton
from aeroscene.learning.skeleton.tree import Tree
from aeroscene.learning.tokens.kinds import Kind, Vocabulary
from aeroscene.learning.tokens.skeleton import Skeleton, Wish
from tests.aeroscene.learning.skeleton.conftest import SMALL
from tests.aeroscene.learning.skeleton.toy import (
    CHAIR,
    HOUSE,
    LAWN,
    PAD,
    ROOF,
    ROOM,
    TABLE,
    VOCABULARY,
    describe,
    site,
    toy_corpus,
)

WISHES = [wish for _, wish in toy_corpus(24, seed=8)]


def sample_skeleton(model, wish, generator, coarse=None):
    return sample_skeletons(model, [wish], [generator], [coarse])[0]


def _rngs(n: int, seed: int = 0) -> list[np.random.Generator]:
    return [np.random.default_rng([seed, i]) for i in range(n)]


@pytest.fixture(name="drawn", scope="module")
def _drawn(trained: TrainedSkeletonModel) -> list[Skeleton]:
    return sample_skeletons(trained.model, WISHES, _rngs(len(WISHES)))


def test_counts_are_those_wished_for(drawn: list[Skeleton]):
    for skeleton, wish in zip(drawn, WISHES, strict=True):
        assert skeleton.n_coarse - 1 == wish.n_coarse
        assert len(skeleton) - skeleton.n_coarse == wish.n_fine


def test_order_is_that_of_skeletons(drawn: list[Skeleton]):
    for skeleton in drawn:
        assert (skeleton.parent[1:] < np.arange(1, len(skeleton))).all()
        assert (skeleton.parent[: skeleton.n_coarse] < skeleton.n_coarse).all()
        is_coarse = VOCABULARY.is_coarse[skeleton.kind_id]
        assert is_coarse.tolist() == [i < skeleton.n_coarse for i in range(len(skeleton))]


def test_there_is_one_start_pad(drawn: list[Skeleton]):
    assert all((skeleton.kind_id == PAD).sum() == 1 for skeleton in drawn)


def test_pairs_are_those_of_training(drawn: list[Skeleton]):
    known = {pair for skeleton, _ in toy_corpus(60) for pair in describe(skeleton)}
    assert {pair for skeleton in drawn for pair in describe(skeleton)} <= known


def test_every_house_has_one_roof_and_a_room(drawn: list[Skeleton]):
    for skeleton in drawn:
        for house in np.flatnonzero(skeleton.kind_id == HOUSE):
            children = Counter(skeleton.kind_id[skeleton.parent == house].tolist())
            assert children[ROOF] == 1
            assert children[ROOM] >= 1


def test_every_room_has_table_and_chair(drawn: list[Skeleton]):
    for skeleton in drawn:
        for room in np.flatnonzero(skeleton.kind_id == ROOM):
            children = set(skeleton.kind_id[skeleton.parent == room].tolist())
            assert children == {TABLE, CHAIR}


def test_the_same_seed_draws_the_same(trained: TrainedSkeletonModel):
    one, two = (sample_skeleton(trained.model, WISHES[0], _rngs(1)[0]) for _ in range(2))
    np.testing.assert_array_equal(one.kind_id, two.kind_id)
    np.testing.assert_array_equal(one.parent, two.parent)


def test_another_seed_draws_another(trained: TrainedSkeletonModel):
    drawn = {
        tuple(sample_skeleton(trained.model, WISHES[0], _rngs(1, seed)[0]).kind_id.tolist())
        for seed in range(6)
    }
    assert len(drawn) > 1


def test_a_batch_draws_what_each_draws_alone(trained: TrainedSkeletonModel, drawn: list[Skeleton]):
    for i in (0, 5, 17):
        alone = sample_skeleton(trained.model, WISHES[i], _rngs(len(WISHES))[i])
        np.testing.assert_array_equal(alone.kind_id, drawn[i].kind_id)
        np.testing.assert_array_equal(alone.parent, drawn[i].parent)


def test_a_coarse_part_is_kept(trained: TrainedSkeletonModel, drawn: list[Skeleton]):
    part = drawn[0]
    made = sample_skeleton(trained.model, WISHES[0], _rngs(1, 7)[0], coarse=part)
    n = part.n_coarse
    assert made.n_coarse == n
    np.testing.assert_array_equal(made.kind_id[:n], part.kind_id[:n])
    np.testing.assert_array_equal(made.parent[:n], part.parent[:n])
    assert len(made) - n == WISHES[0].n_fine


def test_a_coarse_part_deeper_than_training_is_kept(trained: TrainedSkeletonModel):
    tree = Tree(site())
    for depth, kind in ((1, LAWN), (2, LAWN), (3, LAWN), (4, HOUSE), (5, ROOM)):
        tree.add(depth, kind, is_coarse=True)
    made = sample_skeleton(
        trained.model, Wish("outdoor", 5, 8, 2), _rngs(1)[0], coarse=tree.skeleton()
    )
    assert made.depth[:6].tolist() == [0, 1, 2, 3, 4, 5]
    assert len(made) == 14


def test_more_fine_objects_than_anything_bears_are_not_forced(trained: TrainedSkeletonModel):
    wish = Wish("outdoor", 5, 500, 2)
    made = sample_skeleton(trained.model, wish, _rngs(1)[0])
    most = trained.model.grammar.most_quota[made.kind_id[: made.n_coarse]].sum()
    assert len(made) - made.n_coarse == most


def test_a_wish_for_nothing_is_a_bare_site(trained: TrainedSkeletonModel):
    made = sample_skeleton(trained.model, Wish("outdoor", 0, 0, 0), _rngs(1)[0])
    assert made.kind_id.tolist() == [1]


def test_lists_of_unequal_length_are_refused(trained: TrainedSkeletonModel):
    with pytest.raises(SkeletonError, match="2 wishes, 1 generators and 2 coarse parts"):
        sample_skeletons(trained.model, WISHES[:2], _rngs(1))


def test_foreign_categories_are_learned_without_coarse_objects():
    gizmo, gadget = (Kind(c, "indoor", "free", is_aligned=True) for c in ("gadget", "gizmo"))
    vocabulary = Vocabulary((*VOCABULARY.kinds[:3], gizmo, gadget), ((),) * 5, {})
    examples = []
    for n in range(4, 12):
        tree = Tree(site("indoor"))
        for i in range(n):
            tree.add(1, 3 + i % 2, is_coarse=False)
        examples.append((tree.skeleton(), Wish("indoor", 0, n, 0)))
    training = SkeletonTrainingCfg(batch=4, seconds=None, steps=3, looks=1)
    torch.manual_seed(0)
    model = train_skeleton(examples, vocabulary, _rngs(1)[0], SMALL, training).model
    made = sample_skeleton(model, Wish("indoor", 0, 9, 0), _rngs(1)[0])
    assert made.n_coarse == 1
    assert len(made) == 10
