"""Objects at points: benches, lamps, signals, bins, bicycles, kiosks."""

from __future__ import annotations

import math
from collections.abc import Sequence

import shapely
from shapely.geometry.base import BaseGeometry

from aeroscene.layouts.assembly import upright_box
from aeroscene.maps.document import Feature
from aeroscene.maps.point_facts import PointKind, kind_at
from aeroscene.maps.site import Site
from aeroscene.maps.tags import heading_rad, length_m
from aeroscene.scene import Vector3
from aeroscene.scene.catalogue import by_name

_ASIDE_M = 0.6
"""Distance from the kerb of objects that the map has in the middle of a street."""
_FARTHEST_ASIDE_M = 9.0
_LOOKS_FOR_WAY_M = 25.0
_WALL_M = 0.1
"""Least gap to a building's wall."""
_ON_STREET = "in the middle of a street"
_IN_BUILDING = "inside a building"
_AT_BORDER = "reaching beyond the bounds"


def place_furniture(site: Site, features: Sequence[Feature], ways: Sequence[BaseGeometry]) -> None:
    """Add the objects at points.

    Args:
        site: Scene in the making.
        features: Points that are no trees.
        ways: Lines of streets and paths, to which fronts are turned.
    """
    tree = shapely.STRtree(list(ways))
    for feature in features:
        kind = kind_at(feature.tags)
        if kind is None:
            # Addresses, entrances and crossings are points too, without any object.
            continue
        _place(site, feature, kind, tree)


def _place(site: Site, feature: Feature, kind: PointKind, ways: shapely.STRtree) -> None:
    point = feature.geometry.centroid
    moved = _off_the_street(site, point) if kind.is_movable else point
    if moved is None:
        site.dropped[_ON_STREET] += 1
        return
    yaw = heading_rad(feature.tags)
    # The map's own direction counts before a guess.
    if yaw is None:
        yaw = _towards_way(moved, ways) if kind.faces_way else 0.0
    size = _size_m(feature, kind)
    ground = site.cover_at(moved.x, moved.y)
    # The map has the place of the foot, which is not always the middle of the box.
    middle = (
        moved.x - kind.foot_x_m * math.cos(yaw),
        moved.y - kind.foot_x_m * math.sin(yaw),
    )
    box = upright_box(middle, yaw, size, ground.top_m)
    # The turned box decides, not the point.
    outline = shapely.convex_hull(shapely.MultiPoint(box.corners()[:, :2]))
    if not site.place.area.covers(outline):
        site.dropped[_AT_BORDER] += 1
        return
    near = site.buildings.pieces_near(shapely.buffer(outline, _WALL_M))
    if any(shapely.intersects(piece, shapely.buffer(outline, _WALL_M)) for piece in near):
        site.dropped[_IN_BUILDING] += 1
        return
    attributes = {} if kind.form is None else {"form": kind.form}
    site.add(kind.category, box, feature, ground.object_id, attributes)


def _size_m(feature: Feature, kind: PointKind) -> Vector3:
    x, y, z = kind.size_m
    low, high = by_name()[kind.category].height_m
    return (x, y, length_m(feature.tags, "height", low, high) or z)


def _off_the_street(site: Site, point: shapely.Point) -> shapely.Point | None:
    """The point itself, or one beside the carriageway in which it lies; None if that is far."""
    for piece in site.carriageways.pieces_near(point):
        if not shapely.intersects(piece, point):
            continue
        # Off the kerb by `_ASIDE_M` at the nearest place.
        edge = shapely.boundary(shapely.buffer(piece, _ASIDE_M, quad_segs=2))
        at = shapely.Point(shapely.get_coordinates(shapely.shortest_line(edge, point))[0])
        return at if at.distance(point) <= _FARTHEST_ASIDE_M else None
    return point


def _towards_way(point: shapely.Point, ways: shapely.STRtree) -> float:
    """Heading from a point to the nearest street or path, rad; 0 without one nearby."""
    row = ways.query_nearest(point, max_distance=_LOOKS_FOR_WAY_M, all_matches=False)
    if not len(row):
        return 0.0
    line = shapely.shortest_line(point, ways.geometries[row[0]])
    (ax, ay), (bx, by) = shapely.get_coordinates(line).tolist()
    return math.atan2(by - ay, bx - ax)
