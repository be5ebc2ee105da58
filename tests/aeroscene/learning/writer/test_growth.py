"""Masks: they allow what programs are, and nothing that these never are."""

from __future__ import annotations

import numpy as np
import pytest

from aeroscene.learning.writer.furnishing import Furnishing
from aeroscene.learning.writer.growth import Choice, Growth, replay
from aeroscene.learning.writer.syntax import required_children


def steps(syntax, program, wish):
    """A program token by token: what was allowed before each, and what came."""
    whole, said = replay(syntax, program, wish)
    again = Growth(syntax, whole.kinds[0], wish)
    for depth, choice in said:
        yield again, depth, choice
        if choice is None:
            again.end()
        else:
            again.add(depth, choice)
    assert again.is_done


@pytest.mark.parametrize("number", range(4))
def test_masks_allow_what_programs_say(corpus, language, number):
    encoded, wish = corpus[0][number], corpus[1][number]
    for growth, depth, choice in steps(language.syntax, encoded.program, wish):
        assert growth.allowed_depths()[depth]
        if choice is not None:
            assert growth.allowed_kinds(depth)[choice.kind]


def test_coarse_part_grows_to_the_tokens_that_are_coarse(corpus, language):
    program, wish = corpus[0][0].program, corpus[1][0]
    growth = Furnishing(language.syntax, program, wish).growth
    assert len(growth.kinds) == growth.n_coarse == program.n_coarse
    assert growth.parents == program.parent[: program.n_coarse].tolist()


def test_a_record_that_lacks_parts_is_not_left(corpus, language):
    """A slice of three has three parts: after the first, nothing else may come."""
    syntax = language.syntax
    kinds = language.vocabulary.kinds
    seen = 0
    for encoded, wish in zip(*corpus, strict=True):
        for growth, _, _ in steps(syntax, encoded.program, wish):
            latest = growth.latest
            n_needed = len(required_children(kinds[latest.kind]))
            if not latest.is_mark and not growth.is_fine and n_needed:
                seen += 1
                allowed = growth.allowed_depths()
                assert not allowed[: len(growth.path)].any()
    assert seen > 10


def test_a_second_start_is_never_allowed(corpus, language):
    syntax = language.syntax
    for encoded, wish in zip(*corpus, strict=True):
        for growth, depth, choice in steps(syntax, encoded.program, wish):
            if growth.has_start and choice is not None:
                assert not growth.allowed_kinds(depth)[syntax.is_start].any()


def test_the_first_of_its_kind_is_never_as_large_as_the_last_one(corpus, language):
    syntax, n_refused = language.syntax, 0
    for encoded, wish in zip(*corpus, strict=True):
        seen: set[int] = set()
        for growth, depth, choice in steps(syntax, encoded.program, wish):
            if choice is None:
                continue
            allowed = growth.allowed_kinds(depth)
            is_first = syntax.is_as_last & ~np.isin(syntax.what, sorted(seen))
            n_refused += is_first.sum()
            assert not allowed[is_first].any()
            if language.vocabulary.kinds[choice.kind].node == "unit":
                seen.add(int(syntax.what[choice.kind]))
    assert n_refused > 1000


def test_objects_left_count_down_to_what_was_wished_for(corpus, language):
    encoded, wish = corpus[0][0], corpus[1][0]
    growth, _ = replay(language.syntax, encoded.program, wish)
    assert growth.elements[0].remaining == (wish.n_coarse, wish.n_fine)
    assert growth.latest.remaining[1] == 0
    before = growth.elements[3].remaining
    growth.add(1, Choice(growth.kinds[-1]))
    assert before != growth.latest.remaining
