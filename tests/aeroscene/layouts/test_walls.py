from __future__ import annotations

import math

import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from aeroscene.layouts import LayoutRoom
from aeroscene.layouts.ground import cover
from aeroscene.layouts.walls import (
    DOOR_M,
    INNER_M,
    LEAST_DOOR_M,
    OUTER_M,
    WallPlan,
    plan_walls,
)

ELL = ((0, 0), (6, 0), (6, 3), (3, 3), (3, 6), (0, 6))


def room(x0, y0, x1, y1, name="room"):
    return LayoutRoom(name=name, polygon=((x0, y0), (x1, y0), (x1, y1), (x0, y1)))


def solid(wall: WallPlan, *, is_cut: bool = True) -> shapely.Geometry:
    """A wall seen from above, its opening cut out."""
    c, s = math.cos(wall.heading_rad), math.sin(wall.heading_rad)
    spans = [(-wall.length_m / 2, wall.length_m / 2)]
    if wall.opening_m is not None and is_cut:
        low, high = wall.opening_m - wall.door_m / 2, wall.opening_m + wall.door_m / 2
        spans = [(spans[0][0], low), (high, spans[0][1])]
    half = wall.thickness_m / 2
    return shapely.union_all(
        [
            shapely.Polygon(
                [
                    (wall.centre[0] + u * c - v * s, wall.centre[1] + u * s + v * c)
                    for u, v in ((a, -half), (b, -half), (b, half), (a, half))
                ]
            )
            for a, b in spans
        ]
    )


def outline(walls: list[WallPlan]) -> shapely.Polygon:
    """All walls from above, openings shut; those that touch are one."""
    (part,) = shapely.get_parts(
        shapely.union_all([solid(wall, is_cut=False).buffer(1e-4) for wall in walls])
    )
    return part


@pytest.mark.parametrize("polygon", [room(0, 0, 4, 3).polygon, ELL])
def test_a_single_room_is_closed_but_for_one_way_out(polygon):
    walls = plan_walls([LayoutRoom(name="r", polygon=polygon)], [])
    inside = shapely.Polygon(polygon)
    closed = outline(walls)
    assert shapely.intersection(closed, inside).area < 0.01
    (hole,) = closed.interiors
    assert shapely.Polygon(hole).symmetric_difference(inside).area < 0.01
    assert sum(solid(wall, is_cut=False).area for wall in walls) == pytest.approx(
        closed.area, abs=0.01
    )
    assert [wall.opening_m is not None for wall in walls].count(True) == 1


def test_rooms_that_touch_share_one_thin_wall_with_an_opening():
    walls = plan_walls([room(0, 0, 4, 4), room(4, 0, 8, 4)], [])
    inner = [wall for wall in walls if wall.thickness_m == INNER_M]
    (wall,) = inner
    assert wall.centre == pytest.approx((4, 2))
    assert wall.length_m == pytest.approx(4)
    assert wall.opening_m == pytest.approx(0, abs=0.2)
    assert wall.door_m == DOOR_M


def test_a_wall_fills_the_gap_between_rooms_that_do_not_touch():
    walls = plan_walls([room(0, 0, 4, 4), room(4.2, 1, 8, 6)], [])
    (wall,) = [wall for wall in walls if wall.thickness_m == pytest.approx(0.2)]
    assert wall.centre == pytest.approx((4.1, 2.5))
    assert wall.length_m == pytest.approx(3)
    assert len(outline(walls).interiors) == 2


def test_an_opening_keeps_away_from_furniture():
    cupboard = shapely.box(3.4, 0.5, 4, 2.8)
    walls = plan_walls([room(0, 0, 4, 6), room(4, 0, 8, 6)], [cupboard])
    (wall,) = [wall for wall in walls if wall.thickness_m == INNER_M]
    assert wall.opening_m is not None
    opening = shapely.LineString(
        [
            (4, wall.centre[1] + wall.opening_m * math.sin(wall.heading_rad) + side * DOOR_M / 2)
            for side in (-1, 1)
        ]
    )
    assert opening.distance(cupboard) > 0


def test_rooms_are_joined_even_where_furniture_is_in_the_way():
    crowd = [shapely.box(2, 0, 6, 6)]
    walls = plan_walls([room(0, 0, 4, 6), room(4, 0, 8, 6)], crowd)
    (wall,) = [wall for wall in walls if wall.thickness_m == INNER_M]
    assert wall.opening_m is not None


def test_a_short_border_has_a_narrow_opening_or_none():
    def opening(length):
        walls = plan_walls([room(0, 0, 4, 4), room(4, 4 - length, 8, 8)], [])
        (wall,) = [wall for wall in walls if wall.thickness_m == INNER_M]
        return wall.opening_m, wall.door_m

    place, width = opening(1.7)
    assert place is not None
    assert LEAST_DOOR_M <= width < 1.7
    assert opening(1.4)[0] is None


def test_slanting_rooms_are_closed_too():
    turned = shapely.affinity.rotate(shapely.Polygon(ELL), 30, origin=(0, 0))
    polygon = tuple(map(tuple, shapely.get_coordinates(turned)[:-1].tolist()))
    walls = plan_walls([LayoutRoom(name="r", polygon=polygon)], [])
    assert len(outline(walls).interiors) == 1


@st.composite
def staircases(draw):
    """Outlines along the axes whose upper border goes up and down."""
    count = draw(st.integers(1, 6))
    steps = st.lists(st.integers(1, 40), min_size=count, max_size=count)
    widths, heights = draw(steps), draw(steps)
    points, x = [(0.0, 0.0)], 0.0
    for width in widths:
        x += width / 4
    points.append((x, 0.0))
    for width, height in zip(reversed(widths), reversed(heights), strict=True):
        points += [(x, height / 4), (x - width / 4, height / 4)]
        x -= width / 4
    return points


@given(staircases(), st.floats(1.0, 50.0))
def test_rectangles_cover_an_outline_along_the_axes_exactly(points, longest_m):
    outline = shapely.simplify(shapely.Polygon(points), 0)
    tiles = [shapely.box(*tile) for tile in cover(outline, longest_m)]
    whole = shapely.union_all(tiles)
    assert whole.symmetric_difference(outline).area < 1e-6
    assert sum(tile.area for tile in tiles) == pytest.approx(outline.area)
    for x0, y0, x1, y1 in (tile.bounds for tile in tiles):
        assert max(x1 - x0, y1 - y0) <= longest_m + 1e-6


def test_a_slanting_outline_is_covered_with_little_to_spare():
    outline = shapely.Point(0, 0).buffer(5)
    whole = shapely.union_all([shapely.box(*tile) for tile in cover(outline, 60)])
    assert outline.difference(whole).area < 0.02 * outline.area
    assert whole.area < 1.15 * outline.area


def test_outer_walls_stand_outside():
    walls = plan_walls([room(0, 0, 4, 3)], [])
    assert all(wall.thickness_m == OUTER_M for wall in walls)
    assert shapely.union_all([solid(w) for w in walls]).bounds == pytest.approx(
        (-OUTER_M, -OUTER_M, 4 + OUTER_M, 3 + OUTER_M)
    )
