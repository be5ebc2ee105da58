"""Prompts as users write them, each with everything that is read from it."""

import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from scenarios.generation.prompts.parsing import read_prompt
from scenarios.generation.prompts.parsing.lexemes import lexemes
from scenarios.generation.prompts.parsing.lexicon import lexicon
from scenarios.generation.prompts.parsing.numbers import number_at
from scenarios.generation.prompts.wishes import PromptError

OPTIONS = (
    "domain",
    "theme",
    "objects",
    "areas",
    "density",
    "clutter",
    "outline_m",
    "min_passage_m",
    "difficulty",
)
# Prompt, options, counts with relations, words that are not understood.
PROMPTS = (
    (
        "a crowded harbour street with a crane and two cafes",
        "theme=waterfront density=1.5",
        "road: at least 1; cafe: 2",
        "crane",
    ),
    (
        "a small park with three benches along the path and no fences",
        "theme=park outline_m=60,60",
        "fence: 0; bench along sidewalk: 3",
        "",
    ),
    (
        "an office with at least five desks and a meeting room",
        "theme=office",
        "desk: at least 5; meeting room: at least 1",
        "",
    ),
    (
        "a sparse 80 by 60 m industrial yard with a dozen containers behind the warehouse",
        "theme=industrial_yard density=0.6 outline_m=80,60",
        "container behind warehouse: 10 to 14",
        "",
    ),
    (
        "half a hectare of old town with 5 to 8 trees",
        "theme=old_town outline_m=70.7,70.7",
        "tree: 5 to 8",
        "",
    ),
    ("two cars parked in front of the house", "", "car in front of house: 2", ""),
    (
        "behind the house a garden, and a table between two chairs",
        "",
        "chair: 2; garden behind house: at least 1; table between chair and chair: at least 1",
        "",
    ),
    (
        "solar panels on the roof of the building next to a road",
        "",
        "solar panel on roof of building: at least 2; solar panel next to road: at least 2",
        "",
    ),
    ("benches along the quay", "theme=waterfront", "bench along wide water: at least 2", ""),
    (
        "a tree-lined street without cars or buses, but with bikes",
        "theme=residential_street",
        "car: 0; bus: 0; bicycle: at least 2; tree along road: at least 10",
        "",
    ),
    ("a park and an office", "theme=park", "office room: at least 1", ""),
    ("an indoor market with a pair of kiosks", "domain=indoor", "market: at least 1; kiosk: 2", ""),
    (
        "I want a village by the sea with many boats",
        "theme=village",
        "wide water: at least 1; boat: at least 10",
        "",
    ),
    ("a warehouse with forklifts", "theme=warehouse", "", "forklifts"),
    (
        "three warehouses and a truck facing the warehouse",
        "",
        "warehouse: 3; truck facing warehouse: at least 1",
        "",
    ),
    (
        "a huge supermarket packed with shelves",
        "theme=supermarket outline_m=36,30",
        "shelf: at least 10",
        "",
    ),
    (
        "cluttered apartments with doors at least 1.2 m wide",
        "theme=apartments clutter=3.0 min_passage_m=1.2",
        "",
        "",
    ),
    ("a school with twenty five desks", "theme=school", "desk: 20 to 30", ""),
    ("a house with no cars in front of it", "", "house: at least 1; car in front of house: 0", ""),
    ("crates under the canopy", "", "crate under canopy: at least 2", ""),
    ("a table with four chairs", "", "table: at least 1; chair: 4", ""),
    ("bicycles near the station entrance", "theme=station", "bicycle: at least 2", "entrance"),
    ("about 20 trees around a pond", "", "tree around water: 16 to 24", ""),
    ("not crowded street", "theme=residential_street", "", "not crowded"),
    ("a marina with at least five boats", "theme=waterfront", "boat: at least 5", ""),
    ("two buses in front of a building", "", "bus in front of building: 2", ""),
    ("a station with exactly 3 kiosks", "theme=station", "kiosk: 3", ""),
    ("a car park full of cars, no trees", "theme=car_park", "car: at least 10; tree: 0", ""),
    (
        "office with four meeting rooms and more than ten monitors",
        "theme=office",
        "meeting room: 4; monitor: at least 11",
        "",
    ),
    (
        "a very crowded fair with up to 6 stalls",
        "theme=fair density=1.8",
        "market stall: at most 6",
        "",
    ),
    (
        "apartments with two bedrooms, a kitchen and a living room",
        "theme=apartments",
        "bedroom: 2; kitchen: at least 1; living room: at least 1",
        "",
    ),
    ("benches next to the pond in a park", "theme=park", "bench next to water: at least 2", ""),
    ("a hedge between two houses", "", "house: 2; hedge between house and house: at least 1", ""),
    ("bins behind the warehouse", "", "bin behind warehouse: at least 2", ""),
    ("a bench facing the water", "", "bench facing water: at least 1", ""),
    ("a chair in front of the television", "", "chair in front of television: at least 1", ""),
    (
        "a park with a jetty and a pair of rowing boats",
        "theme=park",
        "jetty: at least 1; boat: 2",
        "rowing",
    ),
    ("a hillside village with gable roofs", "theme=hillside", "gable roof: at least 2", ""),
    ("lorries on the road", "", "truck on road: at least 2", ""),
    ("laptops on the desks", "", "laptop on desk: at least 2", ""),
    (
        "street lamps along the sidewalk of a residential street",
        "theme=residential_street",
        "street lamp along sidewalk: at least 2",
        "",
    ),
    ("solar panels on the roof", "", "solar panel on roof: at least 2", ""),
    (
        "a building with ac units on its roof",
        "",
        "building: at least 1; ac unit on roof: at least 2",
        "",
    ),
    ("on the roof there are two solar panels", "", "solar panel on roof: 2", ""),
    ("five or six parked vans", "", "van: 5 to 6", ""),
    (
        "a dozen trees, half a dozen bushes and dozens of cups",
        "",
        "tree: 10 to 14; bush: 5 to 7; cup: at least 24",
        "",
    ),
    ("between 10 and 20 chairs in a school", "theme=school", "chair: 10 to 20", ""),
    ("a library with bookshelves", "theme=library", "bookcase: at least 2", ""),
    ("an old harbour with red boats", "theme=waterfront", "boat: at least 2", "old, red"),
    ("a retail park without any containers", "theme=retail_park", "container: 0", ""),
    ("a 1.5 hectare industrial estate", "theme=industrial_yard outline_m=122.5,122.5", "", ""),
    ("800 square metres of supermarket", "theme=supermarket outline_m=28.3,28.3", "", ""),
    ("a hard to fly industrial yard", "theme=industrial_yard difficulty=hard", "", ""),
    (
        "an easy outdoor scene with a bridge over the road",
        "domain=outdoor difficulty=easy",
        "bridge over road: at least 1",
        "",
    ),
    ("messy warehouse, very sparse", "theme=warehouse density=0.4 clutter=3.0", "", ""),
    ("a site of 70 x 60 metres with a tower", "outline_m=70,60", "tower: at least 1", ""),
    (
        "a residential street with cars but no bicycles",
        "theme=residential_street",
        "car: at least 2; bicycle: 0",
        "",
    ),
    ("I would like a school with 3 classrooms, please!", "theme=school", "classroom: 3", ""),
    ("a small house", "", "house: at least 1", "small"),
    ("several pallets near the truck", "", "pallet near truck: at least 3", ""),
    ("trees around the lawn", "", "tree around lawn: at least 2", ""),
    ("a tree behind the bush", "", "tree: at least 1", "behind bush (a bush has no front)"),
    ("plates on tables", "", "plate on table: at least 2", ""),
    ("the restaurant has five tables with chairs", "theme=restaurant", "set table: 4 to 6", ""),
    (
        "containers stacked in a container yard",
        "theme=industrial_yard",
        "container: at least 2",
        "stacked",
    ),
    ("a campus", "theme=campus", "", ""),
    ("crates inside the container", "", "crate inside container: at least 2", ""),
    ("hardly any cars", "", "car: at most 2", ""),
    ("a plaza with a market", "", "plaza: at least 1; market: at least 1", ""),
    ("café by the canal", "", "cafe next to wide water: at least 1", ""),
    ("one bench", "", "bench: 1", ""),
    ("a garden behind each house", "", "garden behind house: at least 1", "each"),
    ("an indoor waterfront", "domain=indoor theme=waterfront", "", ""),
    ("a mixed urban block with desks", "domain=mixed theme=urban_block", "desk: at least 2", ""),
    ("asdf qwer", "", "", "asdf, qwer"),
    ("a bus stop on the street", "theme=residential_street", "bus stop: at least 1", ""),
    ("a chimney on the house", "", "chimney on house: at least 1", ""),
    (
        "boxes under the table and a plant next to the sofa",
        "",
        "box under table: at least 2; plant next to sofa: at least 1",
        "",
    ),
    ("no people", "", "", "people, no"),
    ("60 objects in a small park", "theme=park objects=60 outline_m=60,60", "", ""),
    ("lamp posts every 10 m", "", "street lamp: at least 2", "every, m, 10"),
    ("a harbour town with boats", "theme=waterfront", "boat: at least 2", ""),
    (
        "a school library with bookshelves",
        "theme=school",
        "reading room: at least 1; bookcase: at least 2",
        "",
    ),
    ("two fountains and a car", "", "car: at least 1", "fountains, two"),
    ("a bridge across the river", "", "bridge over river: at least 1", ""),
    ("a town square", "theme=urban_block", "", ""),
    (
        "a crane behind the warehouse and a car",
        "",
        "warehouse: at least 1; car: at least 1",
        "crane, behind warehouse",
    ),
    (
        "150 objects in a park with at most 20 landing areas",
        "theme=park objects=150 areas=20",
        "",
        "",
    ),
    ("at least 20 landing areas", "", "", "at least 20 landing areas"),
    (
        "a park without a car, no trees and a bench",
        "theme=park",
        "car: 0; tree: 0; bench: at least 1",
        "",
    ),
    (
        "a house with a garage and three cars next to it",
        "",
        "house: at least 1; garage: at least 1; car next to garage: 3",
        "",
    ),
    ("a sofa in the lobby of an office", "theme=office", "sofa inside lobby: at least 1", ""),
)
MORE = (
    ("boats moored at a jetty", "", "boat next to jetty: at least 2", ""),
    (
        "a lake surrounded by trees",
        "",
        "wide water: at least 1; tree around wide water: at least 2",
        "",
    ),
    (
        "a street lined with trees",
        "theme=residential_street",
        "tree along road: at least 2",
        "",
    ),
    ("zorbs surrounded by trees", "", "tree: at least 2", "zorbs, surrounded by"),
    ("about 90 m by 80 m", "outline_m=90,80", "", ""),
    ("about a hectare of park", "theme=park outline_m=100,100", "", ""),
    ("two hectares of park", "theme=park outline_m=141.4,141.4", "", ""),
    ("not", "", "", "not"),
    ("no", "", "", "no"),
    ("between", "", "", "between"),
    ("on the roof", "", "", "on roof"),
    ("between a house and", "", "", "between house"),
    ("A WAREHOUSE FULL OF PALLETS ON RACKS", "theme=warehouse", "pallet on rack: at least 10", ""),
    ("an office at night", "theme=office", "", "night, at"),
    ("a hospital with a waiting room", "theme=clinic", "waiting room: at least 1", ""),
)
CONTRADICTIONS = (
    ("no cars and three cars", "asks for 0 and for 3 of car; valid: one of the two"),
    ("at least 5 cars and at most 3 cars", "asks for at least 5 and for at most 3 of car"),
    ("no cars, and two cars next to a house", "for at most 0 car; valid: one of the two"),
    ("no houses, two cars next to a house", "for at most 0 house; valid: one of the two"),
    (
        "20 to 5 trees",
        "asks for at least 20 and at most 5 of tree; valid: the smaller number first",
    ),
    ("a sparse crowded park", "'sparse' and 'crowded' (density 0.6 and 1.5); valid: one of"),
    ("a small large park", "asks for 'small' and 'large'; valid: one of the two"),
    ("a small park of 80 by 60 m", "a small site and for one of '80 by 60 m'; valid: one of"),
    ("80 by 60 m or half a hectare", "the sizes '80 by 60 m' and 'half a hectare'; valid: one"),
    ("indoor outdoor scene", "'indoor' and 'outdoor' (domain indoor and outdoor); valid: one of"),
    ("a park and a school", "two places, 'park' (park) and 'school' (school); valid: one of the"),
    ("900 cars", "number 900 is out of range; valid: 0 to 250"),
    ("a 300 by 300 m park", "outline 300.0 is out of range; valid: 15 to 150 m"),
    ("a park of 10 hectares", "outline 316.2 is out of range; valid: 15 to 150 m"),
    ("doors at least 9 m wide", "min-passage 9.0 is out of range; valid: 0.5 to 3 m"),
    ("10 objects", "objects 10 is out of range; valid: 20 to 250"),
    ("200 trees and 200 bushes", "asks for 320 things in all; valid: at most 250 objects"),
    ("50 objects with 80 trees", "asks for 64 things in all; valid: at most 50 objects"),
    ("50 objects and 90 objects", "'50 objects' and '90 objects' (objects 50 and 90); valid: one"),
    (" \t ", "prompt is empty; valid: words such as"),
    ("tree " * 300, "has 1499 characters; valid: at most 1000"),
)


