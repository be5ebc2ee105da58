"""Words for the objects of a scene: nouns of kinds, adjectives of colours and forms.

A reader may take one kind for another: a house is a building, and a crate is a box. Such kinds and
colours are listed as pairs. They are neither the same nor surely different, so `grounding` answers
"maybe", and no text depends on the difference.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from itertools import permutations

NOUNS: Mapping[str, tuple[str, str]] = {
    "building": ("building", "buildings"),
    "house": ("house", "houses"),
    "tower": ("tower block", "tower blocks"),
    "warehouse": ("warehouse", "warehouses"),
    "garage": ("garage", "garages"),
    "kiosk": ("kiosk", "kiosks"),
    "container": ("shipping container", "shipping containers"),
    "canopy": ("canopy", "canopies"),
    "bridge": ("footbridge", "footbridges"),
    "deck": ("wooden deck", "wooden decks"),
    "water": ("stretch of water", "stretches of water"),
    "roof": ("roof", "roofs"),
    "room": ("room", "rooms"),
    "sidewalk": ("sidewalk", "sidewalks"),
    "lawn": ("lawn", "lawns"),
    "parking_lot": ("parking lot", "parking lots"),
    "plaza": ("paved square", "paved squares"),
    "terrace": ("raised terrace", "raised terraces"),
    "ramp": ("ramp", "ramps"),
    "mound": ("mound", "mounds"),
    "stairs": ("flight of stairs", "flights of stairs"),
    "car": ("car", "cars"),
    "van": ("van", "vans"),
    "truck": ("truck", "trucks"),
    "bus": ("bus", "buses"),
    "bicycle": ("bicycle", "bicycles"),
    "tree": ("tree", "trees"),
    "bush": ("bush", "bushes"),
    "street_lamp": ("street lamp", "street lamps"),
    "traffic_light": ("traffic light", "traffic lights"),
    "sign": ("sign", "signs"),
    "bench": ("bench", "benches"),
    "bin": ("litter bin", "litter bins"),
    "boat": ("boat", "boats"),
    "planter": ("planter", "planters"),
    "crate": ("crate", "crates"),
    "pallet": ("pallet", "pallets"),
    "landing_pad": ("landing pad", "landing pads"),
    "ac_unit": ("air-conditioning unit", "air-conditioning units"),
    "chimney": ("chimney", "chimneys"),
    "solar_panel": ("solar panel", "solar panels"),
    "water_tank": ("water tank", "water tanks"),
    "toilet": ("toilet", "toilets"),
    "basin": ("washbasin", "washbasins"),
    "table": ("table", "tables"),
    "chair": ("chair", "chairs"),
    "sofa": ("sofa", "sofas"),
    "armchair": ("armchair", "armchairs"),
    "bed": ("bed", "beds"),
    "desk": ("desk", "desks"),
    "cabinet": ("cabinet", "cabinets"),
    "wardrobe": ("wardrobe", "wardrobes"),
    "shelf": ("shelf unit", "shelf units"),
    "coffee_table": ("coffee table", "coffee tables"),
    "counter": ("counter", "counters"),
    "fridge": ("fridge", "fridges"),
    "stove": ("stove", "stoves"),
    "television": ("television", "televisions"),
    "plant": ("potted plant", "potted plants"),
}
"""Noun of each kind that a text may name, and its plural. A kind is a category of the catalogue;
terrain is divided by its form."""

COUNTED = frozenset(
    {
        *("kiosk", "container", "car", "van", "truck", "bus", "bicycle", "tree", "bush", "bench"),
        *("street_lamp", "sign", "bin", "boat", "planter", "crate", "toilet", "pallet", "ac_unit"),
        *("landing_pad", "chimney", "solar_panel", "water_tank", "basin", "table", "chair"),
        *("sofa", "armchair", "bed", "desk", "cabinet", "wardrobe", "shelf", "coffee_table"),
        *("counter", "fridge", "stove", "television", "plant"),
    }
)
"""Kinds that a text may count on a place."""

# Each group stands for all pairs within it. Kinds without nouns are here too, because a reader may
# still see them.
_ALIKE_KINDS = (
    ("building", "house", "tower", "warehouse", "garage"),
    ("kiosk", "garage", "container"),
    *(("roof", each) for each in ("canopy", "building", "house", "tower", "warehouse", "garage")),
    *(("roof", each) for each in ("kiosk", "container", "deck")),
    ("kiosk", "house"),
    ("car", "van"),
    ("van", "truck", "bus"),
    ("table", "desk", "coffee_table", "counter", "nightstand"),
    ("sofa", "armchair", "bed"),
    ("armchair", "chair"),
    ("bench", "chair"),
    ("toilet", "chair"),
    ("basin", "counter"),
    ("cabinet", "wardrobe", "shelf", "counter", "nightstand", "fridge", "stove"),
    ("bush", "planter", "plant", "tree"),
    ("crate", "box", "pallet", "container"),
    ("bin", "water_tank"),
    ("bin", "box"),
    ("deck", "terrace", "bridge"),
    ("terrace", "ramp", "mound", "stairs"),
    ("plaza", "sidewalk", "parking_lot", "road", "terrace"),
    ("lawn", "mound", "terrace"),
    ("street_lamp", "traffic_light", "sign"),
    ("street_lamp", "lamp"),
    ("television", "monitor", "laptop"),
    ("chimney", "ac_unit", "water_tank"),
    ("water_tank", "ac_unit"),
)

# A colour without a word, such as asphalt, is never named in a text.
COLOUR_WORDS: Mapping[str, str] = {
    "paint_red": "red",
    "paint_blue": "blue",
    "paint_white": "white",
    "paint_silver": "silver",
    "paint_black": "black",
    "paint_green": "green",
    "paint_yellow": "yellow",
    "paint_orange": "orange",
    "cream": "cream",
    "sand": "sand-coloured",
    "rose": "pink",
    "sky": "light blue",
    "sage": "pale green",
    "white": "white",
    "ochre": "ochre",
    "slate": "blue-grey",
    "brick": "brick",
    "brickwork": "brick",
    "fabric_teal": "teal",
    "fabric_rust": "rust-red",
    "fabric_navy": "navy blue",
    "fabric_beige": "beige",
    "fabric_moss": "moss green",
    "fabric_plum": "plum-coloured",
    "roof_red": "red",
    "roof_slate": "dark grey",
    "plastic_white": "white",
    "corrugated": "silver",
}
"""Adjective of a material, by its name or by what follows `plaster_` and `facade_` in it."""

_ALIKE_COLOURS = (
    ("white", "cream", "silver"),
    ("cream", "sand-coloured", "beige"),
    ("sand-coloured", "ochre", "beige"),
    ("ochre", "yellow", "orange"),
    ("pink", "brick", "red", "rust-red"),
    ("red", "orange", "rust-red", "brick"),
    ("light blue", "blue-grey", "silver"),
    ("blue", "navy blue", "light blue"),
    ("green", "moss green", "teal", "pale green"),
    ("silver", "blue-grey", "dark grey"),
    ("black", "dark grey", "navy blue"),
    ("plum-coloured", "rust-red", "navy blue"),
    ("teal", "navy blue", "blue"),
    ("yellow", "sand-coloured"),
    ("blue-grey", "blue", "dark grey"),
)

TERRAIN_FORMS = frozenset({"terrace", "ramp", "mound"})
"""Kinds that are forms of terrain, and no categories of their own."""
ON_TOP = frozenset({"car", "van", "truck", "bus", "kiosk", "container", "canopy", "ac_unit"})
"""Kinds on whose top nobody expects to stand, so that a text says "on top of"."""
TOWERING = frozenset({"building", "tower"})
"""Kinds that are too large for a text to speak of the space between two of them."""

COLOURED = frozenset(
    {
        *("building", "house", "tower", "kiosk", "container", "canopy", "car", "van", "truck"),
        *("bus", "crate", "sofa", "armchair", "roof"),
    }
)
"""Kinds whose colour catches the eye, so that a text may name it."""

FORM_WORDS: Mapping[tuple[str, str], tuple[str, str]] = {
    ("landing_pad", "rings"): ("", "with red and white rings"),
    ("landing_pad", "letter"): ("", "with the letter H"),
    ("landing_pad", "cross"): ("", "with a white cross"),
    ("pallet", "boxes"): ("", "loaded with cardboard boxes"),
    ("pallet", "sacks"): ("", "loaded with sacks"),
    ("pallet", "bricks"): ("", "loaded with bricks"),
    ("pallet", "bare"): ("empty", ""),
    ("crate", "plastic"): ("plastic", ""),
    ("crate", "wooden"): ("wooden", ""),
    ("truck", "tanker"): ("tanker", ""),
    ("truck", "flatbed"): ("flatbed", ""),
    ("room", "tiles"): ("", "with the tiled floor"),
    ("room", "carpet"): ("", "with the carpet"),
    ("room", "parquet"): ("", "with the parquet floor"),
    ("room", "concrete"): ("", "with the bare concrete floor"),
    ("roof", "tiled"): ("tiled", ""),
}
"""Words of a form before and after the noun of its kind."""


def _pairs(groups: Iterable[tuple[str, ...]]) -> frozenset[tuple[str, str]]:
    return frozenset(pair for group in groups for pair in permutations(group, 2))


ALIKE_KINDS = _pairs(_ALIKE_KINDS)
"""Pairs of kinds that a reader may take for each other, both ways round."""
ALIKE_TO: Mapping[str, tuple[str, ...]] = {
    kind: tuple(sorted(other for each, other in ALIKE_KINDS if each == kind))
    for kind in sorted({kind for kind, _ in ALIKE_KINDS})
}
"""Kinds that a reader may take for each kind."""
ALIKE_COLOURS = _pairs(_ALIKE_COLOURS)
"""Pairs of colours that a reader may take for each other, both ways round."""
