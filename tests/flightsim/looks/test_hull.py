import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from flightsim.looks.hull import HullError, hull_faces

BOX = np.array([(x, y, z) for x in (0.0, 2.0) for y in (0.0, 3.0) for z in (0.0, 1.0)])
POINTS = arrays(
    float, st.tuples(st.integers(5, 14), st.just(3)), elements=st.integers(-20, 20).map(float)
)


def edges(faces):
    return [(f[i], f[(i + 1) % len(f)]) for _, f in faces for i in range(len(f))]


def test_box_has_six_quads_facing_along_the_axes():
    faces = hull_faces(BOX)
    assert sorted(len(members) for _, members in faces) == [4] * 6
    normals = {tuple(normal.round(9).tolist()) for normal, _ in faces}
    assert normals == {tuple(sign * row) for row in np.eye(3) for sign in (1.0, -1.0)}


def test_corner_inside_a_face_and_point_inside_the_solid_change_nothing():
    more = np.vstack([BOX, [(1.0, 1.5, 1.0), (1.0, 1.5, 0.5), (1.0, 0.0, 0.0)]])
    assert {frozenset(f.tolist()) for _, f in hull_faces(more)} == {
        frozenset(f.tolist()) for _, f in hull_faces(BOX)
    }


def test_flat_corners_are_named():
    flat = BOX * (1.0, 1.0, 0.0)
    with pytest.raises(HullError, match=r"8 vertices lie in one plane; valid: vertices of a solid"):
        hull_faces(flat)


@given(POINTS)
def test_hull_is_closed_outward_and_holds_every_point(points):
    try:
        faces = hull_faces(points)
    except HullError:
        return
    directed = edges(faces)
    assert len(set(directed)) == len(directed)
    assert {(b, a) for a, b in directed} == set(directed)
    for normal, members in faces:
        assert np.linalg.norm(normal) == pytest.approx(1.0)
        assert ((points - points[members[0]]) @ normal <= 1e-4).all()
        a, b, c = points[members[:3]]
        assert np.cross(b - a, c - b) @ normal > 0
