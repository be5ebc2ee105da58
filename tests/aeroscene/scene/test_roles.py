"""Code asks for roles and names no category, so that no new category is missed."""

import ast
from pathlib import Path
from typing import get_args

import pytest

from aeroscene.scene import catalogue
from aeroscene.scene.catalogue import CATALOGUE, Support, by_name

ROOT = Path(__file__).parents[3]
PACKAGES = ("aeroscene", "autonomy", "flightsim", "scenarios")
SETS = {name: each for name, each in vars(catalogue).items() if isinstance(each, frozenset)}
MAKING = {
    "aeroscene/scene/catalogue.py": "lists them",
    "aeroscene/solids/shapes/": "draws each of them",
    "aeroscene/corpus/": "the grammar, and the open field, place objects of them",
    "aeroscene/layouts/": "maps words of other projects to them, and builds rooms of them",
    "aeroscene/maps/": "builds features of maps as objects of them",
    "aeroscene/partition/storeys/build.py": "builds rooms and walls",
    "scenarios/words/vocabulary.py": "says each of them in English",
    "scenarios/words/looks.py": "tells the forms that shapes of just these have",
}
"""Where a category is named, because just this one is made, drawn or put into words there."""
OTHER_WORDS = {
    "box": ("",),  # a kind of primitive
    "plant": ("flightsim/plant/", "scenarios/bench/"),  # what simulates the vehicle
    "bench": ("scenarios/",),  # a benchmark
    "car": ("flightsim/environment/", "flightsim/cameras/"),  # a kind of mover
    "room": (
        "aeroscene/scene/rooms.py",  # the attribute that tiles of one room share
        "aeroscene/partition/storeys/parse.py",
        "scenarios/cli/evaluate.py",  # an option
        "scenarios/bench/manoeuvres.py",  # a room is made, in which nothing is
    ),
    "table": ("scenarios/cli/evaluate.py",),  # an option
    "wall": (
        "aeroscene/partition/storeys/",  # a kind of segment of a border
        "aeroscene/learning/program/",
        "scenarios/reports/plan_view.py",  # a colour of the plan
    ),
    "water": ("scenarios/reports/plan_view.py",),
    "road": ("scenarios/reports/plan_view.py",),
    "house": ("flightsim/looks/dressing.py",),  # facades of this one have styles of their own
    "tower": ("flightsim/looks/dressing.py",),
    "container": ("flightsim/looks/dressing.py",),
}
"""Where a word that is also a category's name means something else."""


def named(path):
    """Line and name of each literal in a file that is a category's name, but for those allowed."""
    where = path.relative_to(ROOT).as_posix()
    if where.startswith(tuple(MAKING)):
        return
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            is_other = where.startswith(OTHER_WORDS.get(node.value, ("\n",)))
            if node.value in by_name() and not is_other:
                yield f"{where}:{node.lineno} {node.value!r}"


@pytest.mark.parametrize("package", PACKAGES)
def test_code_asks_for_roles_and_names_no_category(package):
    found = [line for path in sorted((ROOT / package).rglob("*.py")) for line in named(path)]
    assert found == []


def test_every_exception_is_still_needed():
    used = {
        (node.value, place)
        for word, places in OTHER_WORDS.items()
        for place in places
        for path in ROOT.glob(f"{place}**/*.py" if not place.endswith(".py") else place)
        if path.relative_to(ROOT).parts[0] in PACKAGES
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, ast.Constant) and node.value == word
    }
    assert used == {(word, place) for word, places in OTHER_WORDS.items() for place in places}


def test_a_literal_is_found(tmp_path, monkeypatch):
    monkeypatch.setitem(globals(), "ROOT", tmp_path)
    path = tmp_path / "flightsim.py"
    path.write_text('FLOATS = {"boat"}\nis_room = obj.category == "room"\nshape.kind == "box"\n')
    assert list(named(path)) == ["flightsim.py:1 'boat'", "flightsim.py:2 'room'"]


def test_every_word_of_the_table_has_a_set_and_every_set_its_words():
    words = {role for category in CATALOGUE.values() for role in category.roles}
    of_one_word = {
        frozenset(each.name for each in CATALOGUE.values() if word in each.roles): word
        for word in words
    }
    assert set(of_one_word) <= set(SETS.values())
    assert all(SETS.values())
    assert len(SETS) == len(words) + 2  # GROUND and BUILDING_PARTS are made of others


def test_supports_are_words_that_exist():
    found = {support for category in CATALOGUE.values() for support in category.supports}
    assert found == set(get_args(Support))
