"""Poses in the world: what is left out stays, and a restart moves what it names alone."""

import math

import numpy as np
import pytest

from autonomy.estimation.error_state import BARO_OFFSET
from autonomy.estimation.motion_capture import (
    fuse_mocap,
    fuse_pose,
    fuse_velocity,
    restart_position,
)
from autonomy.estimation.odometry import fuse_odometry, fuse_vio
from autonomy.rotation import yaw_from_quat
from tests.autonomy.sample_filters import DT, error_between, fly, moving_filter

_UNUSED = math.inf


def _resting():
    f = moving_filter(np.zeros(3), sigma=0.5)
    fly(f, 64)
    return f


def test_motion_capture_is_a_pose_with_its_own_variances():
    f, g = _resting(), _resting()
    pose = np.array([0.1, -0.2, 0.05])
    fuse_mocap(f, pose, 0.01, 2)
    variance, yaw_variance = g["mocap_variance_m2"], g["mocap_yaw_variance_rad2"]
    fuse_pose(g, pose, 0.01, 2, variance, variance, yaw_variance)
    assert f.tobytes() == g.tobytes()


def test_odometry_of_others_is_fused_as_ours_with_its_own_variances():
    f, g = _resting(), _resting()
    variance, yaw_variance = g["vio_variance_m2"], g["vio_yaw_variance_rad2"]
    for x in (0.0, 0.02):
        fuse_vio(f, np.array([x, 0.0, 0.0]), 0.3, 2)
        pose = np.array([x, 0.0, 0.0])
        fuse_odometry(g, pose, 0.3, 2, variance, variance, yaw_variance)
    assert f.tobytes() == g.tobytes()


@pytest.mark.parametrize(
    ("variances", "moved"),
    [
        ((1e-4, _UNUSED, _UNUSED), [True, True, False, False]),
        ((_UNUSED, 1e-4, _UNUSED), [False, False, True, False]),
        ((_UNUSED, _UNUSED, 1e-4), [False, False, False, True]),
    ],
)
def test_an_infinite_variance_leaves_its_axes_out(variances, moved):
    f = moving_filter(np.zeros(3), sigma=0.5)
    f["covariance"] = np.diag(np.full(len(f["covariance"]), 0.25))
    before = f.copy()
    fuse_pose(f, np.full(3, 0.3), yaw_from_quat(f["quat_wxyz"]) + 0.1, 0, *variances)
    error = error_between(f, before)
    assert (np.abs(error[[0, 1, 2, 8]]) > 1e-3).tolist() == moved


def test_a_pose_far_off_is_refused_and_says_so():
    f = _resting()
    before = f.copy()
    worst, yaw_ratio = fuse_pose(f, np.full(3, 100.0), 0.0, 0, 1e-4, 1e-4, _UNUSED)
    assert worst > 1.0
    assert yaw_ratio == 0.0
    assert np.all(error_between(f, before) == 0.0)


def test_a_restart_moves_the_position_and_keeps_the_barometer_true():
    f = _resting()
    pressure_altitude = f["position_enu_m"][2] + f["baro_offset_m"]
    velocity = f["velocity_enu_mps"].copy()
    restart_position(f, np.array([10.0, 20.0, 5.0]), 5, 0.01, 0.04)
    expected = np.array([10.0, 20.0, 5.0]) + 5 * DT * velocity
    np.testing.assert_allclose(f["position_enu_m"], expected)
    assert f["position_enu_m"][2] + f["baro_offset_m"] == pytest.approx(pressure_altitude)
    P = f["covariance"]
    np.testing.assert_allclose(np.diag(P)[:3], [0.01, 0.01, 0.04])
    assert P[BARO_OFFSET, BARO_OFFSET] >= 0.04
    assert np.linalg.eigvalsh(P).min() > -1e-12
    restart_position(f, np.full(3, 99.0), 0, _UNUSED, 0.04)
    np.testing.assert_allclose(f["position_enu_m"][:2], expected[:2])
    assert f["position_enu_m"][2] == pytest.approx(99.0)


def test_a_velocity_draws_the_estimate_to_it():
    f = moving_filter(np.zeros(3), sigma=0.5)
    f["covariance"] = np.diag(np.full(len(f["covariance"]), 0.25))
    for _ in range(20):
        fuse_velocity(f, np.array([0.4, 0.0, -0.2]), 0, 0.01)
    np.testing.assert_allclose(f["velocity_enu_mps"], [0.4, 0.0, -0.2], atol=0.01)
