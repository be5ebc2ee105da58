"""Walls about rooms, with openings between neighbours, for sources that only have floors.

An inner wall stands where two rooms meet, or lie so close that one wall must separate them. Every
other stretch of a room's outline gets an outer wall on its far side. Layouts of rooms seldom state
their doors, so this module chooses openings: wherever two neighbours share a stretch that is free
of furniture on both sides, as many more as it takes to join all rooms that can be joined, and one
to the outside, where furniture is least in its way.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import shapely

from aeroscene.layouts.document import LayoutRoom, Point2

OUTER_M = 0.15
"""Thickness of an outer wall; it stands outside the room."""
INNER_M = 0.06
"""Thickness of a wall between rooms whose outlines touch; pictures still hang in front of it."""
MAX_GAP_M = 0.5
"""Greatest distance of rooms that share a wall, which fills the gap."""
DOOR_M = 2.2
"""Clear width of an opening if there is space for it: a medium drone's ball of 0.7 m passes."""
LEAST_DOOR_M = 1.6
"""Clear width of the narrowest opening."""
DOOR_HEIGHT_M = 2.2
_LEAST_SHARED_M = 0.25
_JAMB_M = 0.04
"""Least width of wall on either side of an opening."""
_AT_DOOR_M = 0.4
"""Greatest distance of a stated door from its wall."""
_PARALLEL = 0.999
_APRON_M = 0.9
"""Depth on either side of an opening that should be free of furniture."""
_STEP_M = 0.2
"""Distance between the places that are tried for an opening."""
_FREE_M2 = 0.02
"""Area of furniture in the way of an opening that still counts as none, m2."""


@dataclass(frozen=True, slots=True, kw_only=True)
class WallPlan:
    """A straight wall on the ground."""

    centre: Point2
    heading_rad: float
    """Direction of its length, counter-clockwise from east."""
    length_m: float
    thickness_m: float
    opening_m: float | None = None
    """Place of the middle of an opening, from the wall's own middle along its length."""

    @property
    def door_m(self) -> float:
        """Width that an opening of this wall has, or would have."""
        return _door_width(self.length_m)


@dataclass(frozen=True, slots=True)
class _Edge:
    room: int
    ax: float
    ay: float
    ux: float
    uy: float
    length: float

    def at(self, t: float, out: float = 0.0) -> Point2:
        """Point `t` along the edge and `out` away from the room, which lies to its left."""
        return (self.ax + t * self.ux + out * self.uy, self.ay + t * self.uy - out * self.ux)


@dataclass(frozen=True, slots=True)
class _Stretch:
    """Part of an edge on which one wall stands."""

    edge: _Edge
    other: int | None
    """Room on its other side; None is the outside."""
    low: float
    high: float
    gap: float

    @property
    def length(self) -> float:
        return self.high - self.low


def _door_width(wall_m: float) -> float:
    return round(min(DOOR_M, wall_m - 2 * _JAMB_M), 3)


def plan_walls(
    rooms: Sequence[LayoutRoom],
    furniture: Sequence[shapely.Polygon],
    doors: Sequence[Point2] = (),
) -> list[WallPlan]:
    """Plan the walls of all rooms.

    Args:
        rooms: Outlines that may touch or leave gaps, but do not overlap.
        furniture: Outlines of objects that stand or hang lower than an opening's lintel.
        doors: Places of the openings; more are made only for rooms to which no door leads. Without
            any, neighbouring rooms have openings where furniture leaves space for them.
    """
    edges = [_edges(index, room.polygon) for index, room in enumerate(rooms)]
    shared = _all_shared(edges)
    openings = _choose_openings(shared, furniture, len(rooms), doors)
    walls = [_wall(stretch, openings.get(index)) for index, stretch in enumerate(shared)]
    outer = [stretch for ring in edges for stretch in _outer_stretches(ring, shared)]
    exit_ = _choose_exit(outer, furniture, doors)
    for index, stretch in enumerate(outer):
        walls.append(_wall(stretch, exit_[1] if exit_ and exit_[0] == index else None))
    return walls


