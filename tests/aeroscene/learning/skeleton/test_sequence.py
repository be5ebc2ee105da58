from __future__ import annotations

import numpy as np

from aeroscene.learning.skeleton.sequence import coarse_parts, wish_numbers
from aeroscene.learning.tokens.skeleton import Wish
from tests.aeroscene.learning.skeleton.test_grammar import GRAMMAR
from tests.aeroscene.learning.skeleton.toy import LAWN, ROOM, site, toy_skeleton


def test_wishes_differ_in_every_number():
    base = Wish("mixed", 30, 100, 50)
    others = [
        Wish("indoor", 30, 100, 50),
        Wish("mixed", 31, 100, 50),
        Wish("mixed", 30, 101, 50),
        Wish("mixed", 30, 100, 51),
    ]
    numbers = wish_numbers([base, *others])
    assert (np.abs(numbers[1:] - numbers[0]).max(axis=1) > 1e-3).all()
    assert np.abs(numbers).max() < 3


def test_short_coarse_parts_are_padded_with_nothing_that_bears():
    skeletons = [site(), toy_skeleton(np.random.default_rng(0))]
    coarse = coarse_parts(skeletons, GRAMMAR.n_kinds)
    assert coarse.length.tolist() == [1, skeletons[1].n_coarse]
    may_bear = GRAMMAR.bears_fine[coarse.kind.numpy()]
    assert not may_bear[0].any()
    assert set(coarse.kind.numpy()[may_bear].tolist()) == {LAWN, ROOM}
