"""The filters of a mover's modes of motion equal those of filterpy."""

from __future__ import annotations

import numpy as np
import pytest
from filterpy.kalman import IMMEstimator, KalmanFilter
from hypothesis import given, settings
from hypothesis import strategies as st

from autonomy.perception.motion_modes import (
    _FIRST_SHARES,
    _MODES,
    _STANDING_VARIANCE,
    CHANGES,
    ahead,
    begin,
    fused,
)

seeds = st.integers(0, 2**32 - 1)


def motion(rate, psd, dt):
    """Transition and noise of a mode over at most a second, as textbooks have them."""
    move = np.eye(6)
    if (rate, psd) == _MODES[0]:
        return np.diag([1.0] * 3 + [0.0] * 3), np.diag([psd * dt] * 3 + [_STANDING_VARIANCE] * 3)
    c, s = np.cos(rate * dt), np.sin(rate * dt)
    along, aside = (s / rate, (1.0 - c) / rate) if rate else (dt, 0.0)
    move[:2, 3:5] = [[along, -aside], [aside, along]]
    move[3:5, 3:5] = [[c, -s], [s, c]]
    move[2, 5] = dt
    return move, psd * np.kron([[dt**3 / 3, dt**2 / 2], [dt**2 / 2, dt]], np.eye(3))


def reference(mean, covariance):
    modes = []
    for _ in _MODES:
        mode = KalmanFilter(dim_x=6, dim_z=3)
        mode.x, mode.P, mode.H = mean.copy(), covariance.copy(), np.eye(3, 6)
        modes.append(mode)
    return IMMEstimator(modes, np.array(_FIRST_SHARES), CHANGES)


def random_covariance(rng, n, scale):
    root = rng.normal(size=(n, n)) * scale
    return root @ root.T + 1e-3 * np.eye(n)


@given(seed=seeds)
@settings(max_examples=30)
def test_sightings_are_fused_as_by_filterpy(seed):
    rng = np.random.default_rng(seed)
    mean, covariance = rng.normal(size=6), random_covariance(rng, 6, 0.5)
    modes, expected = begin(mean, covariance), reference(mean, covariance)
    for _ in range(8):
        dt, shift = rng.uniform(0.05, 1.0), 0.05 * rng.normal(size=3)
        position, noise = (
            modes.means[1, :3] + 0.2 * rng.normal(size=3),
            random_covariance(rng, 3, 0.1),
        )
        modes, found, spread = fused(modes, dt, shift, position, noise, CHANGES)
        for mode, (rate, psd) in zip(expected.filters, _MODES, strict=True):
            mode.F, mode.Q = motion(rate, psd, dt)
            mode.x[:3] += shift
            mode.R = noise
        expected.predict()
        expected.update(position)
        np.testing.assert_allclose(found, expected.x, atol=1e-9)
        np.testing.assert_allclose(spread, expected.P, atol=1e-9)
        np.testing.assert_allclose(modes.shares, expected.mu, atol=1e-9)


@pytest.mark.parametrize("dt", [0.0, 0.1, 1.0])
def test_what_comes_is_blended_from_the_modes(dt):
    rng = np.random.default_rng(4)
    modes = begin(rng.normal(size=6), random_covariance(rng, 6, 0.5))
    modes = modes._replace(means=modes.means + rng.normal(size=(4, 6)))
    mean, covariance = ahead(modes, dt)
    parts = [motion(rate, psd, dt) for rate, psd in _MODES]
    means = np.array([move @ each for (move, _), each in zip(parts, modes.means, strict=True)])
    spreads = np.array(
        [f @ p @ f.T + q for (f, q), p in zip(parts, modes.covariances, strict=True)]
    )
    expected = modes.shares @ means
    apart = means - expected
    np.testing.assert_allclose(mean, expected, atol=1e-12)
    among = (modes.shares * apart.T) @ apart
    np.testing.assert_allclose(
        covariance, np.tensordot(modes.shares, spreads, 1) + among, atol=1e-12
    )


def test_who_turned_a_second_unseen_goes_straight_on():
    modes = begin(np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0]), 0.01 * np.eye(6))
    only_left = modes._replace(shares=np.array([0.0, 0.0, 1.0, 0.0]))
    one, two, three = (ahead(only_left, dt)[0] for dt in (1.0, 2.0, 3.0))
    np.testing.assert_allclose(two[3:], one[3:])
    np.testing.assert_allclose(three[:3] - two[:3], one[3:], atol=1e-12)
