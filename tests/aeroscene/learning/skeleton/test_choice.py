from __future__ import annotations

import numpy as np
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

from aeroscene.learning.skeleton.choice import Chooser, allowed_children
from aeroscene.learning.skeleton.path import Paths
from tests.aeroscene.learning.skeleton.test_grammar import GRAMMAR
from tests.aeroscene.learning.skeleton.toy import CHAIR, HOUSE, LAWN, ROOF, ROOM, VOCABULARY

ROW = np.array([0])


def _draws(n: int, logits: list[float], allowed: list[bool]) -> np.ndarray:
    chooser = Chooser([np.random.default_rng(i) for i in range(n)])
    rows = np.arange(n)
    return chooser.choose(rows, torch.tensor([logits] * n), np.array([allowed] * n))


def test_choices_come_as_often_as_their_probabilities():
    draws = _draws(4000, [0.0, np.log(3.0), 5.0], [True, True, False])
    assert abs((draws == 1).mean() - 0.75) < 0.03
    assert 2 not in draws


@settings(max_examples=50, deadline=None)
@given(st.integers(0, 10_000), st.integers(1, 6))
def test_only_what_is_allowed_is_chosen(seed: int, n: int):
    rng = np.random.default_rng(seed)
    allowed = rng.random(n) < 0.5
    allowed[rng.integers(n)] = True
    draws = _draws(20, rng.normal(0, 30, n).tolist(), allowed.tolist())
    assert allowed[draws].all()


def test_a_row_draws_the_same_whatever_the_others():
    logits, allowed = torch.randn(3, 5), np.ones((3, 5), dtype=bool)
    together = Chooser([np.random.default_rng(i) for i in range(3)])
    alone = Chooser([np.random.default_rng(i) for i in range(3)])
    rows = np.arange(3)
    expected = [int(alone.choose(rows[i : i + 1], logits[i : i + 1], allowed[:1])[0]) for i in rows]
    assert together.choose(rows, logits, allowed).tolist() == expected


def _paths(*steps: tuple[int, int]) -> Paths:
    paths = Paths(1, 3, VOCABULARY.n_kinds)
    paths.restart(ROW, np.array([1]))
    for depth, kind in steps:
        paths.place(ROW, np.array([depth]), np.array([kind]))
    return paths


def _allowed(paths: Paths, wanted: np.ndarray, n_left: int = 9) -> np.ndarray:
    needs = GRAMMAR.coarse_needs
    return allowed_children(GRAMMAR, paths, ROW, wanted[None], needs, np.array([n_left]))[0]


def test_children_are_of_kinds_that_the_parent_had_in_training():
    allowed = _allowed(_paths((1, LAWN), (1, HOUSE)), GRAMMAR.is_coarse)
    assert not allowed[0].any()
    assert np.flatnonzero(allowed[1]).tolist() == [ROOF, ROOM]


def test_a_second_roof_is_not_allowed():
    allowed = _allowed(_paths((1, LAWN), (1, HOUSE), (2, ROOF)), GRAMMAR.is_coarse)
    assert np.flatnonzero(allowed[1]).tolist() == [ROOM]


def test_where_nothing_fits_the_root_takes_what_is_wanted():
    wanted = np.arange(VOCABULARY.n_kinds) == CHAIR
    allowed = _allowed(_paths((1, LAWN)), wanted)
    assert np.flatnonzero(allowed[0]).tolist() == [CHAIR]
    assert not allowed[1].any()
