from __future__ import annotations

import math
import re

import pytest
import shapely

from aeroscene.files.bounds import MOST_POINTS
from aeroscene.scene import OrientedBox, SceneError, SceneObject
from aeroscene.scene.box import quat_from_yaw
from aeroscene.scene.catalogue import category_id
from aeroscene.scene.footprint import footprint

L_SHAPE = "POLYGON ((-5 -4, 5 -4, 5 4, 0 4, 0 0, -5 0, -5 -4))"
CIRCLE = shapely.to_wkt(shapely.Point(0, 0).buffer(3.9, quad_segs=MOST_POINTS))


def outlined(outline: object, yaw_rad: float = 0.0, quat=None) -> SceneObject:
    box = OrientedBox((20.0, 30.0, 3.0), quat or quat_from_yaw(yaw_rad), (10.0, 8.0, 6.0))
    return SceneObject(
        id=1,
        scene_id="made",
        parent_id=None,
        category_id=category_id("building"),
        bbox=box,
        domain="outdoor",
        attributes={"outline": outline},
    )


def test_a_footprint_is_the_outline_turned_and_moved_with_its_box():
    found = footprint(outlined(L_SHAPE, math.pi / 2))
    assert found.area == pytest.approx(60.0)
    assert found.bounds == pytest.approx((16.0, 25.0, 24.0, 35.0))
    assert found.covers(shapely.Point(24 - 2, 26))
    assert not found.covers(shapely.Point(17, 26))


WRONG = {
    "no text": 5,
    "no polygon": "POINT (0 0)",
    "nothing": "POLYGON EMPTY",
    "several": "MULTIPOLYGON (((0 0, 1 0, 1 1, 0 0)))",
    "broken": "POLYGON ((0 0, 1 0",
    "crossing itself": "POLYGON ((-4 -3, 4 3, 4 -3, -4 3, -4 -3))",
    "out of its box": "POLYGON ((-6 -4, 5 -4, 5 4, -6 -4))",
    "not finite": "POLYGON ((-5 -4, 5 nan, 5 4, -5 -4))",
    "infinite": "POLYGON ((-5 -4, 5 inf, 5 4, -5 -4))",
    "too many corners": CIRCLE,
    "too long": "POLYGON (" + " " * 100_000 + "(0 0, 1 0, 1 1, 0 0))",
}


@pytest.mark.parametrize("name", WRONG)
def test_what_is_no_outline_is_refused_in_one_line(name):
    fault = "object 1: attributes.outline is "
    with pytest.raises(SceneError, match=re.escape(fault)) as caught:
        outlined(WRONG[name])
    assert "; valid: the well-known text of one polygon inside the box" in str(caught.value)
    assert len(str(caught.value)) < 500


def test_an_object_with_an_outline_stands_upright():
    half = math.sqrt(0.5)
    with pytest.raises(SceneError, match="valid: an upright box for an object with outline"):
        outlined(L_SHAPE, quat=(half, half, 0.0, 0.0))
