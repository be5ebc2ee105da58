"""Facts about a building from its tags: use, height, and form of its roof.

The keys are those of OpenStreetMap's "Simple 3D buildings": `height` is the height of the highest
point, and `building:levels` counts storeys without those in the roof. Mappers leave most keys out,
so every fact has a usual value for the kind of building.
"""

from __future__ import annotations

import math
from typing import Literal, TypedDict

import shapely

from aeroscene.maps.document import Tags
from aeroscene.maps.tags import length_m, number

RoofForm = Literal["flat", "gable", "hip", "shed"]
STOREY_M = 3.0
MOST_HEIGHT_M = 300.0
_NO = frozenset({"no", "demolished", "proposed", "razed", "entrance"})
_CATEGORIES = {
    "garage": (
        "garage",
        "garages",
        "shed",
        "hut",
        "carport",
        "toilets",
        "service",
        "transformer_tower",
    ),
    "warehouse": (
        "barn",
        "cowshed",
        "farm_auxiliary",
        "greenhouse",
        "hangar",
        "industrial",
        "manufacture",
        "stable",
        "storage_tank",
        "sty",
        "warehouse",
    ),
    "canopy": ("roof", "canopy", "gazebo"),
    "kiosk": ("kiosk",),
    "house": (
        "bungalow",
        "cabin",
        "detached",
        "farm",
        "house",
        "houseboat",
        "semidetached_house",
        "static_caravan",
        "terrace",
        "villa",
    ),
}
_LEVELS = {
    "apartments": 4,
    "bungalow": 1,
    "cabin": 1,
    "cathedral": 6,
    "chapel": 2,
    "church": 4,
    "commercial": 3,
    "detached": 2,
    "dormitory": 4,
    "farm": 2,
    "government": 4,
    "hospital": 4,
    "hotel": 5,
    "house": 2,
    "kindergarten": 1,
    "mosque": 4,
    "office": 4,
    "residential": 3,
    "retail": 2,
    "school": 2,
    "semidetached_house": 2,
    "supermarket": 2,
    "temple": 3,
    "terrace": 2,
    "train_station": 3,
    "university": 4,
    "yes": 2,
}
_HEIGHTS_M = {"garage": 2.7, "warehouse": 7.0, "canopy": 4.0, "kiosk": 3.0}
"""Heights of categories whose storeys do not determine them."""
_ROOFS: dict[str, RoofForm] = {
    "flat": "flat",
    "gabled": "gable",
    "gambrel": "gable",
    "half-hipped": "gable",
    "saltbox": "gable",
    "double_saltbox": "gable",
    "round": "gable",
    "hipped": "hip",
    "pyramidal": "hip",
    "mansard": "hip",
    "dome": "hip",
    "onion": "hip",
    "cone": "hip",
    "conical": "hip",
    "side_hipped": "hip",
    "hipped-and-gabled": "hip",
    "skillion": "shed",
    "lean_to": "shed",
    "shed": "shed",
}
_HOUSE_M2 = 250.0
"""Footprint up to which a house has a gable if the map states no roof."""
_RISES = {"gable": (0.3, 4.0), "hip": (0.28, 4.0), "shed": (0.12, 2.5), "flat": (0.0, 0.0)}
"""Rise of a roof as a share of the shorter side, and its greatest value, m."""


class Heights(TypedDict):
    """Fields of a block that depend on its heights."""

    bottom_m: float
    eaves_m: float
    top_m: float
    roof: RoofForm
    has_known_height: bool


def is_building(tags: Tags) -> bool:
    """Return true if tags describe a building, or a part of one, above the ground."""
    # A negative layer lies below the ground.
    kinds = [tags.get(key, "no") for key in ("building", "building:part")]
    is_below = tags.get("location") == "underground" or (number(tags, "layer", -9, 9) or 0) < 0
    return any(kind not in _NO for kind in kinds) and not is_below


def is_part(tags: Tags) -> bool:
    """Return true if an area is part of a building that is mapped as a whole too."""
    return tags.get("building:part", "no") not in _NO and "building" not in tags


