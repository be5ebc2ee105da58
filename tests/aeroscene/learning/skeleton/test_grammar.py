from __future__ import annotations

import numpy as np

from aeroscene.learning.skeleton.grammar import learn_grammar, owners
from aeroscene.learning.skeleton.tree import Tree
from aeroscene.learning.tokens.kinds import Kind, Vocabulary
from tests.aeroscene.learning.skeleton.toy import (
    CHAIR,
    CUP,
    HOUSE,
    LAWN,
    PAD,
    ROOF,
    ROOM,
    TABLE,
    TREE,
    VOCABULARY,
    site,
    toy_corpus,
    toy_skeleton,
)

GRAMMAR = learn_grammar(VOCABULARY, [skeleton for skeleton, _ in toy_corpus(60)])


def test_pairs_are_those_of_the_skeletons():
    expected = {
        (1, LAWN),
        (1, HOUSE),
        (HOUSE, ROOF),
        (HOUSE, ROOM),
        (LAWN, PAD),
        (LAWN, TREE),
        (ROOM, TABLE),
        (ROOM, CHAIR),
        (TABLE, CUP),
    }
    assert set(zip(*np.nonzero(GRAMMAR.most), strict=True)) == expected


def test_a_house_has_at_most_one_roof_but_any_number_of_rooms():
    assert GRAMMAR.cap[HOUSE, ROOF] == 1
    assert GRAMMAR.cap[HOUSE, ROOM] > 1000
    assert GRAMMAR.cap[HOUSE, CHAIR] == 0
    assert not GRAMMAR.cap[-1].any()


def test_bearers_are_told_apart_by_what_they_bear():
    assert np.flatnonzero(GRAMMAR.bears_fine).tolist() == [LAWN, ROOM, TABLE]
    assert np.flatnonzero(GRAMMAR.bears_start).tolist() == [LAWN]


def test_quotas_are_counted_for_each_kind():
    assert GRAMMAR.most_quota[LAWN] == GRAMMAR.max_quota == 5
    assert GRAMMAR.most_quota[ROOM] == 4
    assert 2 < GRAMMAR.usual_quota[ROOM] < 4
    assert GRAMMAR.usual_quota[HOUSE] == 0


def test_levels_are_the_depths_that_occur():
    assert (GRAMMAR.coarse_levels, GRAMMAR.fine_levels) == (3, 3)


def test_owner_is_the_coarse_object_above():
    skeleton = toy_skeleton(np.random.default_rng(3))
    for i, owner in enumerate(owners(skeleton).tolist()):
        above = i
        while above >= skeleton.n_coarse:
            above = int(skeleton.parent[above])
        assert owner == above


def test_foreign_categories_are_all_fine_objects_of_the_site():
    kinds = (*VOCABULARY.kinds[:3], Kind("gizmo", "indoor", "free", is_aligned=True))
    tree = Tree(site("indoor"))
    for depth in (1, 2, 2, 1):
        tree.add(depth, 3, is_coarse=False)
    grammar = learn_grammar(Vocabulary(kinds, ((),) * 4, {}), [tree.skeleton()])
    assert np.flatnonzero(grammar.bears_fine).tolist() == [0, 3]
    assert grammar.max_quota == 4
    assert not grammar.is_start.any()
