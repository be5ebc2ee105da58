"""The 23 coarse and 47 fine categories: real sizes, what carries them, and their roles.

The paper gives the numbers of categories, but not their names. Sizes are ranges of full local
extents in metres: x forwards (the side that an object shows to its user, or its direction of
travel), y to the left, z up. Generated scenes are checked for outliers against these ranges.

Other modules ask for roles and never for names of categories. A new category therefore needs a row
here and no change elsewhere.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Literal, cast

Level = Literal["coarse", "fine"]
Support = Literal["ground", "building", "roof", "floor", "furniture", "water"]
COARSE_COUNT = 23

Range = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Category:
    """Properties that all objects of a category share."""

    id: int
    name: str
    level: Level
    length_m: Range
    """Range of the extent along x."""
    width_m: Range
    """Range of the extent along y."""
    height_m: Range
    """Range of the extent along z."""
    supports: tuple[Support, ...]
    """Kinds of surface or container that objects of this category stand on, hang on or lie in."""
    surface: str
    """Material on top of it that a drone's landing gear touches."""
    roles: frozenset[str]
    """Roles that it plays for other objects, people and drones; the sets below explain each word.
    """


_Row = tuple[str, Range, Range, Range, str, str, str]

# fmt: off
_COARSE: tuple[_Row, ...] = (
    # name            length x, m   width y, m    height z, m    supports             surface
    # roles
    ("building",      (6, 40),      (6, 40),      (3, 40),       "ground",            "concrete",
    "building shell block"),
    ("house",         (6, 16),      (6, 16),      (2.6, 8),      "ground",            "brick",
    "building shell block"),
    ("tower",         (5, 16),      (5, 16),      (12, 45),      "ground",            "concrete",
    "building shell block"),
    ("warehouse",     (10, 40),     (10, 40),     (4, 12),       "ground",            "metal",
    "building shell block landable"),
    ("garage",        (2, 8),       (2, 8),       (2, 3.5),      "ground",            "concrete",
    "shell block landable"),
    ("terrain",       (2, 120),     (2, 120),     (0.1, 8),      "ground",            "grass",
    "level terrain landable"),
    ("kiosk",         (2, 4),       (2, 5),       (2.4, 3.5),    "ground",            "metal",
    "block landable"),
    ("container",     (5.9, 12.3),  (2.3, 2.6),   (2.4, 2.9),    "ground building",   "metal",
    "block level landable"),
    ("canopy",        (2, 12),      (2, 16),      (2.6, 5.5),    "ground",            "metal",
    "canopy landable"),
    ("bridge",        (8, 40),      (2, 4),       (4, 8),        "ground",            "concrete",
    "bridge level two_sided landable"),
    ("deck",          (3, 14),      (3, 14),      (0.15, 1.2),   "ground roof",       "wood",
    "deck level two_sided landable"),
    ("water",         (3, 120),     (3, 120),     (0.05, 0.6),   "ground",            "water",
    "cover water no_perch"),
    ("roof",          (2, 42),      (2, 42),      (0.2, 5),      "building",          "roofing",
    "roof level landable"),
    ("floor",         (3, 40),      (3, 40),      (0.1, 0.4),    "building",          "concrete",
    "floor level two_sided no_perch"),
    ("room",          (2, 32),      (2, 32),      (2.2, 9),      "building",          "wood",
    "room two_sided landable no_perch"),
    ("wall",          (0.08, 0.5),  (0.8, 24),    (0.5, 9),      "building ground",   "concrete",
    "wall two_sided"),
    ("road",          (4, 120),     (4, 12),      (0.02, 0.15),  "ground",            "asphalt",
    "cover road strip way no_perch"),
    ("sidewalk",      (2, 120),     (1, 8),       (0.05, 0.25),  "ground",            "paving",
    "cover strip way landable"),
    ("lawn",          (2, 60),      (2, 60),      (0.02, 0.3),   "ground",            "grass",
    "cover open lawn two_sided landable"),
    ("parking_lot",   (5, 60),      (5, 60),      (0.02, 0.15),  "ground",            "asphalt",
    "cover open parking landable"),
    ("plaza",         (5, 60),      (5, 60),      (0.02, 0.25),  "ground",            "paving",
    "cover open way two_sided landable"),
    ("fence",         (0.05, 0.3),  (1, 60),      (0.8, 2.4),    "ground",            "metal",
    "fence two_sided"),
    ("stairs",        (1, 6),       (1, 8),       (0.3, 4),      "ground floor",      "concrete",
    "stairs"),
)

