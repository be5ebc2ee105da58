from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from aeroscene.solids.solids import Solids, colliding, hull_faces
from tests.aeroscene.sampling_solids import holds
from tests.aeroscene.solids.test_voxels import WEDGE, primitives

SOLIDS = st.lists(primitives(), min_size=1, max_size=6)


@given(SOLIDS)
@settings(max_examples=40, deadline=None)
def test_solids_reach_as_far_along_a_vector_as_their_points(found):
    solids = Solids(found)
    axes = np.random.default_rng(1).normal(size=(5, 3))
    every = np.arange(len(solids))
    reach = solids.reach_along(axes, every)
    assert np.allclose(reach[::-1], solids.reach_along(axes, every[::-1]))
    for index, primitive in enumerate(found):
        heights = (solids.points(index) - solids.centre_m[index]) @ axes.T
        outermost = np.stack([-heights.min(axis=0), heights.max(axis=0)], axis=-1)
        assert np.all(outermost <= reach[index] + 1e-9)
        if primitive.kind in {"box", "mesh"}:
            assert np.allclose(outermost, reach[index])
        else:
            assert np.all(outermost >= 0.9 * reach[index])


@given(SOLIDS)
@settings(max_examples=40, deadline=None)
def test_points_lie_on_their_solid(found):
    solids = Solids(found)
    for index, primitive in enumerate(found):
        points = solids.points(index)
        assert holds(primitive, points, grow_m=1e-6).all()
        assert not holds(primitive, points, grow_m=-1e-3).any()


@given(SOLIDS, st.integers(0, 100))
@settings(max_examples=40, deadline=None)
def test_nothing_near_a_box_is_missed(found, seed):
    solids = Solids(found)
    corners = np.sort(np.random.default_rng(seed).uniform(-2, 2, (2, 3)), axis=0)
    near = set(solids.near(*corners).tolist())
    points = np.random.default_rng(seed).uniform(*corners, (500, 3))
    for index, primitive in enumerate(found):
        if index not in near:
            assert not holds(primitive, points).any()


def test_faces_of_a_hull_are_whole_and_look_outwards():
    faces = hull_faces(WEDGE)
    vertices = np.array(WEDGE)
    assert sorted(len(corners) for corners in faces.corners) == [3, 3, 3, 3, 4]
    for plane, corners in zip(faces.planes, faces.corners, strict=True):
        heights = vertices @ plane[:3] + plane[3]
        assert np.allclose(heights[corners], 0.0)
        assert np.all(heights <= 1e-9)


def test_an_empty_scene_has_no_solids():
    solids = colliding([])
    assert len(solids) == 0
    assert not len(solids.near(np.zeros(3), np.ones(3)))