NUMBERS = ("two", "at least three", "5 to 8", "a", "no", "zorb")


def read(prompt):
    """Options, demands and words left over, as one line each."""
    wishes = read_prompt(prompt)
    found = {name: getattr(wishes, name) for name in OPTIONS}
    options = " ".join(
        f"{name}={','.join(f'{side:g}' for side in value) if isinstance(value, tuple) else value}"
        for name, value in found.items()
        if value is not None
    )
    demands = "; ".join(f"{each.title}: {each.number}" for each in wishes.demands)
    return options, demands, ", ".join(wishes.not_understood)


@pytest.mark.parametrize(("prompt", "options", "demands", "unknown"), PROMPTS + MORE)
def test_prompts_are_read_as_they_are_meant(prompt, options, demands, unknown):
    assert read(prompt) == (options, demands, unknown)


@pytest.mark.parametrize(("prompt", "message"), CONTRADICTIONS)
def test_contradictions_and_numbers_out_of_range_are_refused_in_one_line(prompt, message):
    with pytest.raises(PromptError) as refusal:
        read_prompt(prompt)
    assert message in str(refusal.value)
    assert "\n" not in str(refusal.value)
    assert "; valid: " in str(refusal.value)


def test_every_wish_names_the_words_that_it_comes_from():
    wishes = read_prompt("a crowded harbour with two cafes and benches along the quay")
    assert [each.said for each in wishes.demands] == ["two cafes", "benches along quay"]
    assert {each.option: each.said for each in wishes.readings} == {
        "theme": "harbour",
        "density": "crowded",
    }


