from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from aeroscene.learning.skeleton.bucket import N_BUCKETS, bucket
from aeroscene.learning.skeleton.path import Paths
from tests.aeroscene.learning.skeleton.toy import toy_skeleton


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10_000))
def test_siblings_are_those_placed_before_under_the_same_parent(seed: int):
    skeleton = toy_skeleton(np.random.default_rng(seed))
    paths = Paths(2, 4, 12)
    row = np.array([1])
    paths.restart(row, skeleton.kind_id[:1])
    for i in range(1, skeleton.n_coarse):
        before = np.flatnonzero(skeleton.parent[1:i] == skeleton.parent[i]) + 1
        depth = skeleton.depth[i : i + 1]
        siblings = paths.siblings(row, depth)
        kinds = skeleton.kind_id[before]
        assert siblings.parent[0] == skeleton.kind_id[skeleton.parent[i]]
        assert siblings.last[0] == (kinds[-1] if len(kinds) else paths.none)
        assert siblings.n_siblings[0] == bucket(np.array(len(kinds)))
        np.testing.assert_array_equal(siblings.bag[0], np.bincount(kinds, minlength=12))
        paths.place(row, depth, skeleton.kind_id[i : i + 1])
    assert (paths.kind[0] == paths.none).all()


def test_turning_up_forgets_what_lay_below():
    paths = Paths(1, 4, 12)
    row = np.array([0])
    paths.restart(row, np.array([1]))
    for depth, kind in ((1, 3), (2, 6), (1, 4)):
        paths.place(row, np.array([depth]), np.array([kind]))
    assert paths.kind[0].tolist() == [1, 4, 12, 12]
    assert paths.n_children[0].tolist() == [2, 0, 0, 0]
    assert not paths.bag[0, 1].any()


@pytest.mark.parametrize("count", [0, 1, 11, 12, 40, 255, 10_000])
def test_buckets_are_exact_where_small_and_bounded_where_large(count: int):
    found = bucket(np.array(count))
    assert found == count if count < 12 else 12 <= found < N_BUCKETS


def test_buckets_never_fall():
    assert (np.diff(bucket(np.arange(300))) >= 0).all()
