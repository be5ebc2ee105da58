"""Frames: the conversions are their own inverse and agree with scipy and pymap3d."""

import math

import numpy as np
import pymap3d
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from flightsim.frames import (
    Geodetic,
    LocalFrame,
    euler_rpy_rad,
    swap_enu_ned,
    swap_flu_frd,
    swap_quat_enu_flu_ned_frd,
    swap_yaw_enu_ned,
)

ROTATION_NED_FROM_ENU = np.array([[0, 1, 0], [1, 0, 0], [0, 0, -1]])
ROTATION_FLU_FROM_FRD = np.diag([1, -1, -1])

coordinates = st.floats(-1e4, 1e4)
vectors = st.tuples(coordinates, coordinates, coordinates)
angles = st.floats(-math.pi, math.pi)
components = st.floats(-1, 1)
quaternions = (
    st.tuples(components, components, components, components)
    .filter(lambda q: np.linalg.norm(q) > 1e-3)
    .map(lambda q: tuple(float(c) for c in np.array(q) / np.linalg.norm(q)))
)


@given(vectors)
def test_vector_swaps_are_their_own_inverse(vector):
    assert swap_enu_ned(swap_enu_ned(vector)) == vector
    assert swap_flu_frd(swap_flu_frd(vector)) == vector


@given(vectors)
def test_enu_ned_is_the_rotation_matrix(vector):
    np.testing.assert_allclose(swap_enu_ned(vector), ROTATION_NED_FROM_ENU @ vector)


@given(quaternions)
def test_attitude_swap_changes_both_frames(quat_wxyz):
    rotation_enu_from_flu = Rotation.from_quat(quat_wxyz, scalar_first=True).as_matrix()
    expected = ROTATION_NED_FROM_ENU @ rotation_enu_from_flu @ ROTATION_FLU_FROM_FRD
    swapped = Rotation.from_quat(swap_quat_enu_flu_ned_frd(quat_wxyz), scalar_first=True)
    np.testing.assert_allclose(swapped.as_matrix(), expected, atol=1e-12)


@given(quaternions)
def test_attitude_swap_has_a_non_negative_scalar_part(quat_wxyz):
    assert swap_quat_enu_flu_ned_frd(quat_wxyz)[0] >= 0


@given(angles)
def test_yaw_swap_is_its_own_inverse_up_to_a_turn(yaw_rad):
    twice = swap_yaw_enu_ned(swap_yaw_enu_ned(yaw_rad))
    assert math.isclose(math.remainder(twice - yaw_rad, 2 * math.pi), 0.0, abs_tol=1e-9)


def test_heading_east_is_ninety_degrees_from_north():
    assert swap_yaw_enu_ned(0.0) == pytest.approx(math.pi / 2)
    assert swap_yaw_enu_ned(math.pi / 2) == pytest.approx(0.0)


@given(angles, st.floats(-1.5, 1.5), angles)
def test_euler_angles_agree_with_scipy(roll, pitch, yaw):
    rotation = Rotation.from_euler("ZYX", [yaw, pitch, roll])
    rpy_rad = euler_rpy_rad(tuple(rotation.as_quat(scalar_first=True)))
    again = Rotation.from_euler("ZYX", rpy_rad[::-1])
    assert (rotation.inv() * again).magnitude() < 1e-6


@given(st.floats(-60, 60), st.floats(-179, 179), st.floats(-400, 400), st.floats(-400, 400))
def test_local_frame_agrees_with_the_ellipsoid_near_the_origin(latitude, longitude, east, north):
    frame = LocalFrame(Geodetic(latitude, longitude, 488.0))
    place = frame.geodetic_from_enu((east, north, 20.0))
    exact = pymap3d.geodetic2enu(
        place.latitude_deg, place.longitude_deg, place.altitude_m, latitude, longitude, 488.0
    )
    assert math.hypot(exact[0] - east, exact[1] - north) < 0.2
    np.testing.assert_allclose(
        frame.enu_from_geodetic(place), (east, north, 20.0), rtol=0, atol=1e-6
    )