def read_or_refused(text):
    """Wishes, or the line that refuses the text."""
    try:
        return read_prompt(text)
    except PromptError as error:
        return str(error)


@given(st.lists(st.sampled_from([" ".join(words) for words in lexicon()] + list("a5,.-"))))
def test_no_order_of_known_words_breaks_the_parser(words):
    found = read_or_refused(" ".join(words)[:900])
    assert "\n" not in found if isinstance(found, str) else all(e.least >= 0 for e in found.demands)


SAID = {"noun", "option", "size", "amount", "relation", "reversed", "unknown", "number"}


PHRASES = {" ".join(words): kind for words, (kind, _) in lexicon().items()}
NOUNS = sorted(words for words, kind in PHRASES.items() if kind in {"noun", "option", "size"})
JOINTS = sorted(set(PHRASES) - set(NOUNS))


def random_prompts(count):
    """Prompts of a few phrases each: nouns, joints and numbers in any order."""
    rng = random.Random(1)
    for _ in range(count):
        groups = rng.choices((NOUNS, JOINTS, NUMBERS), k=rng.randint(1, 9))
        yield " ".join(map(rng.choice, groups))


def test_no_word_is_dropped_in_silence():
    for prompt in random_prompts(2000):
        found = read_or_refused(prompt)
        if isinstance(found, str):
            continue
        said = [*found.not_understood, *(e.said for e in (*found.demands, *found.readings))]
        told = " ".join(said)
        for lexeme in lexemes(prompt):
            number = lexeme.value if lexeme.kind == "number" else None
            if lexeme.kind in SAID and (number is None or number.n not in {None, 0, 1}):
                assert lexeme.said in told, prompt


