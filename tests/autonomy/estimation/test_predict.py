"""Propagation of the error-state filter against filterpy, finite differences and closed forms."""

import numpy as np
import pytest
from filterpy.kalman import KalmanFilter
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from scipy.spatial.transform import Rotation

from autonomy.estimation.error_state import ACCEL_BIAS, ATTITUDE, GYRO_BIAS, N_STATES, VELOCITY
from autonomy.estimation.predict import predict, propagate_covariance
from tests.autonomy.sample_filters import DT, G, add_error, error_between, filter_at


def cross(v):
    x, y, z = v
    return np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])


def transition(R, force, dt):
    """F of the module's docstring as a dense matrix."""
    F = np.eye(N_STATES)
    F[0:3, 3:6] = dt * np.eye(3)
    F[3:6, 6:9] = -dt * cross(force)
    F[3:6, 12:15] = -dt * R
    F[6:9, 9:12] = -dt * R
    return F


seeds = st.integers(0, 2**31)
vectors = hnp.arrays(float, 3, elements=st.floats(-20.0, 20.0))


@given(seeds, vectors, st.floats(1e-4, 0.02))
def test_sparse_propagation_equals_filterpys_dense_one(seed, force, dt):
    f = filter_at(np.random.default_rng(seed))
    R = Rotation.from_quat(f["quat_wxyz"], scalar_first=True).as_matrix()
    oracle = KalmanFilter(dim_x=N_STATES, dim_z=1)
    oracle.P = f["covariance"].copy()
    oracle.F, oracle.Q = transition(R, force, dt), np.zeros((N_STATES, N_STATES))
    oracle.predict()
    propagate_covariance(f["covariance"], R, force, dt)
    np.testing.assert_allclose(f["covariance"], oracle.P, atol=1e-12)


@given(seeds, vectors, vectors)
def test_transition_is_the_derivative_of_the_nominal_step(seed, accel, gyro):
    """A small error of each kind grows in the nominal state as F says."""
    rng = np.random.default_rng(seed)
    f = filter_at(rng)
    start = f.copy()
    predict(f, accel, 0.1 * gyro)
    half = Rotation.from_rotvec(0.5 * DT * (0.1 * gyro - start["gyro_bias_flu_radps"]))
    middle = Rotation.from_quat(start["quat_wxyz"], scalar_first=True) * half
    force = middle.apply(accel - start["accel_bias_flu_mps2"])
    F = transition(middle.as_matrix(), force, DT)
    size = 1e-5
    for k in (VELOCITY, ATTITUDE, ATTITUDE + 2, GYRO_BIAS + 1, ACCEL_BIAS + 2):
        g = start.copy()
        kick = np.zeros(N_STATES)
        kick[k] = size
        add_error(g, kick)
        predict(g, accel, 0.1 * gyro)
        np.testing.assert_allclose(
            error_between(g, f) / size, F[:, k], atol=2e-3 * (1.0 + np.abs(F[:, k]).max())
        )


@given(seeds, vectors, vectors)
def test_covariance_stays_symmetric_and_positive(seed, accel, gyro):
    f = filter_at(np.random.default_rng(seed))
    for _ in range(20):
        predict(f, accel, gyro)
    P = f["covariance"]
    np.testing.assert_array_equal(P, P.T)
    assert np.linalg.eigvalsh(P).min() > 0.0
    assert np.linalg.norm(f["quat_wxyz"]) == pytest.approx(1.0, abs=1e-12)


def test_noise_adds_its_density_times_time():
    f = filter_at(np.random.default_rng(0), gyro_noise_density=0.01, accel_noise_density=0.2)
    f["covariance"] = 0.0
    for _ in range(250):  # falling freely: no force couples tilt into velocity
        predict(f, f["accel_bias_flu_mps2"].copy(), f["gyro_bias_flu_radps"].copy())
    np.testing.assert_allclose(np.diag(f["covariance"])[3:6], 0.2**2, rtol=1e-3)
    np.testing.assert_allclose(np.diag(f["covariance"])[6:9], 0.01**2, rtol=1e-3)


def test_a_circle_at_constant_speed_closes():
    """Constant body rate and centripetal force bring the state back after one turn."""
    f = filter_at(np.random.default_rng(0))
    for name in ("position_enu_m", "gyro_bias_flu_radps", "accel_bias_flu_mps2"):
        f[name] = 0.0
    f["quat_wxyz"] = (1.0, 0.0, 0.0, 0.0)
    f["velocity_enu_mps"] = (3.0, 0.0, 0.0)
    n = 1500
    rate = 2.0 * np.pi / (n * DT)
    for _ in range(n):
        predict(f, np.array([0.0, 3.0 * rate, G]), np.array([0.0, 0.0, rate]))
    np.testing.assert_allclose(f["velocity_enu_mps"], (3.0, 0.0, 0.0), atol=1e-6)
    np.testing.assert_allclose(f["position_enu_m"], 0.0, atol=1e-4)
