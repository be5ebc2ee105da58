"""GeoJSON as Overpass, osmtogeojson and cities publish it (RFC 7946: longitude, latitude).

Files of cities rarely use OpenStreetMap's keys. A polygon with any kind of height therefore counts
as a building.
"""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterator, Mapping
from typing import Any

import msgspec
import shapely
from shapely.geometry.base import BaseGeometry

from aeroscene.files.bounds import excess
from aeroscene.maps.document import Feature, MapError, RawMap
from aeroscene.maps.osm_data import require_place
from aeroscene.scene.errors import shown

MOST_GEOJSON_BYTES = 64 << 20
_MOST_VALUES = 8_000_000
_MOST_FEATURES = 300_000
_DEPTHS = {
    "Point": 0,
    "MultiPoint": 1,
    "LineString": 1,
    "MultiLineString": 2,
    "Polygon": 2,
    "MultiPolygon": 3,
}
"""Depth of a geometry's nested lists of positions."""
_MOST_PARTS = 32
"""Most geometries of one collection; collections within collections are left out."""
_HEIGHT = re.compile(r"(?:building_?)?(?:height|hoehe|measured_?height|render_height)(?:_m)?")
_NULL = "without a geometry"
_UNKNOWN = "of an unknown type of geometry"


def read_geojson(data: bytes, where: str) -> RawMap:
    """Read the features of a GeoJSON text.

    Args:
        data: The text, UTF-8.
        where: Name of the file in errors.

    Raises:
        MapError: If the text breaks a rule; it names file, feature and field.
    """
    if (fault := excess(data, MOST_GEOJSON_BYTES, _MOST_VALUES)) is not None:
        raise MapError(f"{where} {fault}")
    try:
        value = msgspec.json.decode(data)
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
        reason = str(error).removeprefix("JSON is malformed: ")
        raise MapError(f"{where} is not JSON or not all of it ({reason}); valid: GeoJSON") from None
    try:
        return _collection(value)
    except MapError as error:
        raise error.within(where) from None


def _collection(value: object) -> RawMap:
    record = value if isinstance(value, dict) else {}
    found = [record] if record.get("type") == "Feature" else record.get("features")
    if record.get("type") not in {"Feature", "FeatureCollection"} or not isinstance(found, list):
        raise MapError(f"type is {shown(record.get('type'))}; valid: 'FeatureCollection'")
    if len(found) > _MOST_FEATURES:
        raise MapError(f"features are {len(found)}; valid: at most {_MOST_FEATURES}")
    dropped: Counter[str] = Counter()
    features = [f for n, entry in enumerate(found) for f in _features(entry, n, dropped)]
    return RawMap(features=tuple(features), bounds=None, dropped=dropped)


def _features(entry: object, number: int, dropped: Counter[str]) -> Iterator[Feature]:
    if not isinstance(entry, dict):
        raise MapError(f"features[{number}] is {shown(entry)}; valid: a JSON object")
    properties = entry.get("properties")
    properties = properties if isinstance(properties, dict) else {}
    # osmtogeojson writes `@id`; other programs have an id of GeoJSON, or none.
    name = properties.get("@id", entry.get("id"))
    source_id = f"feature/{number}" if name is None else str(name)[:80]
    shapes = list(_shapes(entry.get("geometry"), f"features[{number}].geometry", dropped))
    tags = _tags(properties, is_area=any(shape.area for shape in shapes))
    for shape in shapes:
        yield Feature(source_id=source_id, tags=tags, geometry=shape)


def _tags(properties: Mapping[str, Any], *, is_area: bool) -> dict[str, str]:
    """Tags of a feature; files of buildings alone often have a height and no tag."""
    nested = properties.get("tags")
    # Overpass nests the tags, other programs spread them over the properties.
    plain = nested if isinstance(nested, dict) else properties
    tags = {
        str(key): _text(value)
        for key, value in plain.items()
        # A bool is an int in Python, but no value of a tag.
        if isinstance(value, str | int | float) and not isinstance(value, bool)
    }
    if is_area and "building" not in tags and "building:part" not in tags:
        named = next((key for key in tags if _HEIGHT.fullmatch(key.lower())), None)
        # Trees and fences have heights, too.
        if named is not None and not {"natural", "barrier", "highway", "man_made"} & tags.keys():
            tags = {**tags, "building": "yes", "height": tags[named]}
    return tags


def _text(value: str | float) -> str:
    return value if isinstance(value, str) else f"{value:g}" if abs(value) < 1e6 else str(value)


def _shapes(geometry: object, where: str, dropped: Counter[str]) -> Iterator[BaseGeometry]:
    if geometry is None:
        dropped[_NULL] += 1
        return
    if not isinstance(geometry, dict):
        raise MapError(f"{where} is {shown(geometry)}; valid: a JSON object")
    kind = geometry.get("type")
    if kind == "GeometryCollection":
        parts = geometry.get("geometries")
        for part in parts[:_MOST_PARTS] if isinstance(parts, list) else []:
            if isinstance(part, dict) and part.get("type") != kind:
                yield from _shapes(part, where, dropped)
        return
    if not isinstance(kind, str) or kind not in _DEPTHS:
        dropped[_UNKNOWN] += 1
        return
    positions = _positions(geometry.get("coordinates"), _DEPTHS[kind], f"{where}.coordinates")
    yield from _built(kind, positions, f"{where}.coordinates")


def _positions(value: object, depth: int, where: str) -> Any:
    """Coordinates with every position checked and cut to longitude and latitude."""
    if depth:
        if not isinstance(value, list):
            raise MapError(f"{where} is {shown(value)}; valid: a list of positions")
        return [_positions(part, depth - 1, where) for part in value]
    ok = isinstance(value, list) and len(value) >= 2
    pair = value[:2] if ok and isinstance(value, list) else []
    if len(pair) < 2 or not all(isinstance(v, int | float) for v in pair):
        raise MapError(f"{where} has the position {shown(value)}; valid: longitude, latitude")
    longitude, latitude = float(pair[0]), float(pair[1])
    # Metres of a projected system are far beyond any degrees, which deserves its own message.
    if math.hypot(longitude, latitude) > 360:
        raise MapError(
            f"{where} has the position {shown(value)}; valid: longitude, latitude in degrees "
            "(ogr2ogr -t_srs EPSG:4326 converts other coordinates)"
        )
    require_place(longitude, latitude, where)
    return (longitude, latitude)


def _built(kind: str, positions: Any, where: str) -> Iterator[BaseGeometry]:
    try:
        match kind:
            case "Point":
                yield shapely.Point(positions)
            case "MultiPoint":
                yield from map(shapely.Point, positions)
            case "LineString":
                yield shapely.LineString(positions)
            case "MultiLineString":
                yield from map(shapely.LineString, positions)
            case "Polygon":
                yield shapely.Polygon(positions[0], positions[1:])
            case _:
                polygons = [shapely.Polygon(rings[0], rings[1:]) for rings in positions]
                yield shapely.MultiPolygon(polygons)
    except (ValueError, IndexError, TypeError, shapely.errors.GEOSException):
        valid = "lines of at least 2 and rings of at least 4 positions"
        raise MapError(f"{where} is no {kind}; valid: {valid}") from None
