from __future__ import annotations

import numpy as np
import pytest

from aeroscene.skeleton.novelty import skeleton_report
from aeroscene.skeleton.tree import Tree
from aeroscene.tokens.skeleton import Skeleton
from tests.aeroscene.skeleton.toy import HOUSE, LAWN, ROOF, ROOM, VOCABULARY, site, toy_corpus

CORPUS = [skeleton for skeleton, _ in toy_corpus(40)]


def _coarse(*steps: tuple[int, int]) -> Skeleton:
    tree = Tree(site())
    for depth, kind in steps:
        tree.add(depth, kind, is_coarse=True)
    return tree.skeleton()


def test_the_training_itself_is_all_known():
    report = skeleton_report(CORPUS, CORPUS, CORPUS, VOCABULARY)
    assert report.known_multisets == report.known_trees == report.known_subtrees == 1
    assert report.unseen_pairs == 0
    assert report.kl_categories_bits == pytest.approx(0)
    assert report.kl_pairs_bits == pytest.approx(0)


def test_siblings_in_another_order_are_the_same_tree():
    one = _coarse((1, HOUSE), (2, ROOF), (2, ROOM), (1, LAWN))
    other = _coarse((1, LAWN), (1, HOUSE), (2, ROOM), (2, ROOF))
    assert skeleton_report([one], [other], [one], VOCABULARY).known_trees == 1


def test_the_same_kinds_under_other_parents_are_another_tree():
    one = _coarse((1, HOUSE), (2, ROOF), (1, LAWN))
    other = _coarse((1, HOUSE), (1, LAWN), (2, ROOF))
    report = skeleton_report([one], [other], [one], VOCABULARY)
    assert report.known_multisets == 1
    assert report.known_trees == 0
    assert report.unseen_pairs == pytest.approx(1 / 3)


def test_a_large_part_that_is_copied_is_found():
    tower = ((1, HOUSE), *[(2, ROOM)] * 9)
    one, other = _coarse(*tower, (1, LAWN)), _coarse(*tower)
    report = skeleton_report([one], [other], [one], VOCABULARY)
    assert report.known_subtrees == 1
    assert report.known_trees == 0


def test_divergence_is_that_of_the_smoothed_shares():
    many, few = _coarse(*[(1, LAWN)] * 3, (1, HOUSE)), _coarse((1, LAWN), (1, HOUSE))
    p, q = np.array([3.5, 1.5]) / 5, np.array([1.5, 1.5]) / 3
    report = skeleton_report([few], [few], [many], VOCABULARY)
    assert report.kl_categories_bits == pytest.approx((p * np.log2(p / q)).sum())
