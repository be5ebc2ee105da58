"""Scalar updates against filterpy; gates; late measurements see the corrected past."""

import math

import numpy as np
import pytest
from filterpy.kalman import KalmanFilter
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from scipy.spatial.transform import Rotation

from autonomy.estimation.error_state import N_STATES
from autonomy.estimation.past import (
    past_position,
    past_velocity,
    past_yaw,
    remember,
    restart_past,
)
from autonomy.estimation.update import inject, scalar_update
from autonomy.rotation import wrap_angle, yaw_from_quat
from tests.autonomy.sample_filters import add_error, error_between, filter_at

seeds = st.integers(0, 2**31)
rows = hnp.arrays(float, N_STATES, elements=st.floats(-2.0, 2.0))


@given(seeds, rows, st.floats(-1e-3, 1e-3), st.floats(1e-3, 10.0))
def test_update_equals_filterpys(seed, row, innovation, variance):
    f = filter_at(np.random.default_rng(seed))
    before = f.copy()
    oracle = KalmanFilter(dim_x=N_STATES, dim_z=1)
    oracle.x, oracle.P = np.zeros((N_STATES, 1)), f["covariance"].copy()
    oracle.update(np.array([[innovation]]), R=variance, H=row[None, :])
    f["measurement_row"] = row
    ratio = scalar_update(f, 0, innovation, variance)
    assert ratio <= 1.0
    np.testing.assert_allclose(f["covariance"], oracle.P, atol=1e-9)
    np.testing.assert_allclose(error_between(f, before), oracle.x[:, 0], atol=1e-9)


@given(seeds, rows, st.floats(1e-4, 1.0))
def test_covariance_stays_symmetric_positive_and_never_grows(seed, row, variance):
    f = filter_at(np.random.default_rng(seed))
    before = np.diag(f["covariance"]).copy()
    for shift in range(N_STATES):
        f["measurement_row"] = np.roll(row, shift)
        scalar_update(f, 0, 0.0, variance)
    P = f["covariance"]
    np.testing.assert_array_equal(P, P.T)
    assert np.linalg.eigvalsh(P).min() > -1e-12
    assert np.all(np.diag(P) <= before + 1e-12)


@given(seeds, rows, st.sampled_from([math.nan, math.inf, -math.inf, 1e6]))
def test_a_wild_or_missing_measurement_changes_nothing(seed, row, innovation):
    f = filter_at(np.random.default_rng(seed))
    f["measurement_row"] = row
    before = f.copy()
    ratio = scalar_update(f, 0, innovation, 0.1)
    assert not ratio <= 1.0
    np.testing.assert_array_equal(f["covariance"], before["covariance"])
    assert np.all(error_between(f, before) == 0.0)


@given(seeds, hnp.arrays(float, N_STATES, elements=st.floats(-0.1, 0.1)))
def test_injection_is_the_sum_on_the_manifold(seed, error):
    f = filter_at(np.random.default_rng(seed))
    expected = f.copy()
    add_error(expected, error)
    inject(f, error)
    np.testing.assert_allclose(error_between(f, expected), 0.0, atol=1e-9)


@given(seeds, hnp.arrays(float, (3, N_STATES), elements=st.floats(-1.0, 1.0)))
def test_the_remembered_past_takes_part_in_corrections(seed, errors):
    """An error of position and velocity now was another one of position before."""
    f = filter_at(np.random.default_rng(seed))
    f["tick"] = 100
    restart_past(f)
    ages = (0, 30, 63)
    before = [[past_position(f, age, i) for i in range(3)] for age in ages]
    for tick, error in enumerate(errors, 100):
        f["tick"] = tick
        inject(f, error)
        remember(f)
    moved, turned = errors[:, :3], errors[:, 3:6]
    for age, position in zip(ages, before, strict=True):
        since_s = (age + np.arange(3))[:, None] * f["dt_s"]
        now = [past_position(f, age + 2, i) for i in range(3)] if age < 62 else None
        if now is not None:
            expected = position + (moved - since_s * turned).sum(axis=0)
            np.testing.assert_allclose(now, expected, atol=1e-9)
    np.testing.assert_allclose(
        [past_velocity(f, 2 + 30, i) for i in range(3)],
        f["velocity_enu_mps"],
        atol=1e-9,
    )


@given(seeds, hnp.arrays(float, 3, elements=st.floats(-0.01, 0.01)))
def test_the_remembered_heading_turns_with_the_attitude(seed, turn):
    f = filter_at(np.random.default_rng(seed))
    forward = Rotation.from_quat(f["quat_wxyz"], scalar_first=True).apply([1.0, 0.0, 0.0])
    assume(np.hypot(*forward[:2]) > 0.5)
    restart_past(f)
    error = np.zeros(N_STATES)
    error[6:9] = turn
    inject(f, error)
    off = past_yaw(f, 20) - yaw_from_quat(f["quat_wxyz"])
    assert wrap_angle(off) == pytest.approx(0.0, abs=1e-3)
