"""Floor plans: rooms with a use, walls and doors, to be furnished by the model.

GeoJSON files state them in OpenStreetMap's Simple Indoor Tagging: areas with `indoor=room`,
`corridor` or `area`, whose use is in `room`, and points with `door`. If there are several storeys,
the lowest one above the ground is taken. Any layout with rooms (`aeroscene.layouts`) is a plan too;
its furniture is left out.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import shapely

from aeroscene.files import UnpackError, read_bounded
from aeroscene.files.names import file_name
from aeroscene.layouts.document import LayoutError, LayoutRoom, NeutralLayout
from aeroscene.layouts.flyable import make_flyable
from aeroscene.layouts.reader import pick_layout
from aeroscene.layouts.uses import room_use
from aeroscene.maps.bounds import Bounds
from aeroscene.maps.document import Feature, MapError
from aeroscene.maps.geojson import MOST_GEOJSON_BYTES, read_geojson
from aeroscene.maps.site import long_axis_rad
from aeroscene.maps.tags import number
from aeroscene.scene import Scene, SceneObject
from aeroscene.scene.catalogue import ROOMS
from aeroscene.scene.origin import metres_per_degree

_ROOM_KINDS = frozenset({"room", "corridor", "area"})
_LEAST_M2 = 1.0
_SIMPLIFY_M = 0.05
_MOST_SIDE_M = 160.0


def open_plan(spec: str) -> Scene:
    """Open a floor plan as a scene: rooms with their uses, walls, doors, a roof, a yard.

    Args:
        spec: `FILE.geojson`, or a file of layouts with rooms, also as FILE#ID.

    Raises:
        SceneError: If the file breaks a rule or has no rooms.
    """
    path, _, scene_id = spec.partition("#")
    # The end of the name also covers `.geojson.gz`.
    if ".geojson" in path[-11:]:
        layout, origin = _from_geojson(Path(path))
    else:
        layout, origin = pick_layout(path, scene_id or None), None
    if not layout.rooms:
        raise LayoutError(f"plan {spec!r} has no rooms; valid: areas with a use, see docs/maps.md")
    scene, _ = make_flyable(replace(layout, objects=(), domain="indoor"))
    scene = replace(scene, objects=tuple(map(_with_use, scene.objects)))
    if origin is None:
        return scene
    return replace(scene, longitude_deg=origin[0], latitude_deg=origin[1], altitude_m=0.0)


def _with_use(obj: SceneObject) -> SceneObject:
    """Give a room its use if its name states one."""
    use = room_use(str(obj.attributes.get("room_type", ""))) if obj.category in ROOMS else None
    return obj if use is None else replace(obj, attributes={**obj.attributes, "use": use})


def _from_geojson(path: Path) -> tuple[NeutralLayout, tuple[float, float]]:
    """Rooms and doors of a GeoJSON file in metres, and the place of their middle in degrees."""
    where = f"plan {str(path)!r}"
    try:
        raw = read_geojson(read_bounded(path, MOST_GEOJSON_BYTES), where)
    except UnpackError as error:
        raise MapError(f"{where}: {error}") from None
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise MapError(f"{where} cannot be read ({reason}); valid: a floor plan") from None
    features = _of_lowest_storey(raw.features)
    # Furniture and other features are left out.
    rooms = [f for f in features if _is_room(f)]
    if not rooms:
        raise MapError(f"{where} has no rooms; valid: polygons with indoor=room or room=USE")
    points = [f.geometry.centroid for f in features if _is_door(f)]
    bounds = Bounds(*shapely.total_bounds(np.array([f.geometry for f in rooms])).tolist())
    if max(bounds.size_m) > _MOST_SIDE_M:
        longest = f"{max(bounds.size_m):.0f} m"
        raise MapError(f"{where} is {longest} long; valid: at most {_MOST_SIDE_M:g} m")
    outlines, doors = _in_metres([f.geometry for f in rooms], points, bounds)
    layout = NeutralLayout(
        scene_id=file_name(path.name.partition(".")[0], "plan"),
        source="GeoJSON",
        domain="indoor",
        floor=(),
        objects=(),
        rooms=tuple(
            LayoutRoom(name=_name(feature), polygon=_corners(outline))
            for feature, outline in zip(rooms, outlines, strict=True)
            if outline.area >= _LEAST_M2
        ),
        doors=tuple((door.x, door.y) for door in doors),
    )
    return layout, (bounds.longitude_deg, bounds.latitude_deg)


def _is_room(feature: Feature) -> bool:
    tags = feature.tags
    is_named = tags.get("indoor") in _ROOM_KINDS or "room" in tags or "use" in tags
    return is_named and isinstance(feature.geometry, shapely.Polygon)


def _is_door(feature: Feature) -> bool:
    is_door = feature.tags.get("door", "no") != "no" or "entrance" in feature.tags
    return is_door and feature.geometry.geom_type in {"Point", "LineString"}


def _name(feature: Feature) -> str:
    tags = feature.tags
    named = tags.get("room", tags.get("use", ""))
    usual = "corridor" if tags.get("indoor") == "corridor" else tags.get("name", "room")
    return (named if named not in {"", "yes"} else usual)[:80]


def _of_lowest_storey(features: Sequence[Feature]) -> list[Feature]:
    """Features of the lowest storey from the ground up; those without a storey are on each."""
    levels = {level for f in features if (level := number(f.tags, "level", -20, 200)) is not None}
    # A map of cellars alone gives the uppermost of them.
    lowest = min((level for level in levels if level >= 0), default=max(levels, default=0.0))
    return [f for f in features if number(f.tags, "level", -20, 200) in {None, lowest}]


def _in_metres(
    areas: Sequence[shapely.Geometry], points: Sequence[shapely.Geometry], bounds: Bounds
) -> tuple[list[shapely.Polygon], list[shapely.Point]]:
    """Shapes about the middle of the plan, turned so that its longer side runs east.

    Floors consist of rectangles along the axes, so slanted walls would become steps.
    """
    north_m, east_m = metres_per_degree(bounds.latitude_deg, 0.0)
    origin = np.array([bounds.longitude_deg, bounds.latitude_deg])
    scale = np.array([east_m, north_m])
    flat = shapely.transform(np.array([*areas, *points]), lambda p: (p - origin) * scale)
    heading = long_axis_rad(shapely.union_all(flat[: len(areas)]))
    c, s = math.cos(heading), math.sin(heading)
    turned = shapely.transform(flat, lambda p: p @ np.array([[c, -s], [s, c]]))
    outlines = [shapely.simplify(shape, _SIMPLIFY_M) for shape in turned[: len(areas)]]
    return outlines, list(turned[len(areas) :])


def _corners(outline: shapely.Polygon) -> tuple[tuple[float, float], ...]:
    ring = shapely.orient_polygons(outline).exterior
    return tuple((round(x, 3), round(y, 3)) for x, y in list(ring.coords)[:-1])
