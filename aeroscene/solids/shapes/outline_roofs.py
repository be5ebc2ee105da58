"""Pitched roofs over outlines: gable, hip and shed.

Parts of a roof have to be convex, so the outline decides which roof is built over it:

| outline | gable | hip |
|---|---|---|
| convex | two planes from the ridge along x | a plane from every edge to a ridge |
| wings at right angles | a gable over each wing, which meet in valleys | a hip over each wing |
| any other | the two planes of a gable, cut at the walls | as the gable |
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from aeroscene.scene import Vector3
from aeroscene.solids.shapes.convex import Point2, Ring, convex_pieces, is_along_axes
from aeroscene.solids.shapes.look import Look
from aeroscene.solids.shapes.materials import WALL_COLOURS
from aeroscene.solids.shapes.primitive import Part, hull

if TYPE_CHECKING:
    import shapely

PITCHED = ("gable", "hip", "shed")
LEAST_FILL = 0.55
"""Least share of its box that an outline fills to have one gable."""
_WINGS_FILL = 0.85
"""Share of its box from which an outline counts as one block without wings."""
_MOST_WINGS = 8
_CONVEX_SHARE = 0.995
"""Share of its hull's area from which a polygon counts as convex."""
_RIDGE_SHARE = 0.98
"""Share of the widest inner circle's radius after which a hip's planes end in a ridge."""
_TILES_M = 0.15
_EDGE_M = 0.1
_Rectangle = tuple[float, float, float, float]
_HeightAt = Callable[[Point2], float]


def is_convex(polygon: shapely.Polygon) -> bool:
    """True if a polygon has no courtyard and, apart from rounding, no corner that turns inwards."""
    return polygon.area > _CONVEX_SHARE * polygon.convex_hull.area


def can_be_pitched(polygon: shapely.Polygon) -> bool:
    """True if a gable or a hip can be built over a polygon in the frame of its box.

    Generators ask before they choose a form, so that a roof does not fall back on a flat one.
    """
    return is_convex(polygon) or _is_full(polygon) or bool(wings(polygon))


def _is_full(polygon: shapely.Polygon) -> bool:
    """True if one gable over all of it looks like a roof: hardly any courtyard or recess."""
    return _fill(polygon) >= LEAST_FILL and not polygon.interiors


def _fill(polygon: shapely.Polygon) -> float:
    x0, y0, x1, y1 = polygon.bounds
    return polygon.area / ((x1 - x0) * (y1 - y0))


def outlined_roof(look: Look, polygon: shapely.Polygon) -> list[Part] | None:
    """Parts of a pitched roof; None if it is flat, or the outline too irregular for its form.

    Reads the attributes `form`, `tiles` and `colour`.

    Args:
        look: Size and attributes of the roof.
        polygon: Outline in the frame of its box, m.
    """
    import shapely

    form = look.attributes.get("form")
    if form not in PITCHED:
        return None
    tiles = look.choice("tiles", ("roof_red", "roof_slate"))
    colour = look.choice("colour", (*WALL_COLOURS, "brick"))
    wall = "brick" if colour == "brick" else f"plaster_{colour}"
    x, _, z = look.size_m
    if form == "shed":
        low = min(_EDGE_M, 0.5 * z)
        return _planes(
            polygon, lambda p: low + (z - low) * min(1.0, max(0.0, 0.5 + p[0] / x)), wall, tiles
        )
    if form == "hip" and is_convex(polygon):
        shape = shapely.Polygon(shapely.get_coordinates(polygon.convex_hull))
        return [_tent(_corners(shape), _inner_ring(shape), z, tiles)]
    found = [] if is_convex(polygon) or _fill(polygon) > _WINGS_FILL else wings(polygon)
    if found:
        widest = max(_short_side(wing) for wing in found)
        return [_wing(wing, z * _short_side(wing) / widest, form, tiles) for wing in found]
    if not is_convex(polygon) and not _is_full(polygon):
        return None
    return _gable(polygon, z, wall, tiles)


def _gable(polygon: shapely.Polygon, z: float, wall: str, tiles: str) -> list[Part]:
    """Two planes that rise to a ridge along x through the middle of the box."""
    import shapely

    x0, y0, x1, y1 = polygon.bounds
    middle, half = (y0 + y1) / 2, (y1 - y0) / 2
    low = min(_EDGE_M, 0.3 * z)
    parts: list[Part] = []
    # Each plane rises over its own half, so that pieces stay on one side of the ridge.
    for side in (shapely.box(x0, y0, x1, middle), shapely.box(x0, middle, x1, y1)):
        for piece in shapely.get_parts(shapely.intersection(polygon, side)):
            if isinstance(piece, shapely.Polygon):
                parts += _planes(
                    piece, lambda p: z - (z - low) * abs(p[1] - middle) / half, wall, tiles
                )
    return parts


