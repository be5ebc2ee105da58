from __future__ import annotations

import numpy as np

from aeroscene.learning.skeleton.path import Paths
from tests.aeroscene.learning.skeleton.test_grammar import GRAMMAR
from tests.aeroscene.learning.skeleton.toy import (
    CHAIR,
    HOUSE,
    LAWN,
    PAD,
    ROOF,
    ROOM,
    TABLE,
    TREE,
    VOCABULARY,
)

ROW = np.array([0])


def _paths(*steps: tuple[int, int], root: int = 1, levels: int = 3) -> Paths:
    paths = Paths(1, levels, VOCABULARY.n_kinds)
    paths.restart(ROW, np.array([root]))
    for depth, kind in steps:
        paths.place(ROW, np.array([depth]), np.array([kind]))
    return paths


def _affordable(paths: Paths, n_left: int, *, is_coarse: bool = True) -> np.ndarray:
    needs = GRAMMAR.coarse_needs if is_coarse else GRAMMAR.fine_needs
    return needs.affordable(paths, ROW, np.array([n_left]))[0]


def test_needs_are_what_every_object_of_a_kind_has():
    assert GRAMMAR.coarse_needs.least[HOUSE] == 2
    assert GRAMMAR.coarse_needs.least[ROOM] == 0
    assert GRAMMAR.fine_needs.least[ROOM] == 2
    # The site needs a lawn and a house with roof and room.
    assert GRAMMAR.coarse_needs.least[1] == 4


def test_a_house_without_a_roof_is_not_left():
    ok = _affordable(_paths((1, LAWN), (1, HOUSE), (2, ROOM)), 5)
    assert not ok[0].any()
    assert ok[1, ROOF]
    assert ok[1, ROOM]


def test_a_house_with_all_it_needs_may_be_left():
    ok = _affordable(_paths((1, LAWN), (1, HOUSE), (2, ROOM), (2, ROOF)), 5)
    assert ok[0, HOUSE]
    assert ok[0, LAWN]


def test_the_last_object_is_the_roof_that_is_owed():
    ok = _affordable(_paths((1, LAWN), (1, HOUSE), (2, ROOM)), 1)
    assert np.flatnonzero(ok[1] & GRAMMAR.is_coarse).tolist() == [ROOF]


def test_no_house_begins_that_cannot_be_finished():
    paths = _paths((1, LAWN), (1, HOUSE), (2, ROOM), (2, ROOF))
    assert not _affordable(paths, 2)[0, HOUSE]
    assert _affordable(paths, 3)[0, HOUSE]


def test_fine_needs_see_fine_children_only():
    ok = _affordable(_paths((1, TABLE), root=ROOM), 1, is_coarse=False)
    assert ok[0, CHAIR]
    assert not ok[0, TABLE]


def test_the_start_pad_takes_no_place_from_what_is_owed():
    ok = _affordable(_paths(root=LAWN), 1, is_coarse=False)
    assert ok[0, PAD]
    assert ok[0, TREE]
    ok = _affordable(_paths(root=LAWN), 0, is_coarse=False)
    assert ok[0, PAD]
    assert not ok[0, TREE]
