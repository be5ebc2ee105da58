"""Shortest routes within a geofence, around what it forbids.

A shortest route among polygons bends at their corners only. So the corners of the allowed area are
the nodes of a graph whose edges are free straight lines, and Dijkstra's search finds the shortest
route (visibility graph: Lozano-Perez and Wesley 1979). Corners are moved inwards by a margin,
because a vehicle that flies along the fence itself would breach it with every gust.
"""

from __future__ import annotations

import heapq
from itertools import pairwise
from math import hypot
from typing import TYPE_CHECKING

from flightsim.autopilot.fence import EVERYWHERE_M, Point2
from flightsim.autopilot.flight_context import FlightContext

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry

_MARGIN_M = 1.5
"""Distance that corners of a route keep from the fence; straight parts keep half of it."""
_MOST_CORNERS = 100
"""Most corners of the fence that a search looks at, so that no fence can hold up the flight."""
_SIMPLER = 2.0
"""Factor by which the tolerance of smoothing grows, from 0.1 m, until the corners are few enough.
"""


class FenceRoutes:
    """The area that a fence allows when this object is made, and shortest routes in it."""

    def __init__(self, area: BaseGeometry) -> None:
        """Prepare an area.

        Args:
            area: Allowed places, ENU m.
        """
        import shapely

        self._area = area
        self._half = area.buffer(-_MARGIN_M / 2, join_style="mitre")
        shapely.prepare(self._area)
        shapely.prepare(self._half)

    def length_and_route(self, start: Point2, goal: Point2) -> tuple[float, list[Point2]] | None:
        """Length of the shortest route in m, and its points after the start; None if there is none.

        A start outside the fence goes straight back to the nearest allowed place first.

        Args:
            start: East and north of the vehicle.
            goal: East and north of the place to reach.
        """
        import shapely

        if not self._area.covers(shapely.Point(goal)):
            return None
        back: list[Point2] = []
        if not self._area.covers(shapely.Point(start)):
            # The margin may leave nothing of a narrow area.
            inner = self._half if not self._half.is_empty else self._area
            nearest = shapely.shortest_line(inner, shapely.Point(start)).coords[0]
            back = [(nearest[0], nearest[1])]
        begin = back[0] if back else start
        if self._is_free([begin], goal)[0]:
            route = [goal]
        elif (found := self._search(begin, goal)) is not None:
            route = found
        else:
            return None
        points = [start, *back, *route]
        return sum(hypot(c - a, d - b) for (a, b), (c, d) in pairwise(points)), points[1:]

    def _search(self, start: Point2, goal: Point2) -> list[Point2] | None:
        """Find the shortest route by Dijkstra's algorithm over the corners that see each other."""
        # Node 0 is the start, node 1 the goal.
        points = [start, goal, *_corners(self._area)]
        best: dict[int, float] = {0: 0.0}
        before: dict[int, int] = {}
        waiting, done = [(0.0, 0)], set[int]()
        while waiting:
            length_m, here = heapq.heappop(waiting)
            # A shorter way to this node was expanded before; its older entries stay in the heap.
            if here in done:
                continue
            done.add(here)
            if here == 1:
                break
            others = [i for i in range(1, len(points)) if i not in done]
            free = self._is_free([points[i] for i in others], points[here])
            for other in (i for i, is_free in zip(others, free, strict=True) if is_free):
                (a, b), (c, d) = points[here], points[other]
                total_m = length_m + hypot(c - a, d - b)
                if total_m < best.get(other, float("inf")):
                    best[other], before[other] = total_m, here
                    heapq.heappush(waiting, (total_m, other))
        if 1 not in before:
            return None
        route = [1]
        while before[route[-1]] != 0:
            route.append(before[route[-1]])
        return [points[i] for i in reversed(route)]

    def _is_free(self, points: list[Point2], to: Point2) -> list[bool]:
        """Return for each point whether straight flight to `to` is allowed.

        The line keeps half the margin from the fence, unless one of its ends is nearer to the fence
        already.
        """
        import shapely

        if not points:
            return []
        lines = shapely.linestrings([[point, to] for point in points])
        with_room = shapely.covers(self._half, lines)
        has_room = shapely.covers(self._half, shapely.points(points))
        is_tight = ~has_room | ~shapely.covers(self._half, shapely.Point(to))
        return (with_room | (is_tight & shapely.covers(self._area, lines))).tolist()


def fence_routes(flight: FlightContext) -> FenceRoutes | None:
    """Routes within the geofence; None if no geofence counts, or GF_ACTION ignores it.

    Args:
        flight: Shared state; the circle of GF_MAX_HOR_DIST around home belongs to the area.
    """
    p = flight.parameters
    farthest_m, home = p["GF_MAX_HOR_DIST"], flight.home
    has_circle = farthest_m > 0.0 and home is not None
    if (
        not flight.fence.is_enabled
        or p["GF_ACTION"] == 0
        or not (flight.fence.fences or has_circle)
    ):
        return None
    import shapely

    area = flight.fence.area
    if has_circle and home is not None:
        x, y, _ = home.position_enu_m
        area = area.intersection(shapely.Point(x, y).buffer(farthest_m))
    return FenceRoutes(area)


def _corners(area: BaseGeometry) -> list[Point2]:
    """Corners of the area, moved inwards by the margin, at most `_MOST_CORNERS`.

    A fence that cannot be smoothed that far yields none.
    """
    import shapely

    inner = area.buffer(-_MARGIN_M, join_style="mitre")
    tolerance_m = 0.1
    points = shapely.get_coordinates(inner).tolist()
    while len(points) > _MOST_CORNERS:
        points = shapely.get_coordinates(inner.simplify(tolerance_m)).tolist()
        if tolerance_m > EVERYWHERE_M:
            return []
        tolerance_m *= _SIMPLER
    return [(x, y) for x, y in points]