def _planes(polygon: shapely.Polygon, height: _HeightAt, wall: str, tiles: str) -> list[Part]:
    """One plane over a polygon: walls up to it, tiles on them."""
    parts: list[Part] = []
    for ring in convex_pieces(polygon):
        top = [(x, y, height((x, y))) for x, y in ring]
        # Tiles take at most half of the height, so that the edge at the eaves stays above zero.
        under = [(x, y, max(0.5 * h, h - _TILES_M)) for x, y, h in top]
        parts.append(hull([*((x, y, 0.0) for x, y in ring), *under], wall))
        parts.append(hull([*under, *top], tiles))
    return parts


def _tent(lower: Sequence[Point2], upper: Sequence[Point2], z: float, tiles: str) -> Part:
    vertices: list[Vector3] = [(x, y, 0.0) for x, y in lower]
    return hull([*vertices, *((x, y, z) for x, y in upper)], tiles)


def _corners(shape: shapely.Polygon) -> list[Point2]:
    return [(x, y) for x, y in list(shape.exterior.coords)[:-1]]


def _inner_ring(shape: shapely.Polygon) -> list[Point2]:
    """Corners of the ridge of planes that rise evenly from every edge of a polygon."""
    import shapely

    # At the full radius the inner polygon would be a point or nothing.
    depth = _RIDGE_SHARE * shapely.maximum_inscribed_circle(shape, 0.01).length
    inner = shapely.buffer(shape, -depth, join_style="mitre", mitre_limit=20.0)
    if inner.is_empty:
        return [(shape.centroid.x, shape.centroid.y)]
    return [(x, y) for x, y in shapely.get_coordinates(inner)[:-1].tolist()]


def wings(polygon: shapely.Polygon) -> list[_Rectangle]:
    """Rectangles that an outline along the axes consists of; empty for any other outline.

    They overlap in corners: each takes its full length through the corner, so that the roofs over
    them meet in a valley.

    Args:
        polygon: Outline in the frame of its box, m.

    Returns:
        Least x and y, greatest x and y of each wing; at most `_MOST_WINGS`, else none.
    """
    import shapely

    if not is_along_axes(polygon):
        return []
    pieces = [_bounds(ring) for ring in convex_pieces(polygon)]
    grown = {_grown(piece, polygon, axis) for piece in pieces for axis in (0, 1)}
    chosen: list[_Rectangle] = []
    left: shapely.geometry.base.BaseGeometry = polygon
    # Greedily, largest first; wings that add less than 2% of the area are left out.
    for wing in sorted(grown, key=lambda r: -(r[2] - r[0]) * (r[3] - r[1])):
        box = shapely.box(*wing)
        if shapely.intersection(left, box).area > 0.02 * polygon.area:
            chosen.append(wing)
            left = shapely.difference(left, box)
    return chosen if left.area < 0.02 * polygon.area and len(chosen) <= _MOST_WINGS else []


def _bounds(ring: Ring) -> _Rectangle:
    xs, ys = [x for x, _ in ring], [y for _, y in ring]
    return (min(xs), min(ys), max(xs), max(ys))


def _grown(rectangle: _Rectangle, polygon: shapely.Polygon, axis: int) -> _Rectangle:
    """Stretch a rectangle along an axis, then along the other, as far as the polygon reaches."""
    import shapely

    # A centimetre larger, so that borders which coincide count as covered.
    reach = shapely.buffer(polygon, 0.01, join_style="mitre")
    corners = shapely.get_coordinates(polygon)
    levels = [sorted({round(float(v), 3) for v in corners[:, k]}) for k in (0, 1)]
    found = list(rectangle)
    for k in (axis, 1 - axis):
        for side in (k, k + 2):
            outward = [v for v in levels[k] if (v < found[k] if side == k else v > found[k + 2])]
            for value in outward[::-1] if side == k else outward:
                tried = [*found]
                tried[side] = value
                if not reach.covers(shapely.box(tried[0], tried[1], tried[2], tried[3])):
                    break
                found = tried
    return (found[0], found[1], found[2], found[3])


def _short_side(rectangle: _Rectangle) -> float:
    x0, y0, x1, y1 = rectangle
    return min(x1 - x0, y1 - y0)


def _wing(rectangle: _Rectangle, z: float, form: str, tiles: str) -> Part:
    """A gable or hip over a rectangle, its ridge along the longer side."""
    x0, y0, x1, y1 = rectangle
    mx, my = (x0 + x1) / 2, (y0 + y1) / 2
    # The hip's ridge ends half a width before each end, which gives all planes one slope.
    back = _short_side(rectangle) / 2 if form == "hip" else 0.0
    ends = [(x0 + back, my), (x1 - back, my)]
    if x1 - x0 < y1 - y0:
        ends = [(mx, y0 + back), (mx, y1 - back)]
    return _tent([(x0, y0), (x1, y0), (x1, y1), (x0, y1)], ends, z, tiles)