@given(st.text(max_size=80))
def test_no_text_breaks_the_parser(text):
    found = read_or_refused(text)
    assert not isinstance(found, str) or "; valid: " in found


def test_a_checkpoint_may_have_themes_of_its_own():
    own = frozenset(("space_port", "park"))
    assert read_prompt("a small space port with a car", own).theme == "space_port"
    assert read_prompt("a park with a car", own).theme == "park"
    assert read_prompt("a space port with a car").theme == "waterfront"


def test_words_that_are_not_known_are_all_named():
    words = ["zorbs", "quickly", "glimmering", "elephants"]
    assert read_prompt(" ".join(words) + " park").not_understood == tuple(words)


@pytest.mark.parametrize(
    ("words", "limits"),
    [
        ("two", (2, 2)),
        ("5", (4, 6)),
        ("4", (4, 4)),
        ("twenty one", (17, 25)),
        ("a hundred", (80, 120)),
        ("two dozen", (20, 28)),
        ("exactly 20", (20, 20)),
        ("just two", (2, 2)),
        ("no more than 5", (0, 5)),
        ("no fewer than 5", (5, None)),
        ("fewer than 5", (0, 4)),
        ("over 5", (6, None)),
        ("from 3 to 6", (3, 6)),
        ("3 - 6", (3, 6)),
        ("a few", (2, 5)),
        ("few", (0, 3)),
        ("at most half a dozen", (0, 6)),
    ],
)
def test_numbers(words, limits):
    tokens = [*words.split(), "cars"]
    found = number_at(tokens, 0)
    assert found is not None
    number, taken = found
    assert (number.least, number.most, taken) == (*limits, len(tokens) - 1)
