"""GNSS, barometer and magnetometer into the filter."""

import math

import numpy as np
import pytest
from filterpy.kalman import KalmanFilter
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from scipy.spatial.transform import Rotation

from autonomy.estimation.error_state import GNSS_WANDER, N_STATES
from autonomy.estimation.fusion import (
    fuse_barometer,
    fuse_gnss,
    fuse_magnetometer,
    heading_innovation,
)
from autonomy.estimation.past import restart_past
from tests.autonomy.sample_filters import (
    DT,
    add_error,
    error_between,
    filter_at,
    fly,
    moving_filter,
)

FIELD = np.array([0.8, 21.5, -42.8])
SIGMA_M, SIGMA_MPS = np.full(3, 0.05), np.full(3, 0.05)


def test_a_late_fix_is_compared_with_the_estimate_of_its_time():
    velocity = np.array([8.0, -3.0, 1.0])
    f = moving_filter(velocity)
    fly(f, 100)
    true_now = velocity * 100 * DT
    fuse_gnss(f, velocity * 70 * DT, velocity, 30, SIGMA_M, SIGMA_MPS)
    np.testing.assert_allclose(f["position_enu_m"], true_now, atol=1e-9)
    assert f["ratio_gnss_position"] == pytest.approx(0.0, abs=1e-12)


def test_a_fix_is_filterpys_prediction_and_update():
    """The receiver's wander decays to this fix, then position and velocity are one measurement."""
    f = filter_at(np.random.default_rng(2), max_gnss_rejections=1000)
    f["tick"] = 25
    restart_past(f)
    decay = math.exp(-25 * DT / 60.0)
    oracle = KalmanFilter(dim_x=N_STATES, dim_z=6)
    oracle.x, oracle.P = np.zeros((N_STATES, 1)), f["covariance"].copy()
    wander = slice(GNSS_WANDER, GNSS_WANDER + 3)
    oracle.F = np.eye(N_STATES)
    oracle.F[wander, wander] *= decay
    oracle.Q = np.zeros((N_STATES, N_STATES))
    oracle.Q[wander, wander] = (1.0 - decay**2) * np.diag([0.03, 0.03, 0.05]) ** 2
    oracle.predict()
    H = np.zeros((6, N_STATES))
    H[:3, :3] = H[:3, wander] = H[3:, 3:6] = np.eye(3)
    z = 0.02 * np.random.default_rng(3).normal(size=6)
    oracle.update(z[:, None], R=np.diag([0.05**2] * 6), H=H)
    before = f.copy()
    position = f["position_enu_m"] + z[:3]
    fuse_gnss(f, position, f["velocity_enu_mps"] + z[3:], 0, SIGMA_M, SIGMA_MPS)
    moved = error_between(f, before)
    linear = np.r_[0:6, 9:N_STATES]
    np.testing.assert_allclose(moved[linear], oracle.x[linear, 0], atol=1e-9)
    np.testing.assert_allclose(f["covariance"], oracle.P, atol=1e-9)


def test_beside_odometry_a_far_fix_moves_the_estimate_by_a_small_step():
    f = moving_filter(np.zeros(3), sigma=0.5, max_gnss_step_m=0.03)
    f["has_vio"] = 1
    far = np.array([0.8, -0.6, 0.4])
    last, steps = np.zeros(3), []
    for _ in range(60):
        fuse_gnss(f, far, np.zeros(3), 0, SIGMA_M, SIGMA_MPS)
        steps.append(np.abs(f["position_enu_m"] - last).max())
        last = f["position_enu_m"].copy()
    assert max(steps) <= 0.03 + 1e-9
    np.testing.assert_allclose(last, far, atol=0.1)


def test_beside_odometry_a_fast_fix_moves_the_position_by_a_small_step():
    f = moving_filter(np.zeros(3), sigma=0.2, max_gnss_step_m=0.03)
    f["has_vio"] = 1
    for i in range(3):
        f["covariance"][i, 3 + i] = f["covariance"][3 + i, i] = 0.9 * 0.2**2
    fuse_gnss(f, np.zeros(3), np.array([0.4, 0.0, 0.0]), 0, SIGMA_M, SIGMA_MPS)
    assert 0.02 < f["position_enu_m"][0] <= 0.03 + 1e-9
    assert f["ratio_gnss_velocity"] > 0.0


