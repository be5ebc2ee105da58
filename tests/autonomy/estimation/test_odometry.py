"""Odometry in a drifting frame: relative, honest about drift, filterpy's equal where linear."""

import numpy as np
import pytest
from filterpy.kalman import KalmanFilter
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from autonomy.estimation.error_state import ATTITUDE, N_STATES, VIO_ORIGIN, VIO_YAW
from autonomy.estimation.odometry import fuse_vio
from autonomy.estimation.past import restart_past
from tests.autonomy.sample_filters import DT, error_between, filter_at, fly, moving_filter


def pose_in(frame_yaw, origin, position):
    """What odometry with this frame reports of a position with heading 0."""
    turned = Rotation.from_euler("z", -frame_yaw).apply(np.subtract(position, origin))
    return turned, -frame_yaw


@settings(max_examples=20)
@given(st.floats(-3.0, 3.0), st.integers(0, 30))
def test_a_frame_of_any_heading_agrees_with_straight_flight(frame_yaw, age):
    velocity = np.array([4.0, -2.0, 0.5])
    f = moving_filter(velocity, sigma=0.1)
    fly(f, 64)
    origin = np.array([3.0, -5.0, 1.0])
    for _ in range(8):
        fly(f, 10)
        valid = velocity * (f["tick"] - age) * DT
        fuse_vio(f, *pose_in(frame_yaw, origin, valid), age)
    np.testing.assert_allclose(f["position_enu_m"], velocity * f["tick"] * DT, atol=1e-6)
    np.testing.assert_allclose(f["vio_origin_enu_m"], origin, atol=1e-6)
    assert np.linalg.eigvalsh(f["covariance"]).min() > -1e-12


def test_the_first_pose_places_the_frame_and_moves_nothing():
    f = moving_filter(np.zeros(3))
    before = f.copy()
    fuse_vio(f, np.array([7.0, 8.0, 9.0]), 0.3, 0)
    assert f["has_vio"] == 1
    moved = error_between(f, before)
    assert np.all(moved[:VIO_ORIGIN] == 0.0)
    P = f["covariance"]
    np.testing.assert_array_equal(P, P.T)
    # the origin is wrong by what the position is wrong by, and by the heading times its distance
    assert P[VIO_ORIGIN, 0] == pytest.approx(P[0, 0])
    assert P[VIO_YAW, ATTITUDE + 2] == pytest.approx(P[8, 8])
    arm = np.hypot(7.0, 8.0)
    horizontal = P[VIO_ORIGIN, VIO_ORIGIN] + P[VIO_ORIGIN + 1, VIO_ORIGIN + 1]
    expected = 2 * (P[0, 0] + f["vio_variance_m2"]) + arm**2 * P[VIO_YAW, VIO_YAW]
    assert horizontal == pytest.approx(expected)


def test_without_satellites_doubt_grows_with_the_way_flown_and_not_at_rest():
    def sigma_after(velocity):
        f = moving_filter(np.array([velocity, 0.0, 0.0]), sigma=0.05)
        for k in range(100):
            fly(f, 10)
            fuse_vio(f, np.array([velocity * (k + 1) * 10 * DT, 0.0, 0.0]), 0.0, 0)
        return f["covariance"][1, 1]

    resting, flying = sigma_after(0.0), sigma_after(5.0)
    assert resting == pytest.approx(0.05**2, rel=0.2)
    # 20 m at 0.025 m/sqrt(m), the heading's share on top
    assert flying - resting > 20.0 * 0.025**2
    assert flying - resting < 0.3


def test_a_pose_with_a_known_frame_is_filterpys_update():
    """Its heading is said to be worthless here: that part is not linear."""
    f = filter_at(np.random.default_rng(4))
    P = f["covariance"]
    P[VIO_YAW, :] = P[:, VIO_YAW] = 0.0
    f["has_vio"], f["vio_yaw_rad"], f["velocity_enu_mps"] = 1, 0.4, 0.0
    f["vio_yaw_variance_rad2"] = 1e18
    restart_past(f)
    z = np.array([0.01, -0.02, 0.005])
    H = np.zeros((3, N_STATES))
    H[:, :3], H[:, VIO_ORIGIN : VIO_ORIGIN + 3] = np.eye(3), -np.eye(3)
    oracle = KalmanFilter(dim_x=N_STATES, dim_z=3)
    oracle.x, oracle.P = np.zeros((N_STATES, 1)), P.copy()
    oracle.update(z[:, None], R=f["vio_variance_m2"] * np.eye(3), H=H)
    turned = f["position_enu_m"] + z - f["vio_origin_enu_m"]
    before = f.copy()
    fuse_vio(f, Rotation.from_euler("z", -0.4).apply(turned), 0.0, 0)
    moved = error_between(f, before)
    linear = np.r_[0:6, 9:N_STATES]
    np.testing.assert_allclose(moved[linear], oracle.x[linear, 0], atol=1e-9)
    np.testing.assert_allclose(f["covariance"], oracle.P, atol=1e-9)


def test_odometry_that_restarts_elsewhere_gets_a_new_frame():
    f = moving_filter(np.zeros(3), sigma=0.05)
    fuse_vio(f, np.zeros(3), 0.0, 0)
    for k in range(31):
        fly(f, 10)
        fuse_vio(f, np.array([50.0, 0.0, 0.0]), 0.0, 0)
        assert abs(f["position_enu_m"][0]) < 0.01, k
    assert f["vio_origin_enu_m"][0] == pytest.approx(-50.0, abs=0.1)


def test_a_pose_that_is_grossly_wrong_is_not_believed_along_the_axis_where_it_is_right():
    f = moving_filter(np.zeros(3), sigma=0.05)
    fuse_vio(f, np.zeros(3), 0.0, 0)
    for _ in range(10):
        fly(f, 10)
        before = f["covariance"].copy()
        fuse_vio(f, np.array([50.0, 0.0, -50.0]), 0.0, 0)
        assert np.all(f["covariance"][:3, :3] >= before[:3, :3] - 1e-12)
