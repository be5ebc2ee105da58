import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from autonomy.perception import camera_pose
from tests.autonomy.depth_scene import quat_of

angles = st.floats(-math.pi, math.pi)
vectors = st.tuples(*[st.floats(-2.0, 2.0)] * 3)


def test_forward_camera_of_a_level_vehicle_looks_east_with_up_above():
    position, rotation = camera_pose((1.0, 2.0, 3.0), (1.0, 0.0, 0.0, 0.0), (0.1, 0.2, 0.3), 0.0)
    assert position == pytest.approx((1.1, 2.2, 3.3))
    np.testing.assert_allclose(rotation.T, [(0, -1, 0), (0, 0, -1), (1, 0, 0)], atol=1e-12)


def test_down_camera_has_the_nose_at_the_top_of_its_image():
    north = quat_of((0.0, 0.0, math.pi / 2))
    position, rotation = camera_pose((0.0, 0.0, 5.0), north, (0.5, 0.0, 0.0), math.pi / 2)
    assert position == pytest.approx((0.0, 0.5, 5.0))
    np.testing.assert_allclose(rotation[:, 2], (0, 0, -1), atol=1e-12)
    np.testing.assert_allclose(-rotation[:, 1], (0, 1, 0), atol=1e-12)


@given(vectors, vectors, vectors, angles)
def test_pose_is_rigid(position, rotation_vector, mount, dip):
    eye, rotation = camera_pose(position, quat_of(rotation_vector), mount, dip)
    np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-9)
    assert np.linalg.det(rotation) == pytest.approx(1.0)
    assert math.dist(eye, position) == pytest.approx(math.hypot(*mount), abs=1e-9)
