from __future__ import annotations

import numpy as np
import shapely
from hypothesis import given
from hypothesis import strategies as st

from aeroscene.feasibility.boxes import boxes_of, forbidden_overlaps, separation
from aeroscene.scene.geometry import penetration_depth
from tests.aeroscene.feasibility.scenes import CUP, GARDEN, TABLE, thing

places = st.floats(-2.0, 2.0)
sides = st.floats(0.2, 3.0)
turns = st.floats(-3.2, 3.2)


@given(places, places, sides, sides, turns, turns)
def test_separation_agrees_with_polygons(x, y, long, wide, first, second):
    boxes = boxes_of(
        [
            thing(0, "crate", (0.0, 0.0, 0.5), (1.0, 2.0, 1.0), yaw_rad=first),
            thing(1, "crate", (x, y, 0.5), (long, wide, 1.0), yaw_rad=second),
        ]
    )
    gap, normal = separation(boxes, np.array([0]), np.array([1]))
    outlines = [shapely.Polygon(corners) for corners in boxes.corners()]
    parted = shapely.Polygon(boxes.corners()[1] - gap[0] * normal[0])
    if gap[0] > 1e-9:
        assert shapely.distance(outlines[0], outlines[1]) >= gap[0] - 1e-9
    else:
        assert shapely.intersection(outlines[0], parted).area < 1e-6


@given(places, places, st.floats(-1.0, 1.0), turns)
def test_depth_is_that_of_the_general_boxes(x, y, z, turn):
    first = thing(0, "crate", (0.0, 0.0, 5.0), (1.0, 2.0, 1.0))
    second = thing(1, "crate", (x, y, 5.0 + z), (1.4, 0.6, 1.2), yaw_rad=turn)
    a, b = first.bbox, second.bbox
    depth = float(penetration_depth(a.p, a.q, a.s, b.p, b.q, b.s))
    found = forbidden_overlaps(boxes_of([first, second]))
    if depth > 1e-9:
        np.testing.assert_allclose(found.depth_m, depth, atol=1e-6)
    else:
        assert not len(found.pairs)


def test_what_belongs_together_may_overlap():
    boxes = boxes_of(GARDEN)
    assert boxes.is_kin[TABLE, CUP]
    assert boxes.is_kin[CUP, 0]
    assert not boxes.is_kin[CUP, 4]
    assert not len(forbidden_overlaps(boxes).pairs)
