"""Things are found by their geometry, and no longer once a part of them is taken away."""

from dataclasses import replace

import pytest

from aeroscene.corpus.shipped import read_shipped
from aeroscene.scene.catalogue import CATALOGUE
from scenarios.generation.prompts.demands import numbers_of
from scenarios.generation.prompts.finder import Finder
from scenarios.generation.prompts.wishes import Count
from tests.aeroscene.metrics.scenes import box, scene_of

CANOPY = ("canopy", box((0, 0, 1.5), (6, 6, 3)))


def table(x, y):
    return ("table", box((x, y, 0.37), (0.8, 0.8, 0.74)))


def chair(x, y):
    return ("chair", box((x, y, 0.45), (0.5, 0.5, 0.9)))


def seated(x, y):
    """A table with a chair at either side."""
    return [table(x, y), chair(x + 0.8, y), chair(x - 0.8, y)]


def deck(x):
    return ("deck", box((x, 0, 0.3), (4, 3, 0.4)))


def container(x, z=1.3):
    return ("container", box((x, 0, z), (6, 2.4, 2.6)))


def bike(x):
    return ("bicycle", box((x, 0, 0.5), (1.7, 0.5, 1.0), 90))


def boat(x):
    return ("boat", box((x, 0, 0.5), (5, 2, 1.2), 90))


WATER = ("water", box((10, 0, 0.1), (12, 8, 0.2)))
DESK = ("desk", box((0, 0, 0.37), (0.8, 1.6, 0.74)))
# Thing, objects that make it, and those of a scene in which one part is missing or misplaced.
COMPOUNDS = (
    ("set_table", seated(0, 0), [table(0, 0), chair(0.8, 0), chair(-3, 0)]),
    (
        "cafe",
        [CANOPY, *seated(1, 1), *seated(-1, -1)],
        [CANOPY, *seated(1, 1), *seated(-11, -11)],
    ),
    (
        "cafe",
        [CANOPY, *seated(1, 1), *seated(-1, -1)],
        [CANOPY, *seated(1, 1), table(-1, -1), chair(-0.2, -1)],
    ),
    ("workplace", [DESK, ("laptop", box((0, 0, 0.85), (0.25, 0.35, 0.2)))], [DESK]),
    ("jetty", [WATER, deck(2.5)], [WATER, deck(0)]),
    ("marina", [boat(0), boat(5), boat(10)], [boat(0), boat(5), boat(30)]),
    ("bicycle_stand", [bike(0), bike(1), bike(2)], [bike(0), bike(1)]),
    (
        "garden",
        [("lawn", box((0, 0, 0.05), (10, 10, 0.1)))]
        + [("bush", box((x, 0, 0.6), (1, 1, 1))) for x in (-3, 0, 3)],
        [("lawn", box((0, 0, 0.05), (10, 10, 0.1)))]
        + [("bush", box((x, 0, 0.6), (1, 1, 1))) for x in (-3, 0, 13)],
    ),
    ("container_stack", [container(0), container(0.2, 3.9)], [container(0), container(8)]),
    (
        "market_stall",
        [CANOPY, table(1, 1), table(-1, 1)],
        [CANOPY, table(1, 1), table(-9, 1)],
    ),
    (
        "bus_stop",
        [
            CANOPY,
            ("bench", box((1, 0, 0.4), (0.6, 1.8, 0.8))),
            ("road", box((0, 10, 0.02), (40, 7, 0.04))),
        ],
        [
            CANOPY,
            ("bench", box((1, 0, 0.4), (0.6, 1.8, 0.8))),
            ("road", box((0, 30, 0.02), (40, 7, 0.04))),
        ],
    ),
    (
        "river",
        [("water", box((0, 0, 0.1), (30, 6, 0.2)))],
        [("water", box((0, 0, 0.1), (15, 6, 0.2)))],
    ),
    (
        "wide_water",
        [("water", box((0, 0, 0.1), (15, 21, 0.2)))],
        [("water", box((0, 0, 0.1), (15, 8, 0.2)))],
    ),
)


def number(scene, thing):
    ((_, n),) = numbers_of(scene, [Count(thing)])
    return n


def with_attributes(scene, *attributes):
    objects = [
        replace(obj, attributes=more) for obj, more in zip(scene.objects, attributes, strict=True)
    ]
    return replace(scene, objects=tuple(objects))


@pytest.mark.parametrize(("thing", "rows", "faulty"), COMPOUNDS)
def test_a_compound_is_found_until_a_part_is_missing(thing, rows, faulty):
    assert number(scene_of(*rows), thing) == 1
    assert number(scene_of(*faulty), thing) == 0


def test_three_stalls_close_together_are_one_market():
    stalls = [
        row
        for x in (0, 12, 24)
        for row in (
            ("canopy", box((x, 0, 1.5), (4, 4, 3))),
            table(x + 1, 0),
            table(x - 1, 0),
        )
    ]
    assert number(scene_of(*stalls), "market_stall") == 3
    assert number(scene_of(*stalls), "market") == 1
    assert number(scene_of(*stalls[:6]), "market") == 0


def test_forms_and_uses_are_read_from_attributes():
    scene = scene_of(*[("fence", box((x, 0, 0.6), (0.2, 4, 1.2))) for x in (0, 5, 10)])
    scene = with_attributes(scene, {"form": "hedge"}, {"form": "rails"}, {})
    assert (number(scene, "hedge"), number(scene, "railing"), number(scene, "fence")) == (1, 1, 3)
    rooms = scene_of(*[("room", box((x, 0, 1.5), (4, 4, 3))) for x in (0, 5, 10)])
    rooms = with_attributes(rooms, {"use": "kitchen"}, {"use": "cafe"}, {})
    assert [number(rooms, name) for name in ("kitchen", "cafe", "room")] == [1, 1, 3]


def test_tiles_of_one_room_are_one_room():
    rooms = scene_of(*[("room", box((x, 0, 1.5), (4, 4, 3))) for x in (0, 4, 10)])
    tile = {"room": "a", "use": "lobby"}
    rooms = with_attributes(rooms, tile, tile, {"use": "lobby"})
    assert number(rooms, "lobby") == 2
    (outline, other) = Finder(rooms).instances("lobby").outline
    assert sorted((outline.area, other.area)) == [16, 32]


def test_every_category_is_counted_as_the_scene_has_it():
    for scene in map(read_shipped, (5, 40, 42)):
        for category in CATALOGUE.values():
            n = sum(obj.category == category.name for obj in scene.objects)
            if category.name != "room":
                assert number(scene, category.name) == n
