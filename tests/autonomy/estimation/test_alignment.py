"""The filter starts from sensors at rest, and only at rest."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from autonomy.estimation import EstimatorCfg, new_filter
from autonomy.estimation.alignment import (
    align_when_ready,
    collect_fix,
    collect_imu,
    collect_vector,
)
from autonomy.estimation.error_state import BARO_OFFSET, GNSS_WANDER, VIO_ORIGIN, VIO_YAW
from autonomy.estimation.predict import predict

VIO_STATES = slice(VIO_ORIGIN, VIO_YAW + 1)
FIELD = np.array([0.8, 21.5, -42.8])
G = 9.81


def rest(f, attitude, *, seconds=1.0, rate=0.0, accel_bias=(0.0, 0.0, 0.0), **more):
    """Feed what sensors at rest say: exact, but for biases."""
    gyro = np.array([0.004, -0.003, 0.002 + rate])
    accel = attitude.inv().apply([0.0, 0.0, G]) + np.asarray(accel_bias)
    field = attitude.inv().apply(FIELD)
    has_satellites = more.pop("has_satellites", True)
    for tick in range(round(seconds * 250)):
        collect_imu(f, accel, gyro)
        if tick % 5 == 0:
            collect_vector(f["mag_sum"], field)
            f["n_mag"] += 1
            f["baro_sum"] += 500.0
            f["n_baro"] += 1
        if tick % 50 == 0 and has_satellites:
            collect_fix(f, np.array([1.0, 2.0, 3.0]), np.full(3, 0.01))
        align_when_ready(f)


def new(**more):
    earth = {"field_enu_ut": tuple(FIELD), "gravity_mps2": G}
    return new_filter(EstimatorCfg(), dt_s=0.004, **earth, **more)[0]


@settings(max_examples=15)
@given(st.floats(-3.1, 3.1), st.floats(-0.3, 0.3), st.floats(-0.3, 0.3))
def test_attitude_position_and_gyro_bias_come_from_rest(yaw, pitch, roll):
    f = new()
    attitude = Rotation.from_euler("ZYX", [yaw, pitch, roll])
    rest(f, attitude)
    assert f["is_aligned"] == 1
    estimate = Rotation.from_quat(f["quat_wxyz"], scalar_first=True)
    assert (attitude * estimate.inv()).magnitude() < 1e-9
    np.testing.assert_allclose(f["position_enu_m"], (1.0, 2.0, 3.0))
    np.testing.assert_allclose(f["gyro_bias_flu_radps"], (0.004, -0.003, 0.002))
    assert f["baro_offset_m"] == pytest.approx(497.0)
    P = np.delete(np.delete(f["covariance"], VIO_STATES, 0), VIO_STATES, 1)
    assert np.linalg.eigvalsh(P).min() > 0.0


def test_no_start_while_the_vehicle_is_being_turned():
    f = new()
    rest(f, Rotation.identity(), seconds=3.0, rate=0.5)
    assert f["is_aligned"] == 0
    rest(f, Rotation.identity(), seconds=1.3)
    assert f["is_aligned"] == 1


def test_no_start_without_satellites():
    f = new()
    for _ in range(500):
        collect_imu(f, np.array([0.0, 0.0, G]), np.zeros(3))
        align_when_ready(f)
    assert f["is_aligned"] == 0


def test_tilt_error_is_known_to_hide_the_accelerometers_bias():
    """Levelled with a biased accelerometer, the filter expects no acceleration at rest."""
    f = new()
    attitude = Rotation.from_euler("z", 0.7)
    rest(f, attitude, accel_bias=(0.2, -0.1, 0.0))
    before = f["covariance"][3:5, 3:5].copy()
    accel = np.array([0.2, -0.1, G])
    for _ in range(250):
        predict(f, accel, np.array([0.004, -0.003, 0.002]))
    grown = np.sqrt(np.diag(f["covariance"])[3:5] - np.diag(before))
    # a bias of 0.2 m/s^2 and a tilt of 0.02 rad unknown to each other would give 0.28 m/s
    assert np.all(grown < 0.06)


def test_without_satellites_it_starts_where_it_is_told():
    told = (4.0, -2.0, 0.3)
    f = new(start_enu_m=told)
    rest(f, Rotation.identity(), has_satellites=False)
    assert f["is_aligned"] == 1
    np.testing.assert_array_equal(f["position_enu_m"], told)
    P = f["covariance"]
    assert P[0, 0] == pytest.approx(f["start_sigma_m"] ** 2)
    assert P[0, GNSS_WANDER] == 0.0


def test_a_start_by_satellites_is_wrong_by_what_they_wander():
    f = new()
    rest(f, Rotation.identity())
    P = f["covariance"]
    assert P[0, GNSS_WANDER] == pytest.approx(-(0.03**2))
    assert P[2, BARO_OFFSET] == pytest.approx(-P[2, 2])
