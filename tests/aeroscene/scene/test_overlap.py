"""Exact IoU, held against shapely, against convex hulls and against what it must be."""

import math
from itertools import combinations

import numpy as np
import pytest
import shapely
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.spatial import ConvexHull, QhullError

from aeroscene.scene.box import rotation_matrix
from aeroscene.scene.overlap import pair_iou
from tests.aeroscene.metrics.scenes import box

CUBE = (0.0, 0.0, 0.0), (1.0, 1.0, 1.0)
metres = st.floats(-1.5, 1.5)
extents = st.floats(0.05, 3.0)
yaws = st.one_of(st.sampled_from([0.0, 45.0, 90.0, 180.0, 30.0]), st.floats(-180, 180))
upright = st.builds(
    box, st.tuples(metres, metres, metres), st.tuples(extents, extents, extents), yaws
)
quaternions = (
    st.tuples(*[st.floats(-1, 1)] * 4)
    .filter(lambda q: math.hypot(*q) > 0.1)
    .map(lambda q: tuple(value / math.hypot(*q) for value in q))
)
tilted = st.builds(
    box,
    st.tuples(metres, metres, metres),
    st.tuples(extents, extents, extents),
    st.just(0.0),
    quaternions,
)


def pairwise(firsts, seconds):
    columns = [
        np.array([getattr(b, name) for b in boxes]) for boxes in (firsts, seconds) for name in "pqs"
    ]
    return pair_iou(*columns)


def by_shapely(first, second):
    def outline(b):
        c, s = math.cos(b.yaw_rad), math.sin(b.yaw_rad)
        corners = [
            (i * b.s[0] / 2, j * b.s[1] / 2) for i, j in ((1, 1), (-1, 1), (-1, -1), (1, -1))
        ]
        return shapely.Polygon(
            [(b.p[0] + c * x - s * y, b.p[1] + s * x + c * y) for x, y in corners]
        )

    low = max(b.p[2] - b.s[2] / 2 for b in (first, second))
    high = min(b.p[2] + b.s[2] / 2 for b in (first, second))
    area = shapely.intersection(outline(first), outline(second), grid_size=1e-9).area
    shared = area * max(high - low, 0.0)
    return shared / (math.prod(first.s) + math.prod(second.s) - shared)


def by_hulls(first, second):
    """All corners of the shared solid: where three of the twelve faces meet, within both boxes."""
    normals, offsets = [], []
    for one in (first, second):
        for axis, half in zip(rotation_matrix(one.q).T, np.array(one.s) / 2, strict=True):
            for sign in (1, -1):
                normals.append(sign * axis)
                offsets.append(sign * axis @ one.p + half)
    normals, offsets = np.array(normals), np.array(offsets)
    triples = np.array(list(combinations(range(12), 3)))
    a, b, c = normals[triples].swapaxes(0, 1)
    is_corner = np.abs((np.cross(a, b) * c).sum(axis=1)) > 1e-9
    triples = triples[is_corner]
    points = np.linalg.solve(normals[triples], offsets[triples][..., None])[..., 0]
    points = points[(points @ normals.T <= offsets + 1e-9).all(axis=1)]
    try:
        shared = ConvexHull(points).volume
    except (QhullError, ValueError):
        shared = 0.0  # flat or empty
    return shared / (math.prod(first.s) + math.prod(second.s) - shared)


@given(st.lists(st.tuples(upright, upright), min_size=1, max_size=20))
def test_of_upright_boxes_is_what_shapely_says(pairs):
    found = pairwise(*zip(*pairs, strict=True))
    assert found == pytest.approx([by_shapely(*pair) for pair in pairs], abs=1e-6)


@given(st.lists(st.tuples(tilted, tilted), min_size=1, max_size=5))
@example(
    [(box(*CUBE, 0.0, (0.0, 0.5**0.5, 0.5**0.5, 0.0)), box(*CUBE, 0.0, (0.0, 2e-308, 0.0, 1.0)))]
)
@settings(max_examples=30)
def test_of_tilted_boxes_is_what_convex_hulls_say(pairs):
    found = pairwise(*zip(*pairs, strict=True))
    assert found == pytest.approx([by_hulls(*pair) for pair in pairs], abs=1e-6)


@given(tilted, tilted)
@settings(max_examples=25)
def test_is_symmetric_and_between_nothing_and_all(first, second):
    there, back = (pairwise([a], [b]) for a, b in ((first, second), (second, first)))
    assert there == pytest.approx(back, abs=1e-7)
    assert 0.0 <= there[0] <= 1.0 + 1e-9


@given(tilted)
@settings(max_examples=25)
def test_of_a_box_with_itself_is_one(one):
    assert pairwise([one], [one]) == pytest.approx([1.0])


def test_of_boxes_that_touch_is_nothing_and_of_halves_is_a_third():
    one, beside, half = (box((x, 0, 0), (2, 2, 2)) for x in (0, 2, 1))
    found = pairwise([one, one], [beside, half])
    assert found == pytest.approx([0.0, 1 / 3], abs=1e-8)


@given(tilted, st.floats(-1e-12, 1e-12))
@settings(max_examples=25)
def test_of_boxes_side_by_side_is_nothing_whatever_rounding_makes_of_their_faces(one, off_m):
    axis = rotation_matrix(one.q)[:, 0]
    beside = box(np.array(one.p) + (one.s[0] + off_m) * axis, one.s, q=one.q)
    assert pairwise([one], [beside]) == pytest.approx([0.0], abs=1e-6)
