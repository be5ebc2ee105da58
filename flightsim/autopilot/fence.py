"""Geofences and rally points uploaded by ground stations, stored in metres.

A fence is converted once, when it is uploaded. Each check of a position is then a loop over plain
floats, which runs in every failsafe check. Lines and routes need areas: shapely builds them when
they are first asked for, because most flights never ask.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from autonomy.types import Vector3
from flightsim.autopilot.mission_check import check_horizontal_place, unsupported_command
from flightsim.autopilot.mission_item import Cmd, MissionError, MissionFault, MissionItem
from flightsim.frames import Geodetic, LocalFrame

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry

# Bounds on what clients can make the vehicle store and check.
MAX_FENCE_ITEMS = 500
MAX_RALLY_ITEMS = 100

Point2 = tuple[float, float]

EVERYWHERE_M = 2e5
"""Half the side of the square that stands for the unbounded plane, where no inclusion is uploaded.
"""
_FINE_QUADRANT, _EDGE_M = 64, 0.1
"""Sides of a quadrant of a circle, and distance from the edge up to which a line counts as inside.
The polygon of a circle of 1 km lies 8 cm inside it, so a line along the edge must not fail."""

# Command, and true if the vehicle must stay inside.
_POLYGONS = {Cmd.FENCE_POLYGON_INCLUSION: True, Cmd.FENCE_POLYGON_EXCLUSION: False}
_CIRCLES = {Cmd.FENCE_CIRCLE_INCLUSION: True, Cmd.FENCE_CIRCLE_EXCLUSION: False}


@dataclass(frozen=True, slots=True)
class PolygonFence:
    """Closed polygon in the horizontal plane; the vehicle must stay inside or outside.

    Attributes:
        vertices_enu_m: East and north of the corners, in order; the last one joins the first.
        is_inclusion: True if the vehicle must stay inside.
    """

    vertices_enu_m: tuple[Point2, ...]
    is_inclusion: bool

    def contains(self, east_m: float, north_m: float) -> bool:
        """Return true if a point lies inside, by the even-odd rule.

        Args:
            east_m: East of the scene's origin.
            north_m: North of the scene's origin.
        """
        is_inside = False
        x0, y0 = self.vertices_enu_m[-1]
        for x1, y1 in self.vertices_enu_m:
            # One end of the edge is north of the point and the other is not: a ray to the east may
            # cross.
            if (y0 > north_m) != (y1 > north_m):
                crossing_m = x0 + (north_m - y0) / (y1 - y0) * (x1 - x0)
                is_inside ^= east_m < crossing_m
            x0, y0 = x1, y1
        return is_inside


@dataclass(frozen=True, slots=True)
class CircleFence:
    """Circle in the horizontal plane; the vehicle must stay inside or outside.

    Attributes:
        centre_enu_m: East and north of the centre.
        radius_m: Radius; 0 is valid.
        is_inclusion: True if the vehicle must stay inside.
    """

    centre_enu_m: Point2
    radius_m: float
    is_inclusion: bool

    def contains(self, east_m: float, north_m: float) -> bool:
        """Return true if a point lies inside or on the edge."""
        x, y = self.centre_enu_m
        return math.hypot(east_m - x, north_m - y) <= self.radius_m


class FenceStore:
    """Uploaded fence: a place is allowed inside any inclusion and outside all exclusions.

    Attributes:
        switch: True lets the geofence count, the limits of the parameters included. None lets it
            count as soon as a fence is uploaded.
        items: Items as uploaded.
        fences: The same fences in metres.
    """

    def __init__(self, frame: LocalFrame, on_change: Callable[[], None] = lambda: None) -> None:
        self._frame = frame
        self.switch: bool | None = True
        self._on_change = on_change
        self.items: tuple[MissionItem, ...] = ()
        self.fences: tuple[PolygonFence | CircleFence, ...] = ()
        self._has_inclusion = False
        self._area: BaseGeometry | None = None
        self._line_area: BaseGeometry | None = None

    def __len__(self) -> int:
        return len(self.items)

    @property
    def is_enabled(self) -> bool:
        """True if the geofence counts now."""
        return bool(self.fences) if self.switch is None else self.switch

    def replace(self, items: Iterable[MissionItem]) -> None:
        """Replace the fence.

        Args:
            items: Items of polygons (5001, 5002) and circles (5003, 5004); none deletes the fence.

        Raises:
            MissionError: If an item is no fence or a polygon is incomplete; the old fence remains.
        """
        candidate = tuple(items)
        if len(candidate) > MAX_FENCE_ITEMS:
            text = f"{len(candidate)} fence items; at most {MAX_FENCE_ITEMS} fit"
            raise MissionError(MissionFault.NO_SPACE, text, index=None)
        self.fences = _fences(candidate, self._frame)
        self.items = candidate
        self._has_inclusion = any(fence.is_inclusion for fence in self.fences)
        # Both areas are built anew when they are next needed.
        self._area = self._line_area = None
        self._on_change()

    def allows(self, position_enu_m: Vector3) -> bool:
        """Return true if the fence allows a position; its height does not matter."""
        if not self.fences:
            return True
        east_m, north_m, _ = position_enu_m
        # Without any inclusion everything is included.
        is_included = not self._has_inclusion
        for fence in self.fences:
            if fence.contains(east_m, north_m):
                if not fence.is_inclusion:
                    return False
                is_included = True
        return is_included

    @property
    def area(self) -> BaseGeometry:
        """Places inside any inclusion and outside all exclusions, ENU m."""
        if self._area is None:
            import shapely

            self._area = _allowed(self.fences)
            shapely.prepare(self._area)
        return self._area

    def allows_lines(self, lines_enu_m: Sequence[tuple[Vector3, Vector3]]) -> list[bool]:
        """Return for each line whether the fence allows straight flight between its two ends.

        Args:
            lines_enu_m: Start and goal of each line; heights do not matter.
        """
        if not (self.fences and lines_enu_m):
            return [True] * len(lines_enu_m)
        import shapely

        if self._line_area is None:
            # The finer circles and the margin let lines pass whose ends lie on the edge itself.
            area = _allowed(self.fences, _FINE_QUADRANT)
            self._line_area = area.buffer(_EDGE_M, join_style="mitre")
            shapely.prepare(self._line_area)
        ends = [[start[:2], end[:2]] for start, end in lines_enu_m]
        return shapely.covers(self._line_area, shapely.linestrings(ends)).tolist()


class RallyStore:
    """Uploaded rally points: safe places to return to.

    Attributes:
        items: Items as uploaded.
        points_enu_m: East and north of each point.
    """

    def __init__(self, frame: LocalFrame, on_change: Callable[[], None] = lambda: None) -> None:
        self._frame = frame
        self._on_change = on_change
        self.items: tuple[MissionItem, ...] = ()
        self.points_enu_m: tuple[Point2, ...] = ()

    def __len__(self) -> int:
        return len(self.items)

    def replace(self, items: Iterable[MissionItem]) -> None:
        """Replace the rally points.

        Args:
            items: Rally points (5100); none deletes them.

        Raises:
            MissionError: If an item is no rally point; the old ones remain.
        """
        candidate = tuple(items)
        if len(candidate) > MAX_RALLY_ITEMS:
            text = f"{len(candidate)} rally points; at most {MAX_RALLY_ITEMS} fit"
            raise MissionError(MissionFault.NO_SPACE, text, index=None)
        points = []
        for index, item in enumerate(candidate):
            if item.command != Cmd.RALLY_POINT:
                raise unsupported_command(index, item, "rally points (5100)")
            points.append(_point(index, item, self._frame))
        self.points_enu_m = tuple(points)
        self.items = candidate
        self._on_change()


def _fences(
    items: tuple[MissionItem, ...], frame: LocalFrame
) -> tuple[PolygonFence | CircleFence, ...]:
    fences: list[PolygonFence | CircleFence] = []
    # Vertices of a polygon follow one another, and each repeats command and number of vertices.
    index = 0
    while index < len(items):
        item = items[index]
        if item.command in _CIRCLES:
            if not 0.0 <= item.param1 <= 1e5:  # MAVSDK's example has a circle of radius 0
                raise _invalid(index, 1, f"radius = {item.param1} m; valid are 0 to 100000")
            centre = _point(index, item, frame)
            fences.append(CircleFence(centre, item.param1, _CIRCLES[Cmd(item.command)]))
            index += 1
        elif item.command in _POLYGONS:
            fence = _polygon(items, index, frame)
            fences.append(fence)
            index += len(fence.vertices_enu_m)
        else:
            raise unsupported_command(index, item, "fences (5001 to 5004)")
    return tuple(fences)


def _polygon(items: tuple[MissionItem, ...], start: int, frame: LocalFrame) -> PolygonFence:
    first = items[start]
    n_vertices = first.param1
    if not (3 <= n_vertices <= MAX_FENCE_ITEMS and n_vertices == int(n_vertices)):
        raise _invalid(start, 1, f"{n_vertices} vertices; a polygon has 3 or more")
    vertices = []
    for index in range(start, start + int(n_vertices)):
        if index >= len(items):
            text = f"item {start}: polygon of {n_vertices:g} vertices has only {index - start}"
            raise MissionError(MissionFault.INVALID_SEQUENCE, text, index=start)
        item = items[index]
        if item.command != first.command or item.param1 != n_vertices:
            text = f"item {index}: expected a vertex of the polygon that starts at item {start}"
            raise MissionError(MissionFault.INVALID_SEQUENCE, text, index=index)
        vertices.append(_point(index, item, frame))
    return PolygonFence(tuple(vertices), _POLYGONS[Cmd(first.command)])


def _point(index: int, item: MissionItem, frame: LocalFrame) -> Point2:
    if not item.is_geodetic:
        text = f"item {index}: frame {item.frame} is not global"
        raise MissionError(MissionFault.UNSUPPORTED_FRAME, text, index=index)
    check_horizontal_place(index, item)
    east_m, north_m, _ = frame.enu_from_geodetic(Geodetic(item.x, item.y, 0.0))
    return (east_m, north_m)


def _invalid(index: int, param: int, what: str) -> MissionError:
    text = f"item {index}: {what}"
    return MissionError(MissionFault.INVALID_PARAM, text, index=index, param=param)


def _allowed(fences: Sequence[PolygonFence | CircleFence], quadrant: int = 16) -> BaseGeometry:
    """Places inside any inclusion and outside all exclusions.

    Args:
        fences: Fences in metres.
        quadrant: Number of sides that stand for a quadrant of a circle.
    """
    import shapely

    shapes = [(_shape(each, quadrant), each.is_inclusion) for each in fences]
    included = [shape for shape, is_inclusion in shapes if is_inclusion]
    everywhere = shapely.box(-EVERYWHERE_M, -EVERYWHERE_M, EVERYWHERE_M, EVERYWHERE_M)
    area = shapely.union_all(included) if included else everywhere
    return area.difference(shapely.union_all([s for s, is_inclusion in shapes if not is_inclusion]))


def _shape(fence: PolygonFence | CircleFence, quadrant: int) -> BaseGeometry:
    import shapely

    if isinstance(fence, CircleFence):
        return shapely.Point(fence.centre_enu_m).buffer(fence.radius_m, quad_segs=quadrant)
    # A polygon may cross itself: shapely refuses to intersect those as they are.
    return shapely.make_valid(shapely.Polygon(fence.vertices_enu_m))
