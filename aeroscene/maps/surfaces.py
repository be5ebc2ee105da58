"""Ground: one base below everything, and covers on it for water, parks, squares and paths.

Covers lie beside each other. If the map has two at one place, the one that people would see wins:
buildings before streets, streets before pavements, and small areas before large ones.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import shapely
from shapely.geometry.base import BaseGeometry

from aeroscene.layouts.ground import cover
from aeroscene.maps import street_facts as facts
from aeroscene.maps.claims import GRID_M, areal_parts, on_grid, opened, split
from aeroscene.maps.document import Feature, Tags
from aeroscene.maps.site import Cover, Site, framed
from aeroscene.maps.tags import length_m

BASE_M = 0.04
"""Thickness of the base."""
_TILE_M = 60.0
_LEAST_M2 = 2.0
_WATERWAYS_M = {"river": 10.0, "canal": 8.0, "stream": 2.0, "ditch": 1.0, "drain": 1.0}
_RAIL_BED_M = 3.2


@dataclass(frozen=True, slots=True)
class _Kind:
    category: str
    finish: str
    thickness_m: float
    rank: int
    """Order of claims: lower ranks win."""


_WATER = _Kind("water", "water", 0.02, 0)
_PARKING = _Kind("parking_lot", "asphalt", 0.02, 1)
_PITCH = _Kind("lawn", "grass", 0.03, 2)
_HARD_PITCH = _Kind("plaza", "red_paving", 0.03, 2)
_SAND = _Kind("plaza", "sand", 0.03, 2)
_PATH = _Kind("sidewalk", "paving", 0.05, 3)
_SQUARE = _Kind("plaza", "paving", 0.05, 4)
_GRASS = _Kind("lawn", "grass", 0.03, 5)
_SOIL = _Kind("lawn", "soil", 0.03, 5)
_YARD = _Kind("plaza", "concrete", 0.02, 6)
_BED = _Kind("plaza", "gravel", 0.02, 5)

_BY_TAG: Mapping[str, Mapping[str, _Kind]] = {
    "natural": {
        "water": _WATER,
        "bay": _WATER,
        "beach": _SAND,
        "sand": _SAND,
        "grassland": _GRASS,
        "heath": _GRASS,
        "scrub": _GRASS,
        "wood": _GRASS,
        "shrubbery": _GRASS,
        "bare_rock": _BED,
        "shingle": _BED,
        "wetland": _GRASS,
    },
    "waterway": {"riverbank": _WATER, "dock": _WATER},
    "leisure": {
        "swimming_pool": _WATER,
        "pitch": _PITCH,
        "playground": _SAND,
        "park": _GRASS,
        "garden": _GRASS,
        "golf_course": _GRASS,
        "common": _GRASS,
        "dog_park": _GRASS,
        "nature_reserve": _GRASS,
        "recreation_ground": _GRASS,
        "track": _HARD_PITCH,
        "outdoor_seating": _SQUARE,
    },
    "amenity": {
        "parking": _PARKING,
        "parking_space": _PARKING,
        "bicycle_parking": _SQUARE,
        "fountain": _WATER,
        "marketplace": _SQUARE,
        "bus_station": _PARKING,
        "fuel": _PARKING,
    },
    "landuse": {
        "grass": _GRASS,
        "meadow": _GRASS,
        "village_green": _GRASS,
        "recreation_ground": _GRASS,
        "cemetery": _GRASS,
        "forest": _GRASS,
        "orchard": _GRASS,
        "allotments": _GRASS,
        "plant_nursery": _SOIL,
        "flowerbed": _SOIL,
        "farmland": _SOIL,
        "vineyard": _SOIL,
        "greenfield": _GRASS,
        "brownfield": _BED,
        "construction": _BED,
        "railway": _BED,
        "basin": _WATER,
        "reservoir": _WATER,
        "industrial": _YARD,
        "commercial": _YARD,
        "retail": _YARD,
        "garages": _YARD,
        "farmyard": _BED,
    },
    "place": {"square": _SQUARE},
    "man_made": {"pier": _SQUARE, "bridge": _SQUARE},
    "railway": {"platform": _SQUARE},
    "public_transport": {"platform": _SQUARE},
    "highway": {
        "pedestrian": _SQUARE,
        "footway": _SQUARE,
        "platform": _SQUARE,
        "path": _SQUARE,
        "service": _PARKING,
        "residential": _PARKING,
        "rest_area": _PARKING,
    },
}
_GRASSY_SPORTS = frozenset(
    {
        "",
        "soccer",
        "football",
        "rugby",
        "baseball",
        "cricket",
        "golf",
        "softball",
        "american_football",
        "australian_football",
        "field_hockey",
        "equestrian",
    }
)


def is_ground(tags: Tags) -> bool:
    """Return true if an area is some kind of ground."""
    return _kind(tags) is not None


def _kind(tags: Tags) -> _Kind | None:
    if tags.get("parking") in {"underground", "multi-storey", "rooftop"}:
        return None
    # A pitch without a sport is usually of grass; the first sport of a list decides.
    if tags.get("leisure") == "pitch" and tags.get("sport", "").split(";")[0] not in _GRASSY_SPORTS:
        return _HARD_PITCH
    return next(
        (kinds[tags[key]] for key, kinds in _BY_TAG.items() if tags.get(key) in kinds), None
    )


def is_strip(tags: Tags) -> bool:
    """Return true if a line is ground with a width: a railway or flowing water.

    Water in a tunnel is none.
    """
    return facts.is_rail(tags) or _is_open_water(tags)


def _is_open_water(tags: Tags) -> bool:
    return tags.get("waterway") in _WATERWAYS_M and tags.get("tunnel", "no") == "no"


def lay_base(site: Site, *, is_town: bool) -> None:
    """Add the ground below everything: grass, or the paving of a town."""
    category, finish = ("plaza", "paving") if is_town else ("lawn", "grass")
    whole = Cover(site.place.area, BASE_M, 0, is_open=True)
    tiles: list[Cover] = []
    # Tiles of 60 m, the longest lawns and plazas of the catalogue.
    for tile in cover(site.place.area, _TILE_M):
        square = shapely.box(*tile)
        frame = framed(square, 0.0, BASE_M, 0.0)
        attributes = {**frame.attributes, "finish": finish}
        number = site.add(category, frame.box, None, None, attributes)
        tiles.append(Cover(square, BASE_M, number, is_open=True))
    site.covers += [whole, *tiles]
    site.n_base = len(tiles)


def lay_surfaces(site: Site, features: Sequence[Feature]) -> None:
    """Add water, parks, squares, paths and so on to the ground that buildings and streets leave."""
    found = [(kind, f, shape) for f in features for kind, shape in _shapes(f)]
    # Small areas before large ones of the same rank: a playground lies in its park.
    for kind, feature, shape in sorted(found, key=lambda each: (each[0].rank, each[2].area)):
        inside = shapely.intersection(shape, site.place.area)
        left = site.ground.unclaimed_part(on_grid(inside))
        for piece in split(opened(left), _LEAST_M2):
            _lay(site, kind, feature, shapely.set_precision(piece, GRID_M))


def _shapes(feature: Feature) -> Iterator[tuple[_Kind, BaseGeometry]]:
    """Kind and area of a feature; lines get the width of their kind."""
    tags, shape = feature.tags, feature.geometry
    if shapely.get_dimensions(shape) == 2:
        kind = _kind(tags)
        if kind is not None:
            yield kind, shape
        return
    if facts.is_path(tags):
        width = facts.path_width_m(tags)
        yield _PATH, shapely.buffer(shape, width / 2, cap_style="flat", quad_segs=3)
    elif facts.is_rail(tags):
        yield _BED, shapely.buffer(shape, _RAIL_BED_M / 2, cap_style="flat")
    elif _is_open_water(tags):
        width = length_m(tags, "width", 0.5, 300) or _WATERWAYS_M[tags["waterway"]]
        yield _WATER, shapely.buffer(shape, width / 2, cap_style="flat", quad_segs=3)


def _lay(site: Site, kind: _Kind, feature: Feature, polygon: BaseGeometry) -> None:
    # Water stays water, whatever surface the map states for it.
    finish = kind.finish if kind is _WATER else facts.finish(feature.tags, kind.finish)
    for part in areal_parts(site.within(polygon), _LEAST_M2 / 2):
        frame = framed(part, BASE_M, BASE_M + kind.thickness_m)
        attributes = {**frame.attributes, "finish": finish}
        number = site.add(kind.category, frame.box, feature, None, attributes)
        site.ground.add(part)
        is_open = kind not in {_WATER, _PARKING}
        site.covers.append(Cover(part, BASE_M + kind.thickness_m, number, is_open))
