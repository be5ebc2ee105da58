"""The 23 coarse and 47 fine categories: real sizes, what carries them, where a drone may land.

The paper gives the numbers of categories, not their names. Sizes are ranges of full local
extents in metres, x forwards (the side a thing shows to its user or its direction of travel),
y to the left, z up; outliers of generated scenes are judged against them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Literal

Level = Literal["coarse", "fine"]
Support = Literal["ground", "building", "roof", "floor", "furniture", "room", "water"]

COARSE_COUNT = 23

Range = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Category:
    """What every object of a kind has in common."""

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
    """What objects of this kind stand on, hang on or lie in."""
    is_landable: bool
    """Whether level upward faces of its shape may carry a drone."""
    surface: str
    """What a drone's landing gear meets there."""


_Row = tuple[str, Range, Range, Range, tuple[Support, ...], bool, str]

_STREET: tuple[Support, ...] = ("ground",)
_ROOF: tuple[Support, ...] = ("roof",)
_FLOOR: tuple[Support, ...] = ("floor",)
_TOP: tuple[Support, ...] = ("furniture",)

# name, x range, y range, z range, supports, landable, surface
_COARSE: tuple[_Row, ...] = (
    ("building", (6, 40), (6, 40), (3, 40), _STREET, False, "concrete"),
    ("house", (6, 16), (6, 16), (2.6, 8), _STREET, False, "brick"),
    ("tower", (5, 16), (5, 16), (12, 45), _STREET, False, "concrete"),
    ("warehouse", (10, 40), (10, 40), (4, 12), _STREET, True, "metal"),
    ("garage", (2, 8), (2, 8), (2, 3.5), _STREET, True, "concrete"),
    ("terrain", (2, 120), (2, 120), (0.1, 8), ("ground",), True, "grass"),
    ("kiosk", (2, 4), (2, 5), (2.4, 3.5), _STREET, True, "metal"),
    ("container", (5.9, 12.3), (2.3, 2.6), (2.4, 2.9), ("ground", "building"), True, "metal"),
    ("canopy", (2, 12), (2, 16), (2.6, 5.5), _STREET, True, "metal"),
    ("bridge", (8, 40), (2, 4), (4, 8), _STREET, True, "concrete"),
    ("deck", (3, 14), (3, 14), (0.15, 1.2), ("ground", "roof"), True, "wood"),
    ("water", (3, 120), (3, 120), (0.05, 0.6), _STREET, False, "water"),
    ("roof", (2, 42), (2, 42), (0.2, 5), ("building",), True, "roofing"),
    ("floor", (3, 40), (3, 40), (0.1, 0.4), ("building",), False, "concrete"),
    ("room", (2, 32), (2, 32), (2.2, 9), ("building",), True, "wood"),
    ("wall", (0.08, 0.5), (0.8, 24), (0.5, 9), ("building", "ground"), False, "concrete"),
    ("road", (4, 120), (4, 12), (0.02, 0.15), _STREET, False, "asphalt"),
    ("sidewalk", (2, 120), (1, 8), (0.05, 0.25), _STREET, True, "paving"),
    ("lawn", (2, 60), (2, 60), (0.02, 0.3), _STREET, True, "grass"),
    ("parking_lot", (5, 60), (5, 60), (0.02, 0.15), _STREET, True, "asphalt"),
    ("plaza", (5, 60), (5, 60), (0.02, 0.25), _STREET, True, "paving"),
    ("fence", (0.05, 0.3), (1, 60), (0.8, 2.4), _STREET, False, "metal"),
    ("stairs", (1, 6), (1, 8), (0.3, 4), ("ground", "floor"), False, "concrete"),
)

