"""The vocabulary covers the catalogue, and no word means two things."""

from collections import defaultdict
from dataclasses import fields

import pytest

from aeroscene.learning.generation.loading import SHIPPED
from aeroscene.learning.training.checkpoint import read_checkpoint
from aeroscene.learning.writer.language import Language
from aeroscene.scene.catalogue import CATALOGUE
from aeroscene.solids.shapes import FORMS
from scenarios.cli.generate import GenerateCfg
from scenarios.generation.prompts.parsing import read_prompt
from scenarios.generation.prompts.parsing.lexicon import OPTIONS, RELATIONS, Noun, lexicon
from scenarios.generation.prompts.vocabulary import (
    categories_of,
    has_front,
    phrases,
    places,
    plural,
    things,
)
from scenarios.generation.prompts.wishes import spoken

NAMES = [category.name for category in CATALOGUE.values()]
NOT_IN_SHAPES = {"glass"}
"""Forms that walls have, which have no shapes of their own."""


@pytest.mark.parametrize("name", NAMES)
def test_every_category_is_understood_by_its_name_and_plural(name):
    (count,) = read_prompt(f"exactly 3 {plural(spoken(name))} in an office").counts
    assert (count.thing, count.least, count.most) == (name, 3, 3)


def test_every_phrase_is_understood_as_its_thing():
    for name, thing in things().items():
        for words in phrases(name, thing.words):
            kind, noun = lexicon()[tuple(words.split())]
            assert kind == "noun", words
            assert isinstance(noun, Noun)
            assert noun.thing == name or noun.place, words


def test_no_phrase_names_two_things():
    owners = defaultdict(set)
    for name, thing in things().items():
        for words in phrases(name, thing.words):
            owners[words].add(name)
    assert {words: names for words, names in owners.items() if len(names) > 1} == {}


def test_no_phrase_names_two_places():
    owners = defaultdict(set)
    for name, place in places().items():
        for words in (*place.words, *place.weak):
            owners[words].add(name)
    assert {words: names for words, names in owners.items() if len(names) > 1} == {}


def test_words_of_options_and_relations_name_nothing_else():
    words = [w for group in (*OPTIONS.values(), *RELATIONS.values()) for w in group]
    assert [each for each in words if lexicon()[tuple(each.split())][0] == "noun"] == []


def test_no_thing_has_the_name_of_another_wish():
    options = {field.name for field in fields(GenerateCfg)} | {"areas_small", "worst_for", "region"}
    assert {spoken(name) for name in things()} & options == set()


def test_every_theme_of_the_model_that_ships_has_words():
    language = read_checkpoint(SHIPPED["default"]).known
    assert isinstance(language, Language)
    for theme in {theme for group in language.themes.values() for theme in group}:
        assert read_prompt(spoken(theme)).theme == theme


def test_forms_and_hearts_are_those_of_the_catalogue():
    for name, thing in things().items():
        for category in categories_of(name):
            forms = (*FORMS.get(category, ()), *NOT_IN_SHAPES)
            assert not thing.form or thing.form in forms, name


def test_fronts_are_where_roles_have_them():
    assert all(map(has_front, ("house", "car", "bench", "television", "cafe_terrace")))
    assert not any(map(has_front, ("tree", "road", "table", "room", "grove", "lawn")))


@pytest.mark.parametrize(
    ("one", "many"),
    [
        ("bus", "buses"),
        ("bench", "benches"),
        ("lorry", "lorries"),
        ("bookshelf", "bookshelves"),
        ("row of trees", "rows of trees"),
        ("table with chairs", "tables with chairs"),
        ("grass", "grass"),
        ("driveway", "driveways"),
    ],
)
def test_plurals(one, many):
    assert plural(one) == many
