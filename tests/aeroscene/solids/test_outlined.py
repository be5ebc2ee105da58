from __future__ import annotations

import math

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from aeroscene.solids.rectangles import rectangles_of
from aeroscene.solids.shapes.build import object_parts
from aeroscene.solids.shapes.convex import convex_pieces
from aeroscene.solids.shapes.look import Look
from tests.aeroscene.scene.test_outline import L_SHAPE, outlined

SHAPES = {
    "rectangle": "POLYGON ((-5 -4, 5 -4, 5 4, -5 4, -5 -4))",
    "L": L_SHAPE,
    "U": "POLYGON ((-5 -4, 5 -4, 5 4, 2 4, 2 -1, -2 -1, -2 4, -5 4, -5 -4))",
    "court": "POLYGON ((-5 -4, 5 -4, 5 4, -5 4, -5 -4), (-2 -2, 2 -2, 1 2, -2 2, -2 -2))",
    "skewed": "POLYGON ((-5 -4, 5 -3, 4 4, 0 3, 1 0, -5 0, -5 -4))",
    # As far out of its box as rounding may put it: windows and doors must have room before it.
    "rounded up": "POLYGON ((-5.009 -4, 5.009 -4.009, 5.009 4, -5 4.009, -5.009 -4))",
    "triangle": "POLYGON ((-5 -4, 5 -4, 0 4, -5 -4))",
}
COVERS = ("road", "lawn", "plaza", "sidewalk", "parking_lot", "water")


def stars() -> st.SearchStrategy[shapely.Polygon]:
    """Polygons that see their middle, of 3 to 40 corners."""
    radii = st.lists(st.floats(0.8, 4.0), min_size=3, max_size=40)
    return radii.map(
        lambda r: shapely.Polygon(
            [
                (
                    round(x * math.cos(2 * math.pi * k / len(r)), 2),
                    round(x * math.sin(2 * math.pi * k / len(r)), 2),
                )
                for k, x in enumerate(r)
            ]
        )
    )


def assert_tiled(polygon: shapely.Polygon) -> None:
    pieces = [shapely.Polygon(ring) for ring in convex_pieces(polygon)]
    for piece in pieces:
        assert piece.convex_hull.area == pytest.approx(piece.area, rel=1e-3, abs=1e-3)
        assert piece.exterior.is_ccw
    total = sum(piece.area for piece in pieces)
    assert total == pytest.approx(polygon.area, rel=1e-3, abs=2e-3)
    assert shapely.union_all(pieces).symmetric_difference(polygon).area < 0.01


@given(stars())
@settings(deadline=None, max_examples=60)
def test_convex_pieces_tile_any_polygon(polygon):
    if polygon.is_valid:
        assert_tiled(polygon)


@pytest.mark.parametrize("name", SHAPES)
def test_convex_pieces_tile_outlines(name):
    assert_tiled(shapely.from_wkt(SHAPES[name]))


def test_outlines_along_the_axes_become_rectangles():
    pieces = convex_pieces(shapely.from_wkt(SHAPES["U"]))
    assert len(pieces) == 3
    assert all(
        shapely.Polygon(ring).equals(shapely.box(*shapely.Polygon(ring).bounds)) for ring in pieces
    )


@pytest.mark.parametrize("category", ["building", "house", "tower", "warehouse", "garage", *COVERS])
@pytest.mark.parametrize("name", SHAPES)
def test_what_collides_fills_the_outline_and_its_height(category, name):
    polygon = shapely.from_wkt(SHAPES[name])
    z = 6.0 if category not in COVERS else 0.1
    parts = object_parts(category, Look((10.0, 8.0, z), {"outline": SHAPES[name]}, 1))
    solid = [part for part in parts if part.collides]
    shadow = shapely.union_all([_shadow(part) for part in solid])
    assert shadow.symmetric_difference(polygon).area < 0.05
    for part in solid:
        assert part.size_m[2] == pytest.approx(z)
        assert part.position_m[2] == pytest.approx(z / 2)


@pytest.mark.parametrize("form", ["flat", "gable", "hip", "shed"])
@pytest.mark.parametrize("name", SHAPES)
def test_roofs_stay_over_their_outline_and_within_their_height(form, name):
    polygon = shapely.from_wkt(SHAPES[name])
    look = Look((10.0, 8.0, 3.0), {"outline": SHAPES[name], "form": form}, 1)
    parts = object_parts("roof", look)
    shadow = shapely.union_all([_shadow(part) for part in parts])
    assert shadow.symmetric_difference(polygon).area < 0.1 + 0.002 * polygon.area
    assert min(p.position_m[2] - p.size_m[2] / 2 for p in parts) == pytest.approx(0.0, abs=1e-6)
    assert max(p.position_m[2] + p.size_m[2] / 2 for p in parts) == pytest.approx(3.0, abs=1e-6)


def test_windows_look_outwards_from_every_long_wall():
    parts = object_parts("building", Look((10.0, 8.0, 6.0), {"outline": L_SHAPE}, 1))
    panes = [part for part in parts if part.material.startswith("facade")]
    assert len(panes) == 6
    polygon = shapely.from_wkt(L_SHAPE)
    for pane in panes:
        w, x, y, z = pane.quat_wxyz
        out = np.array([2 * (x * z + w * y), 2 * (y * z - w * x)])
        middle = np.array(pane.position_m[:2])
        assert polygon.distance(shapely.Point(middle + 0.2 * out)) == pytest.approx(0.2, abs=1e-6)


def _shadow(part) -> shapely.Geometry:
    x, y, _ = part.position_m
    if part.kind == "mesh":
        points = [(u + x, v + y) for u, v, _ in part.vertices_m]
    else:
        w, _, _, s = part.quat_wxyz
        yaw = 2 * math.atan2(s, w)
        c, s = math.cos(yaw), math.sin(yaw)
        half_u, half_v = part.size_m[0] / 2, part.size_m[1] / 2
        corners = ((half_u, half_v), (-half_u, half_v), (-half_u, -half_v), (half_u, -half_v))
        points = [(x + c * u - s * v, y + s * u + c * v) for u, v in corners]
    return shapely.MultiPoint(points).convex_hull


def test_an_outline_is_as_many_rectangles_as_it_has_wings():
    (single,) = rectangles_of(outlined(SHAPES["rectangle"]))
    assert single[0] == pytest.approx((20.0, 30.0))
    wings = rectangles_of(outlined(L_SHAPE, 0.3))
    assert len(wings) == 2
    assert sum(length * width for _, _, (length, width) in wings) == pytest.approx(60.0)
