"""Features of a map in metres, within its bounds."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from aeroscene.maps.bounds import ALTITUDE_M, Bounds
from aeroscene.maps.document import Feature, RawMap
from aeroscene.scene.origin import metres_per_degree

_MOST_CORNERS = 5_000
"""Most corners of one feature within the bounds; a lake's shore has some hundreds there."""
_BROKEN = "crossing themselves or without area"
_LARGE = f"with more than {_MOST_CORNERS} corners"


@dataclass(frozen=True, slots=True, kw_only=True)
class Place:
    """A rectangle of the world about the origin, and the features in it."""

    bounds: Bounds
    area: shapely.Polygon
    """The rectangle, ENU, m."""
    features: tuple[Feature, ...]
    """Features with geometries in ENU, m. Areas are cut at the rectangle, lines extend a little
    beyond it.
    """
    dropped: Counter[str] = field(default_factory=Counter)


def locate(raw: RawMap, bounds: Bounds) -> Place:
    """Project a map to the plane tangent at the middle of some bounds, and cut it there.

    Flights use the same plane (`flightsim.frames.LocalFrame`), so that a vehicle above a corner of
    a building reports that corner's latitude and longitude.

    Args:
        raw: Features in degrees.
        bounds: Rectangle of the place.
    """
    north_m, east_m = metres_per_degree(bounds.latitude_deg, ALTITUDE_M)
    origin = np.array([bounds.longitude_deg, bounds.latitude_deg])
    scale = np.array([east_m, north_m])
    # Centimetres, because the border becomes the scene's extent.
    corners = (np.array([bounds.values[:2], bounds.values[2:]]) - origin) * scale
    area = shapely.box(*np.round(corners.ravel(), 2).tolist())
    reach = shapely.box(*bounds.grown(_REACH_M).values)
    shapes = np.array([f.geometry for f in raw.features], dtype=object)
    dropped = Counter(raw.dropped)
    found: list[Feature] = []
    # Bounding boxes first: most features of a file lie far away.
    for row in np.flatnonzero(shapely.intersects(reach, shapely.envelope(shapes))):
        feature = raw.features[row]
        shape = shapely.transform(feature.geometry, lambda points: (points - origin) * scale)
        cut = _cut(shape, area, dropped)
        if cut is not None:
            found.append(Feature(source_id=feature.source_id, tags=feature.tags, geometry=cut))
    return Place(bounds=bounds, area=area, features=tuple(found), dropped=dropped)


_REACH_M = 15.0
"""Distance beyond the rectangle up to which lines are kept: a street outside may have its pavement
inside.
"""


def _cut(shape: BaseGeometry, area: shapely.Polygon, dropped: Counter[str]) -> BaseGeometry | None:
    """The part of a shape in the rectangle; None without one."""
    if shapely.get_num_coordinates(shape) > 20 * _MOST_CORNERS:
        dropped[_LARGE] += 1
        return None
    is_areal = shapely.get_dimensions(shape) == 2
    if is_areal and not shape.is_valid:
        # Self-crossing outlines are frequent in maps; most can be repaired.
        shape = shapely.make_valid(shape, method="structure", keep_collapsed=False)
        if shape.is_empty or shapely.get_dimensions(shape) < 2:
            dropped[_BROKEN] += 1
            return None
    rectangle = (
        # Areas end at the border. Lines reach beyond it, because their width is added later.
        area
        if shapely.get_dimensions(shape) != 1
        else shapely.buffer(area, _REACH_M, join_style="mitre")
    )
    if shapely.covers(rectangle, shape):
        return shape
    cut = shapely.intersection(shape, rectangle)
    wanted = shapely.get_dimensions(shape)
    parts = [
        p for p in shapely.get_parts(cut) if shapely.get_dimensions(p) == wanted and not p.is_empty
    ]
    if not parts:
        return None
    if shapely.get_num_coordinates(cut) > _MOST_CORNERS:
        dropped[_LARGE] += 1
        return None
    if len(parts) == 1:
        return parts[0]
    return shapely.MultiLineString(parts) if wanted == 1 else shapely.MultiPolygon(parts)
