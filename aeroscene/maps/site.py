"""The scene in the making: its objects, its ground, and the features that were left out."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from aeroscene.layouts.assembly import Assembly, upright_box
from aeroscene.maps.claims import GRID_M, Claims, areal
from aeroscene.maps.document import Feature
from aeroscene.maps.place import Place
from aeroscene.scene import AttributeValue, OrientedBox, Vector3
from aeroscene.scene.box import quat_from_yaw
from aeroscene.scene.outline import OUTLINE

Attributes = dict[str, AttributeValue]
_RECTANGLE_SHARE = 0.985
_RECTANGLE_M = 0.12
"""Share of a box, and distance from it, from which an outline counts as a rectangle."""
_MOST_NAME = 80


@dataclass(slots=True)
class Cover:
    """A piece of ground with a height of its own."""

    polygon: shapely.Polygon
    top_m: float
    object_id: int
    is_open: bool
    """True if a flight may start there."""


@dataclass(slots=True)
class Site:
    """A place that becomes a scene."""

    place: Place
    assembly: Assembly
    buildings: Claims = field(default_factory=Claims)
    """Footprints of buildings on the ground."""
    carriageways: Claims = field(default_factory=Claims)
    ground: Claims = field(default_factory=Claims)
    """Ground that has a cover or a building."""
    covers: list[Cover] = field(default_factory=list)
    """The whole ground first, then its tiles, then the covers on them."""
    n_base: int = 0
    """Number of the tiles."""
    dropped: Counter[str] = field(default_factory=Counter)
    """Number of features that are not in the scene, under the reason."""
    _tree: shapely.STRtree | None = None
    notes: Counter[str] = field(default_factory=Counter)
    """Number of facts that the map lacks and that were assumed, under a sentence."""

    def within(self, shape: BaseGeometry) -> BaseGeometry:
        """Return the part of an area inside the bounds, its corners on the grid."""
        return areal(shapely.intersection(areal(shape), self.place.area, grid_size=GRID_M))

    def cover_at(self, x_m: float, y_m: float) -> Cover:
        """The uppermost cover at a point; only this method knows heights of the ground.

        If ground were to become uneven, only this method would change: everything that stands on
        the ground asks for the height below it.
        """
        # Covers are only added, so a tree of the same length is up to date.
        if self._tree is None or len(self._tree.geometries) != len(self.covers):
            self._tree = shapely.STRtree([cover.polygon for cover in self.covers])
        found = self._tree.query(shapely.Point(x_m, y_m), predicate="covered_by")
        return self.covers[max(found, default=0)]

    def add(
        self,
        category: str,
        box: OrientedBox,
        feature: Feature | None,
        parent_id: int | None = None,
        attributes: Mapping[str, AttributeValue] | None = None,
    ) -> int:
        """Add an object with the name that the map has for it.

        Args:
            category: Category.
            box: Box of the object.
            feature: Feature of the map; None for objects of our own.
            parent_id: Object that carries it.
            attributes: Further attributes.

        Returns:
            Id of the object.
        """
        named: Attributes = {}
        if feature is not None:
            named["source_id"] = feature.source_id
            if name := feature.tags.get("name"):
                named["source_name"] = _printable(name)
        return self.assembly.add(
            category, box, "outdoor", parent_id, {**named, **(attributes or {})}
        )


def _printable(name: str) -> str:
    return "".join(c for c in name if c.isprintable())[:_MOST_NAME]


@dataclass(frozen=True, slots=True)
class Framed:
    """A polygon in the frame of the box around it."""

    box: OrientedBox
    outline: shapely.Polygon

    @property
    def is_rectangle(self) -> bool:
        """True if the polygon is the box seen from above, within some centimetres.

        Such an object needs no outline of its own.
        """
        x, y, _ = self.box.s
        if self.outline.area < _RECTANGLE_SHARE * x * y:
            return False
        rectangle = shapely.box(-x / 2, -y / 2, x / 2, y / 2)
        return float(shapely.hausdorff_distance(self.outline, rectangle)) < _RECTANGLE_M

    @property
    def attributes(self) -> Attributes:
        """The attribute that gives an object the polygon's form."""
        return {OUTLINE: shapely.to_wkt(self.outline, rounding_precision=2)}


def framed(
    polygon: shapely.Polygon, bottom_m: float, top_m: float, heading_rad: float | None = None
) -> Framed:
    """The smallest box around a polygon, its x axis along the longer side or along a heading.

    Args:
        polygon: Polygon, ENU, m.
        bottom_m: Height of the underside.
        top_m: Height of the upper face.
        heading_rad: Heading of the x axis; along the longer side by default.
    """
    heading = long_axis_rad(polygon) if heading_rad is None else heading_rad
    c, s = math.cos(heading), math.sin(heading)
    turn = np.array([[c, s], [-s, c]])
    turned = shapely.transform(polygon, lambda points: points @ turn.T)
    x0, y0, x1, y1 = turned.bounds
    middle = np.array([(x0 + x1) / 2, (y0 + y1) / 2])
    # Rounded up, so that the rounded outline still fits into its box.
    size: Vector3 = (_upwards(x1 - x0), _upwards(y1 - y0), round(top_m - bottom_m, 3))
    centre = middle @ turn
    box = upright_box((float(centre[0]), float(centre[1])), heading, size, bottom_m)
    local = shapely.set_precision(shapely.transform(turned, lambda p: p - middle), GRID_M)
    # Rounding may split off slivers; the largest part is the outline.
    parts = [part for part in shapely.get_parts(local) if isinstance(part, shapely.Polygon)]
    outline = max(parts, key=lambda part: part.area, default=shapely.box(*turned.bounds))
    return Framed(box, outline)


def _upwards(length_m: float) -> float:
    return max(math.ceil(length_m / GRID_M - 1e-6) * GRID_M, GRID_M)


def long_axis_rad(shape: BaseGeometry) -> float:
    """Direction of the longer side of the smallest rectangle around a shape.

    Args:
        shape: Shape, m.

    Returns:
        Angle from east, rad; its sign along the side is arbitrary.
    """
    (ax, ay), (bx, by), (cx, cy), *_ = shapely.get_coordinates(
        shapely.oriented_envelope(shape)
    ).tolist()
    first, second = (bx - ax, by - ay), (cx - bx, cy - by)
    dx, dy = first if math.hypot(*first) >= math.hypot(*second) else second
    return math.atan2(dy, dx)


def turned_box(box: OrientedBox, yaw_rad: float) -> OrientedBox:
    """Give the same box with another heading.

    Args:
        box: Box.
        yaw_rad: Heading, rad from east.
    """
    return OrientedBox(box.p, quat_from_yaw(yaw_rad), box.s)
