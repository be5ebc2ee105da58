from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from aeroscene.learning.skeleton.quotas import Quotas


@settings(max_examples=50, deadline=None)
@given(st.integers(0, 10_000), st.integers(0, 30))
def test_the_rest_is_shared_out_as_far_as_there_is_room(seed: int, rest: int):
    rng = np.random.default_rng(seed)
    is_bearer = rng.random((1, 5)) < 0.7
    most = rng.integers(1, 6, (1, 5)) * is_bearer
    quotas = Quotas(np.zeros_like(most), most, 6)
    bearers = np.flatnonzero(is_bearer)
    quotas.note(np.zeros_like(bearers), bearers, rng.normal(size=(len(bearers), 6)))
    quota = rng.integers(0, most[0] + 1)
    extra = quotas.share_rest(0, quota, rest)
    assert extra.sum() == min(rest, (most - quota).sum())
    assert (extra >= 0).all()
    assert (quota + extra <= most).all()


def test_the_rest_goes_where_it_surprises_least():
    quotas = Quotas(np.zeros((1, 3), dtype=int), np.array([[3, 0, 3]]), 4)
    logits = np.log([[0.7, 0.1, 0.1, 0.1], [0.2, 0.3, 0.3, 0.2]])
    quotas.note(np.zeros(2, dtype=int), np.array([0, 2]), logits)
    assert quotas.share_rest(0, np.array([0, 0, 1]), 2).tolist() == [0, 0, 2]


@settings(max_examples=50, deadline=None)
@given(st.integers(0, 10_000))
def test_everyone_gets_what_it_needs_where_there_is_enough(seed: int):
    rng = np.random.default_rng(seed)
    least = rng.integers(0, 4, (1, 6))
    quotas = Quotas(least, least + rng.integers(0, 4, (1, 6)), 8)
    left = np.array([least.sum() + rng.integers(5)])
    row = np.array([0])
    for place in range(6):
        allowed = np.flatnonzero(quotas.allowed(row, np.array([place]), left)[0])
        assert allowed[0] == least[0, place]
        left -= allowed[-1]
    assert left >= 0


def test_where_there_is_too_little_the_first_get_it():
    quotas = Quotas(np.array([[2, 2]]), np.array([[3, 3]]), 5)
    row = np.array([0])
    assert np.flatnonzero(quotas.allowed(row, row, np.array([1]))[0]).tolist() == [1]