_FINE: tuple[_Row, ...] = (
    ("car", (3.5, 5), (1.6, 2), (1.3, 1.8), _STREET, True, "metal"),
    ("van", (4.5, 6.5), (1.8, 2.2), (1.9, 2.8), _STREET, True, "metal"),
    ("truck", (6, 10), (2.2, 2.6), (2.6, 4), _STREET, True, "metal"),
    ("bus", (9, 13), (2.4, 2.6), (2.8, 3.4), _STREET, True, "metal"),
    ("bicycle", (1.5, 1.9), (0.4, 0.7), (0.9, 1.2), _STREET, False, "metal"),
    ("tree", (1.5, 8), (1.5, 8), (3, 14), ("ground", "roof"), False, "leaves"),
    ("bush", (0.5, 2.5), (0.5, 2.5), (0.4, 2), ("ground", "roof"), False, "leaves"),
    ("street_lamp", (0.3, 2.5), (0.2, 0.8), (3, 9), _STREET, False, "metal"),
    ("traffic_light", (0.2, 0.6), (0.2, 0.8), (2.4, 5), _STREET, False, "metal"),
    ("sign", (0.05, 0.3), (0.4, 2.5), (1.8, 4), _STREET, False, "metal"),
    ("bench", (0.4, 0.8), (1.2, 2.2), (0.4, 1), ("ground", "roof"), False, "wood"),
    ("bin", (0.35, 0.9), (0.35, 1.3), (0.7, 1.4), ("ground", "floor"), False, "plastic"),
    ("boat", (4, 12), (1.6, 4), (0.8, 9), ("water",), False, "wood"),
    ("planter", (0.4, 1.6), (0.4, 3), (0.5, 1.6), ("ground", "roof", "floor"), False, "leaves"),
    ("crate", (0.6, 1.4), (0.6, 1.4), (0.5, 1.3), ("ground", "floor", "roof"), True, "wood"),
    ("barrel", (0.5, 0.7), (0.5, 0.7), (0.8, 1), ("ground", "floor"), True, "metal"),
    ("pallet", (1, 1.3), (0.8, 1.3), (0.12, 1.4), ("ground", "floor"), True, "wood"),
    ("landing_pad", (1.5, 6), (1.5, 6), (0.03, 0.4), ("ground", "roof"), True, "rubber"),
    ("ac_unit", (0.8, 2.6), (0.8, 2.6), (0.7, 1.8), _ROOF, True, "metal"),
    ("chimney", (0.4, 1.2), (0.4, 1.2), (0.8, 3.5), _ROOF, False, "brick"),
    ("solar_panel", (1, 2.5), (1.5, 6), (0.3, 1.2), _ROOF, False, "glass"),
    ("water_tank", (1.2, 3), (1.2, 3), (1.2, 3.5), ("roof", "ground"), True, "metal"),
    ("antenna", (0.2, 1.2), (0.2, 1.2), (2, 6), _ROOF, False, "metal"),
    ("table", (0.7, 1.4), (0.8, 2.6), (0.68, 0.8), ("floor", "ground", "roof"), True, "wood"),
    ("chair", (0.42, 0.65), (0.4, 0.62), (0.78, 1.1), ("floor", "ground", "roof"), False, "wood"),
    ("sofa", (0.8, 1.05), (1.4, 2.6), (0.7, 0.95), _FLOOR, False, "fabric"),
    ("armchair", (0.75, 1), (0.7, 1), (0.7, 1), _FLOOR, False, "fabric"),
    ("bed", (1.9, 2.2), (0.9, 2), (0.5, 1.1), _FLOOR, True, "fabric"),
    ("desk", (0.6, 0.9), (1.1, 2), (0.7, 0.78), _FLOOR, True, "wood"),
    ("cabinet", (0.35, 0.7), (0.6, 2), (0.7, 1.2), _FLOOR, True, "wood"),
    ("wardrobe", (0.5, 0.7), (0.8, 2.4), (1.8, 2.3), _FLOOR, False, "wood"),
    ("shelf", (0.25, 0.5), (0.6, 2), (1.2, 2.2), _FLOOR, False, "wood"),
    ("coffee_table", (0.5, 0.9), (0.8, 1.4), (0.35, 0.5), _FLOOR, True, "wood"),
    ("nightstand", (0.35, 0.5), (0.4, 0.6), (0.4, 0.65), _FLOOR, False, "wood"),
    ("counter", (0.55, 0.8), (1.2, 4.5), (0.85, 1.1), _FLOOR, True, "stone"),
    ("fridge", (0.6, 0.75), (0.55, 0.95), (1.4, 2), _FLOOR, False, "metal"),
    ("stove", (0.55, 0.7), (0.5, 0.9), (0.85, 0.95), _FLOOR, False, "metal"),
    ("television", (0.05, 0.35), (0.7, 1.7), (0.45, 1.05), _TOP, False, "plastic"),
    ("lamp", (0.25, 0.6), (0.25, 0.6), (0.35, 1.9), ("floor", "furniture"), False, "metal"),
    ("plant", (0.3, 0.9), (0.3, 0.9), (0.4, 1.8), ("floor", "furniture"), False, "leaves"),
    ("laptop", (0.22, 0.3), (0.3, 0.4), (0.18, 0.3), _TOP, False, "metal"),
    ("monitor", (0.15, 0.3), (0.45, 0.9), (0.35, 0.6), _TOP, False, "plastic"),
    ("plate", (0.18, 0.32), (0.18, 0.32), (0.015, 0.05), _TOP, False, "ceramic"),
    ("cup", (0.07, 0.12), (0.07, 0.12), (0.08, 0.14), _TOP, False, "ceramic"),
    ("cutlery", (0.16, 0.24), (0.02, 0.09), (0.006, 0.02), _TOP, False, "metal"),
    ("book", (0.15, 0.3), (0.12, 0.4), (0.02, 0.3), _TOP, False, "paper"),
    ("box", (0.2, 0.7), (0.2, 0.7), (0.15, 0.6), ("floor", "furniture"), False, "cardboard"),
)


CATALOGUE: Mapping[int, Category] = {
    number: Category(number, row[0], "coarse" if number <= COARSE_COUNT else "fine", *row[1:])
    for number, row in enumerate(_COARSE + _FINE, 1)
}
"""Categories under their ids: 1 to 23 coarse, 24 to 70 fine."""


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
