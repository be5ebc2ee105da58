"""Dryden turbulence: the filters have the standard's variance and spectrum, exactly."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from flightsim.environment.dryden import (
    horizontal_ratio,
    length_scales_m,
    stationary_states,
    step_turbulence,
)

STATIONARY = np.eye(5)
STATIONARY[1:3, 1:3] = STATIONARY[3:5, 3:5] = [[1.0, 0.5], [0.5, 0.5]]

heights_m = st.floats(0.0, 400.0)
speeds_mps = st.floats(0.0, 40.0)
ticks_s = st.sampled_from([0.002, 0.004, 0.02])


def spectrum_along(omega_radps, sigma_mps, time_constant_s):
    """One-sided spectrum of turbulence along the wind, m^2/s^2 per rad/s; its integral is sigma^2.

    Source: MIL-F-8785C, 3.7.2.1, with spatial frequency times V for angular frequency.
    """
    T = time_constant_s
    return sigma_mps**2 * 2.0 * T / math.pi / (1.0 + (T * omega_radps) ** 2)


def spectrum_across(omega_radps, sigma_mps, time_constant_s):
    """One-sided spectrum across the wind and upwards, as `spectrum_along`."""
    square = (time_constant_s * omega_radps) ** 2
    scale = sigma_mps**2 * time_constant_s / math.pi
    return scale * (1.0 + 3.0 * square) / (1.0 + square) ** 2


def linear_system(height_m, speed_mps, dt_s):
    """Matrices of x' = A x + B n and y = C x + D n with unit vertical variance."""

    def step(x, normals):
        x, y = np.array(x, dtype=float), np.zeros(3)
        step_turbulence(x, y, height_m, speed_mps, 1.0, dt_s, np.array(normals, dtype=float))
        return x, y

    none = np.zeros(5)
    A, _ = zip(*(step(e, none) for e in np.eye(5)), strict=True)
    B, _ = zip(*(step(none, e) for e in np.eye(5)), strict=True)
    A, B = np.array(A).T, np.array(B).T
    # The output is read after the step.
    outputs = np.array([step(e, none)[1] for e in np.eye(5)]).T
    return A, B, outputs @ np.linalg.inv(A)


@given(heights_m, speeds_mps, ticks_s)
def test_the_stationary_variance_is_kept_by_every_step(height_m, speed_mps, dt_s):
    A, B, C = linear_system(height_m, speed_mps, dt_s)
    np.testing.assert_allclose(A @ STATIONARY @ A.T + B @ B.T, STATIONARY, atol=1e-12)
    ratio = horizontal_ratio(height_m)
    variance = np.diag(C @ STATIONARY @ C.T)
    np.testing.assert_allclose(variance, (ratio**2, ratio**2, 1.0), rtol=1e-9)


@given(heights_m, speeds_mps)
def test_two_steps_are_one_of_twice_the_length(height_m, speed_mps):
    A, B, _ = linear_system(height_m, speed_mps, 0.01)
    A2, B2, _ = linear_system(height_m, speed_mps, 0.02)
    np.testing.assert_allclose(A @ A, A2, rtol=1e-9, atol=1e-14)
    np.testing.assert_allclose(A @ B @ B.T @ A.T + B @ B.T, B2 @ B2.T, rtol=1e-7, atol=1e-14)


@pytest.mark.parametrize(("height_m", "speed_mps"), [(3.0, 5.0), (20.0, 12.0), (200.0, 3.0)])
def test_the_spectrum_is_the_standards(height_m, speed_mps):
    dt_s = 0.002
    A, B, C = linear_system(height_m, speed_mps, dt_s)
    along_m, up_m = length_scales_m(height_m)
    ratio = horizontal_ratio(height_m)
    omega = np.geomspace(1e-3, 30.0, 40)
    found = np.empty((40, 3))
    for k, w in enumerate(omega):
        H = C @ np.linalg.solve(np.exp(1j * w * dt_s) * np.eye(5) - A, B)
        found[k] = np.sum(np.abs(H) ** 2, axis=1) * dt_s / math.pi
    T, T_up = along_m / speed_mps, up_m / speed_mps
    np.testing.assert_allclose(found[:, 0], spectrum_along(omega, ratio, T), rtol=0.01)
    np.testing.assert_allclose(found[:, 1], spectrum_across(omega, ratio, T), rtol=0.01)
    np.testing.assert_allclose(found[:, 2], spectrum_across(omega, 1.0, T_up), rtol=0.01)


@pytest.mark.parametrize("spectrum", [spectrum_along, spectrum_across])
def test_spectra_integrate_to_the_variance(spectrum):
    omega = np.geomspace(1e-5, 1e5, 20_000)
    assert np.trapezoid(spectrum(omega, 2.0, 3.0), omega) == pytest.approx(4.0, rel=1e-3)


def test_scales_are_the_standards_at_its_limits():
    # At 1,000 ft turbulence is isotropic with scales of 1,000 ft.
    assert length_scales_m(304.8) == pytest.approx((304.8, 304.8), rel=1e-2)
    assert horizontal_ratio(304.8) == pytest.approx(1.0, rel=1e-2)
    assert length_scales_m(0.0) == length_scales_m(3.048)


def test_the_first_state_is_as_good_as_any():
    generator = np.random.default_rng(0)
    states = np.array([stationary_states(generator) for _ in range(20_000)])
    np.testing.assert_allclose(np.cov(states.T), STATIONARY, atol=0.03)