def _kind(tags: Tags) -> str:
    found = tags.get("building:part" if is_part(tags) else "building", "yes")
    return "yes" if found in {"part", "base", "main"} else found


def category(tags: Tags) -> str | None:
    """Find our category for the building's use.

    Args:
        tags: Tags of the building.

    Returns:
        Category; None if the building's size decides, as it does for houses and blocks of flats.
    """
    kind = _kind(tags)
    return next((ours for ours, kinds in _CATEGORIES.items() if kind in kinds), None)


def is_ordinary(tags: Tags) -> bool:
    """Return true if nothing suggests that a building's height differs from its neighbours'."""
    return category(tags) is None and _kind(tags) in {"yes", "residential", "apartments"}


def heights(tags: Tags, polygon: shapely.Polygon) -> Heights:
    """Heights above the ground, m, and the form of the roof.

    Args:
        tags: Tags of the building.
        polygon: Its outline, m.
    """
    roof = _roof(tags, polygon)
    rise_m = _rise_m(tags, polygon, roof)
    total_m = length_m(tags, "height", 0.5, MOST_HEIGHT_M)
    levels = number(tags, "building:levels", 0.5, 120)
    # An older key, which only counts if the newer ones are missing.
    if total_m is None and levels is None:
        total_m = length_m(tags, "building:height", 0.5, MOST_HEIGHT_M)
    bottom_m = length_m(tags, "min_height", 0.0, MOST_HEIGHT_M) or STOREY_M * (
        number(tags, "building:min_level", 0, 100) or 0.0
    )
    known = total_m is not None or levels is not None
    if total_m is None:
        eaves_m = STOREY_M * levels + 0.3 if levels is not None else _usual_m(tags)
        total_m = eaves_m + rise_m
    else:
        # A stated height includes the roof; walls get at least half of it.
        rise_m = min(rise_m, 0.5 * total_m)
        eaves_m = total_m - rise_m
    # A body without a metre of height below its roof stands on the ground instead.
    if eaves_m < bottom_m + 1.0:
        bottom_m = 0.0
    return Heights(
        bottom_m=round(bottom_m, 2),
        eaves_m=round(eaves_m, 2),
        top_m=round(total_m, 2),
        roof=roof,
        has_known_height=known,
    )


def _usual_m(tags: Tags) -> float:
    ours = category(tags)
    if ours in _HEIGHTS_M:
        return _HEIGHTS_M[ours]
    return STOREY_M * _LEVELS.get(_kind(tags), 2) + 0.3


def _roof(tags: Tags, polygon: shapely.Polygon) -> RoofForm:
    named = tags.get("roof:shape", tags.get("building:roof:shape", ""))
    if named in _ROOFS:
        return _ROOFS[named]
    is_small = polygon.area <= _HOUSE_M2
    return "gable" if is_small and not named and category(tags) == "house" else "flat"


def _rise_m(tags: Tags, polygon: shapely.Polygon, roof: RoofForm) -> float:
    """Height of the roof above the walls, m."""
    if roof == "flat":
        return 0.0
    # A stated height counts before an angle, and an angle before a number of levels.
    stated = length_m(tags, "roof:height", 0.1, 60.0)
    levels = number(tags, "roof:levels", 0.5, 10)
    short_m = _short_side_m(polygon)
    angle_deg = number(tags, "roof:angle", 1.0, 80.0)
    if stated is None and angle_deg is not None:
        # A shed roof rises over the whole side, the others from both sides to the middle.
        reach_m = short_m if roof == "shed" else short_m / 2
        stated = min(60.0, reach_m * math.tan(math.radians(angle_deg)))
    if stated is None and levels is not None:
        stated = STOREY_M * levels
    # At least 0.4 m, so that a pitched roof shows.
    share, most_m = _RISES[roof]
    return round(max(0.4, min(share * short_m, most_m) if stated is None else stated), 2)


def _short_side_m(polygon: shapely.Polygon) -> float:
    """Shorter side of the smallest rectangle around a polygon, m."""
    corners = shapely.get_coordinates(shapely.oriented_envelope(polygon)).tolist()
    return min(math.dist(corners[0], corners[1]), math.dist(corners[1], corners[2]))
