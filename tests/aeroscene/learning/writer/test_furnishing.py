"""What is given comes back in its order, and more comes only where it may."""

from __future__ import annotations

import numpy as np
import pytest

from aeroscene.learning.writer.draw import draw_program
from aeroscene.learning.writer.furnishing import Furnishing
from aeroscene.learning.writer.stepwise import StepwiseWriter
from aeroscene.scene.catalogue import SEATS


@pytest.mark.parametrize("number", range(4))
def test_a_program_with_nothing_open_comes_back_as_it_is(corpus, language, writer, rng, number):
    program, wish = corpus[0][number].program, corpus[1][number]
    given = Furnishing(language.syntax, program, wish, is_open=())
    growth = draw_program(StepwiseWriter(writer), language.syntax, wish, rng, given)
    numbers = language.vocabulary.number
    assert growth.kinds == [numbers[kind] for kind in program.kinds]
    assert growth.parents == program.parent.tolist()
    assert [choice.host for choice in growth.choices] == program.host.tolist()
    assert given.place_of == {token: token for token in range(len(program))}


@pytest.mark.parametrize("number", range(4))
def test_what_is_given_stays_among_what_is_drawn(corpus, language, writer, rng, number):
    program, wish = corpus[0][number].program, corpus[1][number]
    given = Furnishing(language.syntax, program, wish)
    growth = draw_program(StepwiseWriter(writer), language.syntax, wish, rng, given)
    assert len(growth.kinds) > len(program)
    place_of = given.place_of
    assert sorted(place_of) == list(range(len(program)))
    places = list(place_of.values())
    assert len(set(places)) == len(places)
    for token, place in place_of.items():
        kind = language.vocabulary.kinds[growth.kinds[place]]
        assert kind == program.kinds[token]
        assert growth.parents[place] == place_of[int(program.parent[token])]


def test_more_comes_only_below_what_is_open(corpus, language, writer, rng):
    program, wish = corpus[0][0].program, corpus[1][0]
    bearers = set(program.parent[program.n_coarse :].tolist()) & set(range(1, program.n_coarse))
    one = max(bearers, key=program.parent.tolist().count)
    given = Furnishing(language.syntax, program, wish, is_open=[one])
    growth = draw_program(StepwiseWriter(writer), language.syntax, wish, rng, given)
    known = set(given.place_of.values())
    new = [place for place in range(len(growth.kinds)) if place not in known]
    assert new
    for place in new:
        above = growth.parents[place]
        while above >= growth.n_coarse:
            above = growth.parents[above]
        assert above == one


def test_larger_things_come_before_what_is_given_and_smaller_ones_after_it(
    corpus, language, writer
):
    """Below one bearer a drawn thing never follows a given one that is usually smaller."""
    from aeroscene.learning.writer.furnishing import _usual_m2

    program, wish = corpus[0][3].program, corpus[1][3]
    before = 0
    for seed in range(3):
        given = Furnishing(language.syntax, program, wish)
        growth = draw_program(
            StepwiseWriter(writer), language.syntax, wish, np.random.default_rng(seed), given
        )
        kinds = language.vocabulary.kinds
        known = set(given.place_of.values())
        for bearer in range(growth.n_coarse):
            own = [i for i, above in enumerate(growth.parents) if above == bearer and i]
            fine = [i for i in own if i >= growth.n_coarse]
            for at, place in enumerate(fine):
                follows = [i for i in fine[at + 1 :] if i in known]
                if place not in known and follows:
                    before += 1
                    assert _usual_m2(kinds[growth.kinds[place]].category) > _usual_m2(
                        kinds[growth.kinds[follows[0]]].category
                    )
    assert before


def test_chairs_come_last():
    from aeroscene.learning.writer.furnishing import _usual_m2

    assert {_usual_m2(category) for category in SEATS} == {0.0}
    assert 0.0 < _usual_m2("cup") < _usual_m2("table") < _usual_m2("bus")


def test_no_second_start_is_drawn_where_there_is_one(corpus, language, writer, rng):
    program, wish = corpus[0][0].program, corpus[1][0]
    given = Furnishing(language.syntax, program, wish, has_start=True)
    growth = draw_program(StepwiseWriter(writer), language.syntax, wish, rng, given)
    assert language.syntax.is_start[growth.kinds].sum() == 1
