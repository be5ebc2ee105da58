"""A prompt beside options and a checkpoint: who wins, what is added, and what the user reads."""

import pytest

from scenarios.generation.prompts.parsing import read_prompt
from scenarios.generation.prompts.understanding import understood
from scenarios.generation.prompts.vocabulary import places, things

THEMES = {
    "outdoor": {"park", "waterfront", "residential_street", "urban_block", "hillside"},
    "mixed": {"residential_street", "urban_block"},
    "indoor": {"office", "apartments"},
}


def found(prompt, themes=THEMES, **given):
    return understood(prompt, read_prompt(prompt), given, themes)


def test_every_wish_has_a_line_with_its_words():
    each = found(
        "a crowded harbour of 70 by 60 m with two cafes, benches along the quay and a crane"
    )
    assert each.rows == [
        ("harbour", "theme: waterfront"),
        ("crowded", "density: 1.5"),
        ("70 by 60 m", "outline: 70,60"),
        ("two cafes", "cafe: 2"),
        ("benches along quay", "bench along wide water: at least 2"),
    ]
    assert each.not_understood == ("crane",)
    assert each.to_plain()["not_understood"] == ["crane"]
    assert each.to_plain()["wishes"][3] == {"said": "two cafes", "wish": "cafe: 2"}


def test_options_win_and_the_program_says_so():
    each = found("a crowded park of 70 by 60 m", theme="waterfront", outline="50,50")
    assert each.options == {"density": 1.5}
    assert each.notes == (
        "--theme waterfront wins over the prompt's theme park",
        "--outline 50,50 wins over the prompt's outline 70,60",
    )


def test_an_option_that_says_the_same_is_no_news():
    assert found("a park", theme="park").notes == ()


def test_a_number_of_objects_leaves_no_room_for_the_prompts_density():
    each = found("a crowded park", objects=90)
    assert "density" not in each.options
    assert each.notes == ("--objects 90 wins over the prompt's density 1.5",)


@pytest.mark.parametrize(
    ("given", "left", "note"),
    [
        ({"domain": "indoor"}, {}, "--domain indoor wins over the prompt's theme park"),
        ({"domain": "outdoor"}, {"theme": "park"}, None),
    ],
)
def test_a_domain_that_was_given_wins_over_a_theme_that_it_has_not(given, left, note):
    each = found("a park", **given)
    assert each.options == left
    assert each.notes == (() if note is None else (note,))


def test_a_theme_that_was_given_wins_over_a_domain_that_has_it_not():
    each = found("an indoor scene with a desk", theme="park")
    assert "domain" not in each.options
    assert each.notes == ("--theme park wins over the prompt's domain indoor",)


@pytest.mark.parametrize(
    ("prompt", "theme", "nearest"),
    [
        ("an old town", "old_town", "urban_block"),
        ("a village", "village", "residential_street"),
        ("a retail park", "retail_park", "urban_block"),
        ("a campus", "campus", "urban_block"),
        ("a clinic", "clinic", "office"),
        ("a restaurant", "restaurant", "office"),
    ],
)
def test_a_theme_that_the_checkpoint_does_not_know_becomes_the_nearest(prompt, theme, nearest):
    each = found(prompt)
    assert each.options["theme"] == nearest
    assert each.notes == (f"the checkpoint knows no theme {theme}; {nearest} is the nearest",)
    known = {"outdoor": {theme}}
    assert found(prompt, known).options["theme"] == theme
    assert found(prompt, known).notes == ()


def test_a_checkpoint_without_themes_draws_them():
    each = found("an old town with trees", {})
    assert "theme" not in each.options
    assert each.notes == ("the checkpoint knows no theme like old_town; the theme is drawn",)


def test_a_thing_that_is_usual_in_a_theme_asks_for_it():
    each = found("three boats")
    assert each.options["theme"] == "waterfront"
    assert "theme waterfront, because a boat is usual there" in each.notes
    assert "theme" not in found("no boats").options
    assert "theme" not in found("three boats", complete="42").options


@pytest.mark.parametrize(
    ("prompt", "domain"),
    [
        ("a sofa", "indoor"),
        ("a street lamp on the road", "outdoor"),
        ("a sofa and a street lamp", "mixed"),
        ("a residential street with a sofa", "mixed"),
        ("a park with a sofa", None),
        ("a table", None),
        ("no sofa", None),
        ("an outdoor sofa", "outdoor"),
    ],
)
def test_the_domain_is_one_in_which_everything_can_stand(prompt, domain):
    assert found(prompt).options.get("domain") == domain


def test_tables_of_the_vocabulary_name_only_each_other():
    for name, place in places().items():
        assert set(place.nearest) <= set(places()), name
        assert set(place.things.values()) <= set(things()), name
    for name, thing in things().items():
        assert set(thing.themes) <= set(places()), name
