"""Scalar updates against filterpy; gates; late measurements see the corrected past."""

import math

import numpy as np
import pytest
from filterpy.kalman import KalmanFilter
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from autonomy.estimation.error_state import N_STATES
from autonomy.estimation.update import inject, scalar_update
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
    ratio = scalar_update(f, innovation, variance)
    assert ratio <= 1.0
    np.testing.assert_allclose(f["covariance"], oracle.P, atol=1e-9)
    np.testing.assert_allclose(error_between(f, before), oracle.x[:, 0], atol=1e-9)


@given(seeds, rows, st.floats(1e-4, 1.0))
def test_covariance_stays_symmetric_positive_and_never_grows(seed, row, variance):
    f = filter_at(np.random.default_rng(seed))
    before = np.diag(f["covariance"]).copy()
    for shift in range(N_STATES):
        f["measurement_row"] = np.roll(row, shift)
        scalar_update(f, 0.0, variance)
    P = f["covariance"]
    np.testing.assert_array_equal(P, P.T)
    assert np.linalg.eigvalsh(P).min() > -1e-12
    assert np.all(np.diag(P) <= before + 1e-12)


@given(seeds, rows, st.sampled_from([math.nan, math.inf, -math.inf, 1e6]))
def test_a_wild_or_missing_measurement_changes_nothing(seed, row, innovation):
    f = filter_at(np.random.default_rng(seed))
    f["measurement_row"] = row
    before = f.copy()
    ratio = scalar_update(f, innovation, 0.1)
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


def test_the_remembered_past_takes_part_in_a_correction():
    """An error of position and velocity now was a smaller one of position before."""
    f = filter_at(np.random.default_rng(1))
    f["tick"] = 100
    error = np.zeros(N_STATES)
    error[0], error[3] = 1.0, 2.0
    inject(f, error)
    age = 30
    slot = (100 - age) % 64
    assert f["past_position_enu_m"][slot, 0] == pytest.approx(1.0 - 2.0 * age * 0.004)
    assert f["past_velocity_enu_mps"][slot, 0] == pytest.approx(2.0)