_FINE: tuple[_Row, ...] = (
    # name            length x, m   width y, m    height z, m    supports             surface
    # roles
    ("car",           (3.5, 5),     (1.6, 2),     (1.3, 1.8),    "ground",            "metal",
    "vehicle landable"),
    ("van",           (4.5, 6.5),   (1.8, 2.2),   (1.9, 2.8),    "ground",            "metal",
    "vehicle landable"),
    ("truck",         (6, 10),      (2.2, 2.6),   (2.6, 4),      "ground",            "metal",
    "vehicle landable"),
    ("bus",           (9, 13),      (2.4, 2.6),   (2.8, 3.4),    "ground",            "metal",
    "vehicle landable"),
    ("bicycle",       (1.5, 1.9),   (0.4, 0.7),   (0.9, 1.2),    "ground",            "metal",
    ""),
    ("tree",          (1.5, 8),     (1.5, 8),     (3, 14),       "ground roof",       "leaves",
    "leafy round no_perch"),
    ("bush",          (0.5, 2.5),   (0.5, 2.5),   (0.4, 2),      "ground roof",       "leaves",
    "leafy round no_perch"),
    ("street_lamp",   (0.3, 2.5),   (0.2, 0.8),   (3, 9),        "ground",            "metal",
    "post"),
    ("traffic_light", (0.2, 0.6),   (0.2, 0.8),   (2.4, 5),      "ground",            "metal",
    "signal"),
    ("sign",          (0.05, 0.3),  (0.4, 2.5),   (1.8, 4),      "ground",            "metal",
    ""),
    ("bench",         (0.4, 0.8),   (1.2, 2.2),   (0.4, 1),      "ground roof",       "wood",
    ""),
    ("bin",           (0.35, 0.9),  (0.35, 1.3),  (0.7, 1.4),    "ground floor",      "plastic",
    "loose round"),
    ("boat",          (4, 12),      (1.6, 4),     (0.8, 9),      "water",             "wood",
    "afloat no_perch"),
    ("planter",       (0.4, 1.6),   (0.4, 3),     (0.5, 1.6),    "ground roof floor", "leaves",
    "leafy round no_perch"),
    ("crate",         (0.6, 1.4),   (0.6, 1.4),   (0.5, 1.3),    "ground floor roof", "wood",
    "loose round two_sided landable"),
    ("toilet",        (0.5, 0.9),   (0.34, 0.56), (0.7, 1.1),    "floor",             "ceramic",
    "backed no_perch"),
    ("pallet",        (1, 1.3),     (0.8, 1.3),   (0.12, 1.4),   "ground floor",      "wood",
    "loose two_sided landable"),
    ("landing_pad",   (1.5, 6),     (1.5, 6),     (0.03, 0.4),   "ground roof",       "rubber",
    "pad landable"),
    ("ac_unit",       (0.8, 2.6),   (0.8, 2.6),   (0.7, 1.8),    "roof",              "metal",
    "landable"),
    ("chimney",       (0.4, 1.2),   (0.4, 1.2),   (0.8, 3.5),    "roof",              "brick",
    "chimney round two_sided"),
    ("solar_panel",   (1, 2.5),     (1.5, 6),     (0.3, 1.2),    "roof",              "glass",
    ""),
    ("water_tank",    (1.2, 3),     (1.2, 3),     (1.2, 3.5),    "roof ground",       "metal",
    "round landable"),
    ("basin",         (0.35, 0.75), (0.45, 1.6),  (0.8, 1.1),    "floor",             "ceramic",
    "backed no_perch"),
    ("table",         (0.7, 1.4),   (0.8, 2.6),   (0.68, 0.8),   "floor ground roof", "wood",
    "table tabletop two_sided landable"),
    ("chair",         (0.42, 0.65), (0.4, 0.62),  (0.78, 1.1),   "floor ground roof", "wood",
    "seat"),
    ("sofa",          (0.8, 1.05),  (1.4, 2.6),   (0.7, 0.95),   "floor",             "fabric",
    ""),
    ("armchair",      (0.75, 1),    (0.7, 1),     (0.7, 1),      "floor",             "fabric",
    ""),
    ("bed",           (1.9, 2.2),   (0.9, 2),     (0.5, 1.1),    "floor",             "fabric",
    "landable"),
    ("desk",          (0.6, 0.9),   (1.1, 2),     (0.7, 0.78),   "floor",             "wood",
    "table tabletop landable"),
    ("cabinet",       (0.35, 0.7),  (0.6, 2),     (0.7, 1.2),    "floor",             "wood",
    "backed landable"),
    ("wardrobe",      (0.5, 0.7),   (0.8, 2.4),   (1.8, 2.3),    "floor",             "wood",
    "backed"),
    ("shelf",         (0.25, 0.5),  (0.6, 2),     (1.2, 2.2),    "floor",             "wood",
    "backed boarded"),
    ("coffee_table",  (0.5, 0.9),   (0.8, 1.4),   (0.35, 0.5),   "floor",             "wood",
    "tabletop two_sided landable"),
    ("nightstand",    (0.35, 0.5),  (0.4, 0.6),   (0.4, 0.65),   "floor",             "wood",
    ""),
    ("counter",       (0.55, 0.8),  (1.2, 4.5),   (0.85, 1.1),   "floor",             "stone",
    "tabletop backed landable"),
    ("fridge",        (0.6, 0.75),  (0.55, 0.95), (1.4, 2),      "floor",             "metal",
    "backed"),
    ("stove",         (0.55, 0.7),  (0.5, 0.9),   (0.85, 0.95),  "floor",             "metal",
    "backed"),
    ("television",    (0.05, 0.35), (0.7, 1.7),   (0.45, 1.05),  "furniture",         "plastic",
    "screen no_perch"),
    ("lamp",          (0.25, 0.6),  (0.25, 0.6),  (0.35, 1.9),   "floor furniture",   "metal",
    "round no_perch"),
    ("plant",         (0.3, 0.9),   (0.3, 0.9),   (0.4, 1.8),    "floor furniture",   "leaves",
    "leafy round no_perch"),
    ("laptop",        (0.22, 0.3),  (0.3, 0.4),   (0.18, 0.3),   "furniture",         "metal",
    "screen no_perch"),
    ("monitor",       (0.15, 0.3),  (0.45, 0.9),  (0.35, 0.6),   "furniture",         "plastic",
    "screen no_perch"),
    ("plate",         (0.18, 0.32), (0.18, 0.32), (0.015, 0.05), "furniture",         "ceramic",
    "setting round no_perch"),
    ("cup",           (0.07, 0.12), (0.07, 0.12), (0.08, 0.14),  "furniture",         "ceramic",
    "round no_perch"),
    ("bath",          (0.7, 1),     (0.75, 1.9),  (0.5, 2.1),    "floor",             "ceramic",
    "backed no_perch"),
    ("book",          (0.15, 0.3),  (0.12, 0.4),  (0.02, 0.3),   "furniture",         "paper",
    "no_perch"),
    ("box",           (0.2, 0.7),   (0.2, 0.7),   (0.15, 0.6),   "floor furniture",   "cardboard",
    "loose round no_perch"),
)
# fmt: on