def test_late_fixes_pull_a_wrong_estimate_onto_the_moving_truth():
    velocity = np.array([5.0, 0.0, 0.0])
    f = moving_filter(velocity)
    add_error(f, np.concatenate([[1.0, -0.5, 0.3, 0.2, 0.1, -0.1], np.zeros(19)]))
    for k in range(1, 40):
        fly(f, 25)
        true = velocity * (25 * k - 30) * DT
        if k > 1:
            fuse_gnss(f, true, velocity, 30, SIGMA_M, SIGMA_MPS)
    np.testing.assert_allclose(f["position_enu_m"], velocity * 25 * 39 * DT, atol=0.02)
    np.testing.assert_allclose(f["velocity_enu_mps"], velocity, atol=0.02)


def test_a_jump_of_the_receiver_is_refused_then_believed():
    f = moving_filter(np.zeros(3), sigma=0.1)
    f["max_gnss_rejections"] = 5
    far = np.array([30.0, 0.0, 0.0])
    for _ in range(4):
        fly(f, 25)
        fuse_gnss(f, far, np.zeros(3), 30, SIGMA_M, SIGMA_MPS)
        assert f["ratio_gnss_position"] > 1.0
        assert abs(f["position_enu_m"][0]) < 0.1
    fuse_gnss(f, far, np.zeros(3), 30, SIGMA_M, SIGMA_MPS)
    np.testing.assert_allclose(f["position_enu_m"], far, atol=1e-9)
    assert np.linalg.eigvalsh(f["covariance"]).min() >= 0.0
    fuse_gnss(f, far, np.zeros(3), 30, SIGMA_M, SIGMA_MPS)
    assert f["ratio_gnss_position"] < 1e-6  # the past was moved along


def test_the_barometer_smooths_height_without_deciding_it():
    """A barometer 50 m off is an offset, not a height, once GNSS has said what height is."""
    f = moving_filter(np.zeros(3), sigma=0.1)
    f["baro_offset_m"] = 50.0
    rng = np.random.default_rng(3)
    for k in range(500):
        fly(f, 5)
        fuse_barometer(f, 50.4 + 0.1 * rng.normal())
        if k % 5 == 4:
            fuse_gnss(f, np.zeros(3), np.zeros(3), 30, SIGMA_M, SIGMA_MPS)
    assert f["position_enu_m"][2] == pytest.approx(0.0, abs=0.05)
    assert f["baro_offset_m"] == pytest.approx(50.4, abs=0.07)


@given(
    hnp.arrays(float, 3, elements=st.floats(-0.6, 0.6)),
    st.floats(-3.0, 3.0),
    st.integers(0, 2),
)
def test_heading_row_is_the_derivative_of_the_innovation(tilt, yaw, axis):
    f = filter_at(np.random.default_rng(0))
    f["field_enu_ut"] = FIELD
    true = Rotation.from_euler("z", yaw) * Rotation.from_rotvec([tilt[0], tilt[1], 0.0])
    f["quat_wxyz"] = true.as_quat(scalar_first=True)
    measured = true.inv().apply(FIELD)
    assert heading_innovation(f, measured) == pytest.approx(0.0, abs=1e-12)
    row = f["measurement_row"].copy()
    kick = np.zeros(N_STATES)
    kick[6 + axis] = -1e-6  # the estimate lacks this error
    add_error(f, kick)
    assert heading_innovation(f, measured) / 1e-6 == pytest.approx(row[6 + axis], abs=1e-3)


def test_heading_is_corrected_and_not_position():
    f = moving_filter(np.zeros(3))
    f["field_enu_ut"] = FIELD
    f["covariance"] = np.diag([0.1] * 6 + [1e-6] * 2 + [0.05] + [1e-6] * 16)
    truth = Rotation.from_euler("z", 0.1)
    for _ in range(100):
        fuse_magnetometer(f, truth.inv().apply(FIELD))
    q = f["quat_wxyz"]
    assert 2.0 * math.atan2(q[3], q[0]) == pytest.approx(0.1, abs=0.03)
    np.testing.assert_array_equal(f["position_enu_m"], 0.0)


def test_noise_of_the_magnetometer_does_not_tilt_the_estimate():
    """At rest, tilt and accelerometer bias unknown: the noise of headings says nothing of them."""
    f = moving_filter(np.zeros(3))
    f["field_enu_ut"] = FIELD
    f["covariance"] = np.diag([1e-4] * 6 + [4e-4] * 2 + [1e-4] + [1e-6] * 16)
    before = f.copy()
    for row in np.random.default_rng(5).normal(size=(500, 3)):
        fuse_magnetometer(f, FIELD + 0.28 * row)
    assert abs(error_between(f, before)[6]) < 4e-3