def _edges(room: int, polygon: Sequence[Point2]) -> list[_Edge]:
    edges: list[_Edge] = []
    for (ax, ay), (bx, by) in zip(polygon, [*polygon[1:], polygon[0]], strict=True):
        length = math.hypot(bx - ax, by - ay)
        if length < 1e-6:
            continue
        ux, uy = (bx - ax) / length, (by - ay) / length
        last = edges[-1] if edges else None
        # Corners on a straight line would cut a wall into pieces.
        if last and last.ux * ux + last.uy * uy > 1 - 1e-9:
            edges[-1] = _Edge(room, last.ax, last.ay, last.ux, last.uy, last.length + length)
        else:
            edges.append(_Edge(room, ax, ay, ux, uy, length))
    return edges


def _all_shared(rings: list[list[_Edge]]) -> list[_Stretch]:
    """Every shared stretch once, as seen from the earlier room."""
    stretches: list[_Stretch] = []
    for index, ring in enumerate(rings):
        for other in rings[index + 1 :]:
            for edge in ring:
                for opposite in other:
                    stretch = _facing(edge, opposite)
                    if stretch:
                        stretches.append(stretch)
    return stretches


def _facing(edge: _Edge, opposite: _Edge) -> _Stretch | None:
    # Both outlines run counter-clockwise, so that facing edges run in opposite directions.
    if edge.ux * opposite.ux + edge.uy * opposite.uy > -_PARALLEL:
        return None
    dx, dy = opposite.ax - edge.ax, opposite.ay - edge.ay
    # Distance of the other edge to the right of this one, where the neighbour lies.
    gap = dx * edge.uy - dy * edge.ux
    if not -0.01 <= gap <= MAX_GAP_M:
        return None
    start = dx * edge.ux + dy * edge.uy
    low, high = max(0.0, start - opposite.length), min(edge.length, start)
    if high - low < _LEAST_SHARED_M:
        return None
    return _Stretch(edge, opposite.room, low, high, max(gap, 0.0))


def _wall(stretch: _Stretch, opening: float | None) -> WallPlan:
    middle = (stretch.low + stretch.high) / 2
    depth = OUTER_M if stretch.other is None else stretch.gap
    return WallPlan(
        centre=stretch.edge.at(middle, depth / 2),
        heading_rad=math.atan2(stretch.edge.uy, stretch.edge.ux),
        length_m=stretch.length,
        thickness_m=max(depth, INNER_M),
        opening_m=None if opening is None else opening - middle,
    )


def _choose_openings(
    shared: list[_Stretch],
    furniture: Sequence[shapely.Polygon],
    n_rooms: int,
    doors: Sequence[Point2],
) -> dict[int, float]:
    """Place of the opening along its edge, under the number of each stretch that has one."""
    stated = _at_doors(shared, doors)
    best: dict[tuple[int, int], tuple[float, float, int, float]] = {}
    tree = shapely.STRtree(list(furniture))
    for index, stretch in enumerate(shared):
        if stretch.length < LEAST_DOOR_M + 2 * _JAMB_M:
            continue
        blocked, place = _freest_place(stretch, tree)
        assert stretch.other is not None
        pair = (stretch.edge.room, stretch.other)
        best[pair] = min(
            best.get(pair, (math.inf, 0.0, 0, 0.0)), (blocked, -stretch.length, index, place)
        )
    # Groups of rooms that openings join, as in Kruskal's algorithm: the freest places first.
    group = list(range(n_rooms))
    openings = dict(stated)
    for index in stated:
        a, b = shared[index].edge.room, shared[index].other
        group = [group[a] if b is not None and member == group[b] else member for member in group]
    for (a, b), (blocked, _, index, place) in sorted(best.items(), key=lambda item: item[1]):
        is_joined = group[a] == group[b]
        if (blocked <= _FREE_M2 and not doors) or not is_joined:
            openings[index] = place
            group = [group[a] if member == group[b] else member for member in group]
    return openings


def _at_doors(stretches: Sequence[_Stretch], doors: Sequence[Point2]) -> dict[int, float]:
    """Place along its edge of the first door on each stretch that has room for one."""
    found: dict[int, float] = {}
    for index, stretch in enumerate(stretches):
        reach = _door_width(stretch.length) / 2 + _JAMB_M
        low, high = stretch.low + reach, stretch.high - reach
        if stretch.length < LEAST_DOOR_M + 2 * _JAMB_M or low > high:
            continue
        edge = stretch.edge
        for x, y in doors:
            dx, dy = x - edge.ax, y - edge.ay
            along, out = dx * edge.ux + dy * edge.uy, dx * edge.uy - dy * edge.ux
            is_on_it = stretch.low <= along <= stretch.high
            if is_on_it and -_AT_DOOR_M <= out <= stretch.gap + _AT_DOOR_M:
                found.setdefault(index, min(max(along, low), high))
    return found