def _category(number: int, row: _Row) -> Category:
    name, length_m, width_m, height_m, supports, surface, roles = row
    return Category(
        id=number,
        name=name,
        level="coarse" if number <= COARSE_COUNT else "fine",
        length_m=length_m,
        width_m=width_m,
        height_m=height_m,
        supports=cast("tuple[Support, ...]", tuple(supports.split())),
        surface=surface,
        roles=frozenset(roles.split()),
    )


CATALOGUE: Mapping[int, Category] = {
    number: _category(number, row) for number, row in enumerate(_COARSE + _FINE, 1)
}
"""Categories under their ids: 1 to 23 are coarse, 24 to 70 fine."""


@cache
def by_name() -> Mapping[str, Category]:
    """Categories under their names."""
    return {category.name: category for category in CATALOGUE.values()}


def category_id(name: str) -> int:
    """The id of a category.

    Raises:
        KeyError: If there is no such category.
    """
    return by_name()[name].id


def _with(role: str) -> frozenset[str]:
    return frozenset(each.name for each in CATALOGUE.values() if role in each.roles)


# Names of the categories that have a role, and what each of them is. Code asks for these and names
# no category, so that a new one is treated as all others of its role.

# Structures
BUILDINGS = _with("building")  # rooms, walls, floors and roofs are its parts
SHELLS = _with("shell")  # has outer walls of its own, within the rim of its box
BLOCKS = _with("block")  # stands on the ground and keeps the wind off
ROOMS = _with("room")
WALLS = _with("wall")
FENCES = _with("fence")
FLOORS = _with("floor")  # a slab between storeys
ROOFS = _with("roof")
BUILDING_PARTS = ROOMS | WALLS | FLOORS | ROOFS
CANOPIES = _with("canopy")  # bears on its top, and shelters what stands below
CHIMNEYS = _with("chimney")  # rises through the slope of its roof
BRIDGES = _with("bridge")  # a deck between rails over water or roads
DECKS = _with("deck")  # lies on the bed or the surface of water as well
STAIRS = _with("stairs")
LEVELS = _with("level")  # stairs lead up to it

