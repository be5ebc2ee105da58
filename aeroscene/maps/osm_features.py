"""OpenStreetMap's elements as features: areas from closed ways and from rings of relations.

OpenStreetMap has no areas. A closed way is an area or a ring-shaped line, depending on its tags,
and an area with courtyards is a relation of ways.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence

import shapely
from shapely.geometry.base import BaseGeometry

from aeroscene.maps.document import Feature, RawMap, Tags
from aeroscene.maps.osm_data import OsmData, Relation, Way

_AREA_KEYS = (
    "building",
    "building:part",
    "landuse",
    "amenity",
    "water",
    "place",
    "tourism",
    "parking",
    "shop",
    "office",
    "man_made",
    "historic",
    "public_transport",
    "power",
)
"""Keys that turn a closed way into an area."""
_LINES = {
    "natural": frozenset({"tree_row", "coastline", "cliff", "ridge", "valley"}),
    "leisure": frozenset({"track", "slipway"}),
    "waterway": frozenset({"river", "stream", "canal", "ditch", "drain"}),
    "man_made": frozenset({"pipeline", "embankment", "cutline"}),
}
"""Keys that also turn a closed way into an area, with the values for which it stays a line."""
_AREA_RELATIONS = frozenset({"multipolygon", "boundary"})
_MISSING = "with references to nodes or ways that the map does not hold"
_BROKEN = "with an outline that is not closed"


def features_of(data: OsmData) -> RawMap:
    """Features of a file's elements.

    Relations of relations are not followed, so that references cannot loop.
    """
    dropped: Counter[str] = Counter()
    features = [*_points(data), *_ways(data, dropped), *_areas(data, dropped)]
    return RawMap(features=tuple(features), bounds=data.bounds, dropped=dropped)


def _points(data: OsmData) -> Iterator[Feature]:
    for number, tags in data.node_tags.items():
        point = shapely.Point(data.nodes[number])
        yield Feature(source_id=f"node/{number}", tags=tags, geometry=point)


def _ways(data: OsmData, dropped: Counter[str]) -> Iterator[Feature]:
    for number, way in data.ways.items():
        if not way.tags:
            continue
        line = _line(data, way)
        if len(line) < 2:
            dropped[_MISSING] += 1
            continue
        is_area = len(line) > 3 and line[0] == line[-1] and _is_area(way.tags)
        # Three corners and the repeated first one.
        shape = shapely.Polygon(line) if is_area else shapely.LineString(line)
        yield Feature(source_id=f"way/{number}", tags=way.tags, geometry=shape)


def _line(data: OsmData, way: Way) -> list[tuple[float, float]]:
    return [data.nodes[node] for node in way.nodes if node in data.nodes]


def _is_area(tags: Tags) -> bool:
    if tags.get("area") in {"yes", "no"}:
        return tags["area"] == "yes"
    if any(tags.get(key) in values for key, values in _LINES.items()):
        return False
    return any(key in tags for key in (*_AREA_KEYS, *_LINES))


def _areas(data: OsmData, dropped: Counter[str]) -> Iterator[Feature]:
    for number, relation in data.relations.items():
        if relation.tags.get("type") not in _AREA_RELATIONS:
            continue
        tags = {key: value for key, value in relation.tags.items() if key != "type"}
        rings: dict[str, list[BaseGeometry]] = {"outer": [], "inner": []}
        is_whole = True
        for way, role in _members(data, relation):
            is_whole &= way is not None
            # Ways that reach beyond the file have lost nodes; what is left of them is kept.
            line = [] if way is None else _line(data, way)
            if len(line) >= 2:
                rings["inner" if role == "inner" else "outer"].append(shapely.LineString(line))
                # In older maps the outer way carries the tags of the area.
                tags = {**way.tags, **tags} if way and not tags and role != "inner" else tags
        # Borders of towns and countries are lines on paper, without anything to build.
        if not tags or tags.get("boundary") == "administrative":
            continue
        shape = _assembled(rings["outer"], rings["inner"])
        if shape.is_empty:
            dropped[_BROKEN if is_whole else _MISSING] += 1
            continue
        yield Feature(source_id=f"relation/{number}", tags=tags, geometry=shape)


def _members(data: OsmData, relation: Relation) -> Iterator[tuple[Way | None, str]]:
    for kind, number, role in relation.members:
        if kind == "way":
            yield data.ways.get(number), role


def _assembled(outer: Sequence[BaseGeometry], inner: Sequence[BaseGeometry]) -> BaseGeometry:
    """Area between outer and inner rings, each of which may consist of several lines."""
    area = _filled(outer)
    return shapely.difference(area, _filled(inner)) if inner else area


def _filled(lines: Sequence[BaseGeometry]) -> BaseGeometry:
    found = shapely.get_parts(shapely.polygonize(lines))
    # Without holes: inner rings are cut out afterwards.
    rings = [shapely.Polygon(polygon.exterior) for polygon in found]
    return shapely.union_all(rings) if rings else shapely.Polygon()