def _freest_place(stretch: _Stretch, tree: shapely.STRtree) -> tuple[float, float]:
    """Least area of furniture before an opening, and the place along the edge with it."""
    width = _door_width(stretch.length)
    reach = width / 2 + _JAMB_M
    low, high = stretch.low + reach, stretch.high - reach
    count = max(1, math.ceil((high - low) / _STEP_M))
    middle = (low + high) / 2
    best = (math.inf, 0.0, middle)
    for step in range(count + 1):
        place = low + (high - low) * step / count
        apron = shapely.Polygon(
            [
                stretch.edge.at(place - width / 2, -_APRON_M),
                stretch.edge.at(place + width / 2, -_APRON_M),
                stretch.edge.at(place + width / 2, stretch.gap + _APRON_M),
                stretch.edge.at(place - width / 2, stretch.gap + _APRON_M),
            ]
        )
        hits = tree.geometries[tree.query(apron)]
        blocked = float(shapely.area(shapely.intersection(shapely.union_all(hits), apron)))
        # Of equally free places the one nearest to the middle.
        best = min(best, (round(blocked, 3), abs(place - middle), place))
    return best[0], best[2]


def _choose_exit(
    outer: list[_Stretch], furniture: Sequence[shapely.Polygon], doors: Sequence[Point2]
) -> tuple[int, float] | None:
    """Number of the stretch with the opening to the outside, and its place; None if none fits."""
    if stated := _at_doors(outer, doors):
        return next(iter(stated.items()))
    tree = shapely.STRtree(list(furniture))
    best: tuple[float, float, int, float] | None = None
    for index, stretch in enumerate(outer):
        if stretch.length >= LEAST_DOOR_M + 2 * OUTER_M:
            blocked, place = _freest_place(stretch, tree)
            here = (blocked, -stretch.length, index, place)
            # The least area in the way, then the longest stretch.
            best = min(best or here, here)
    return None if best is None else (best[2], best[3])


def _outer_stretches(ring: list[_Edge], shared: list[_Stretch]) -> list[_Stretch]:
    """Stretches of a room's outline that face no other room; their walls extend round corners."""
    free = [_free_stretches(edge, shared) for edge in ring]
    stretches: list[_Stretch] = []
    for index, (edge, parts) in enumerate(zip(ring, free, strict=True)):
        following = (index + 1) % len(ring)
        for low, high in parts:
            end = high
            is_corner = high > edge.length - 1e-6
            if is_corner and free[following] and free[following][0][0] < 1e-6:
                # Convex corners are filled by one of the two walls, concave ones shorten it.
                end += OUTER_M * _turn(edge, ring[following])
            if end - low > OUTER_M:
                stretches.append(_Stretch(edge, None, low, end, 0.0))
    return stretches


def _turn(edge: _Edge, following: _Edge) -> float:
    """Sine of the corner's turn: 1 at a right angle outwards, -1 inwards."""
    return edge.ux * following.uy - edge.uy * following.ux


def _free_stretches(edge: _Edge, shared: list[_Stretch]) -> list[tuple[float, float]]:
    taken = sorted(_taken_of(edge, shared))
    stretches: list[tuple[float, float]] = []
    at = 0.0
    for low, high in [*taken, (edge.length, edge.length)]:
        if low - at > 0.02:
            stretches.append((at, low))
        at = max(at, high)
    return stretches


def _taken_of(edge: _Edge, shared: list[_Stretch]) -> list[tuple[float, float]]:
    """Stretches of an edge on which inner walls stand, whichever room they were seen from."""
    taken: list[tuple[float, float]] = []
    for stretch in shared:
        if stretch.edge is edge:
            taken.append((stretch.low, stretch.high))
        elif stretch.other == edge.room:
            facing = _facing(edge, stretch.edge)
            if facing:
                ends = [
                    (x - edge.ax) * edge.ux + (y - edge.ay) * edge.uy
                    for x, y in (stretch.edge.at(stretch.low), stretch.edge.at(stretch.high))
                ]
                low, high = max(0.0, min(ends)), min(edge.length, max(ends))
                if high > low:
                    taken.append((low, high))
    return taken