# Ground
COVERS = _with("cover")  # a thin surface that tiles the ground
TERRAIN = _with("terrain")  # raised land
GROUND = COVERS | TERRAIN
OPEN_GROUND = _with("open")  # a cover as wide as what stands on it; flights may start there
LAWNS = _with("lawn")
PARKING = _with("parking")
ROADS = _with("road")
WATER = _with("water")
STRIPS = _with("strip")  # a cover of a width in metres, which goes on end to end
WAYS = _with("way")  # a cover that leads from one place to another

# Things outdoors
VEHICLES = _with("vehicle")  # keeps to its lane on a road
AFLOAT = _with("afloat")  # belongs on water
SIGNALS = _with("signal")  # stands at a road, whatever bears it
POSTS = _with("post")  # reaches beyond its parent's outline except at the foot
PADS = _with("pad")  # made for landing
LOOSE = _with("loose")  # lies about, in the way of a landing

# Things indoors
SEATS = _with("seat")  # is drawn up to a table and faces it
TABLES = _with("table")  # people sit and work at it
TABLETOPS = _with("tabletop")  # seats may belong to it
SETTINGS = _with("setting")  # is laid on a table before a seat
SCREENS = _with("screen")  # is looked at from the front
BACKED = _with("backed")  # stands with its back to a wall
BOARDED = _with("boarded")  # bears things on the boards within it too

# Shape
LEAFY = _with("leafy")
ROUND = _with("round")  # has no front
TWO_SIDED = _with("two_sided")  # the same after half a turn; a wall's openings are mirrored
LANDABLE = _with("landable")  # level upward faces of its shape may carry a drone
NO_PERCH = _with("no_perch")  # soft, loose, wet, or no ledge at all: nothing should perch there
