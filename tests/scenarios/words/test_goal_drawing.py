"""Texts of the shipped scenes: each fits one place alone, and the same seed gives the same text."""

import subprocess
import sys

import pytest

from aeroscene.sources import load_scene
from scenarios.words.goal import GRADES, marks_of
from scenarios.words.goal_drawing import draw_goal
from scenarios.words.grounding import Truth, fits, the_one
from scenarios.words.site import Site, site_of
from scenarios.words.vocabulary import NOUNS

SCENES = range(0, 200, 20)
MOST_PLACES = 6


def drawn(number, seed=0):
    """Area and goal of every text that is drawn for some places of a scene."""
    scene = load_scene(str(number))
    first = {}
    for area in scene.landing_areas:
        first.setdefault(area.object_id, area)
    areas = list(first.values())
    for area in areas[:: max(1, len(areas) // MOST_PLACES)]:
        for grade in GRADES:
            if (goal := draw_goal(scene, area, grade, seed)) is not None:
                yield scene, area, grade, goal


@pytest.mark.parametrize("number", SCENES)
def test_every_text_fits_one_place_alone(number):
    for scene, area, grade, goal in drawn(number):
        assert goal.grade == grade
        # A checker that has seen nothing before.
        site = Site(scene)
        place = site.place_of(area.object_id)
        assert dict(fits(goal.description, site)) == {place: Truth.YES}, goal.text
        assert area in goal.areas
        assert {each.object_id for each in goal.areas} <= place.object_ids
        assert len(goal.text) <= 240
        assert NOUNS[goal.description.kind][0] in goal.text


@pytest.mark.parametrize("number", [45, 165])
def test_no_relation_is_idle_and_each_landmark_is_unique(number):
    n_texts = 0
    for scene, _, _, goal in drawn(number):
        site, description = site_of(scene), goal.description
        for link in description.links:
            n_texts += 1
            rest = tuple(each for each in description.links if each != link)
            shorter = type(description)(
                kind=description.kind,
                colour=description.colour,
                form=description.form,
                storey=description.storey,
                links=rest,
            )
            assert the_one(shorter, site) is None, goal.text
            assert all(the_one(mark, site) is not None for mark in marks_of(link))
    assert n_texts > 2


@pytest.mark.parametrize("number", [18, 21, 91])
def test_colours_of_vehicles_are_those_that_the_document_names(number):
    places = site_of(load_scene(str(number))).places
    painted = [place for place in places if place.kind in {"car", "van", "container"}]
    named = [str(place.objects[0].attributes["colour"]) for place in painted]
    seen = [place.colour for place in painted]
    assert len(painted) > 5
    assert all(colour in {name, None} for colour, name in zip(seen, named, strict=True))
    assert seen.count(None) < len(seen) / 3


_TEXTS = """
from aeroscene.sources import load_scene
from scenarios.words.goal_drawing import draw_goal
scene = load_scene("45")
for area in scene.landing_areas[::4]:
    goal = draw_goal(scene, area, "relation", 3)
    print(goal and goal.text)
"""


def test_the_same_seed_gives_the_same_text_in_another_process():
    said = subprocess.run(
        [sys.executable, "-c", _TEXTS], capture_output=True, text=True, check=True
    ).stdout.splitlines()
    scene = load_scene("45")
    goals = [draw_goal(scene, area, "relation", 3) for area in scene.landing_areas[::4]]
    assert said == [str(goal and goal.text) for goal in goals]
    assert len(set(said)) > 2
    others = [draw_goal(scene, area, "relation", 4) for area in scene.landing_areas[::4]]
    assert [str(goal and goal.text) for goal in others] != said
