from __future__ import annotations

import numpy as np
import torch

from aeroscene.learning.skeleton.grammar import owners
from aeroscene.learning.skeleton.lesson import lesson_of
from aeroscene.learning.skeleton.sequence import IGNORE
from aeroscene.learning.skeleton.tree import Tree
from aeroscene.learning.tokens.skeleton import Wish
from tests.aeroscene.learning.skeleton.test_grammar import GRAMMAR
from tests.aeroscene.learning.skeleton.toy import LAWN, PAD, site, toy_corpus

EXAMPLES = toy_corpus(5, seed=4)
LESSON = lesson_of([s for s, _ in EXAMPLES], [w for _, w in EXAMPLES], GRAMMAR)


def test_coarse_steps_say_every_coarse_object_in_order():
    for row, (skeleton, _) in enumerate(EXAMPLES):
        said = LESSON.coarse_steps.kind[row]
        assert said[said != IGNORE].tolist() == skeleton.kind_id[1 : skeleton.n_coarse].tolist()


def test_steps_make_the_skeletons_again():
    for row, (skeleton, _) in enumerate(EXAMPLES):
        tree = Tree(site())
        for steps, is_coarse in ((LESSON.coarse_steps, True), (LESSON.fine_steps, False)):
            focus, depths, kinds = steps.view[5][row], steps.depth[row], steps.kind[row]
            for place, depth, kind in zip(focus, depths, kinds, strict=True):
                if kind != IGNORE:
                    tree.turn_to(int(place)) if not is_coarse else None
                    tree.add(int(depth), int(kind), is_coarse=is_coarse)
        made = tree.skeleton()
        np.testing.assert_array_equal(made.kind_id, skeleton.kind_id)
        np.testing.assert_array_equal(made.parent, skeleton.parent)
        assert made.n_coarse == skeleton.n_coarse


def test_quotas_add_up_to_the_fine_objects():
    quota = LESSON.fine_steps.quota
    totals = torch.where(quota == IGNORE, 0, quota).sum(dim=1)
    assert totals.tolist() == [wish.n_fine for _, wish in EXAMPLES]


def test_start_is_the_object_that_bears_the_pad():
    for row, (skeleton, _) in enumerate(EXAMPLES):
        pad = int(np.flatnonzero(skeleton.kind_id == PAD)[0])
        assert LESSON.start[row] == owners(skeleton)[pad]
        assert LESSON.coarse.kind[row, LESSON.start[row]] == LAWN


def test_a_scene_of_nothing_but_its_site_has_nothing_to_say():
    lesson = lesson_of([site()], [Wish("outdoor", 0, 0, 0)], GRAMMAR)
    assert (lesson.coarse_steps.kind == IGNORE).all()
    assert (lesson.fine_steps.kind == IGNORE).all()
    assert lesson.start.tolist() == [IGNORE]
