"""What one image tells of the horizontal offset does not depend on what was believed of it."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from autonomy.perception.level_fix import level_fix
from autonomy.perception.match import Match

SIGMA_M = 0.05
COVARIANCE = np.diag([0.04, 0.04, 0.04, 1e-4])


def match(directions, offset):
    columns = np.array(directions, dtype=float).T
    return Match(
        objection=None,
        is_doubtful=False,
        measured=columns.T @ np.array(offset),
        directions=columns,
        variances=np.full(columns.shape[1], SIGMA_M**2),
        is_angle=np.zeros(columns.shape[1], dtype=bool),
        residual_m=0.01,
        inlier_share=1.0,
    )


def turned(angle):
    c, s = np.cos(angle), np.sin(angle)
    return [(c, s, 0.0, 0.0), (-s, c, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0)]


@given(st.floats(-3.0, 3.0), st.floats(-2.0, 2.0), st.floats(-2.0, 2.0))
def test_the_offset_is_the_images_whatever_the_prior(angle, east_m, north_m):
    seen = match(turned(angle), (0.4, -0.3, 0.1, 0.0))
    fix = level_fix(seen, seen.variances, np.array([east_m, north_m, 0.1, 0.0]), COVARIANCE)
    assert fix is not None
    assert fix.offset_enu_m == pytest.approx((0.4, -0.3), abs=1e-9)
    assert fix.sigma_m == pytest.approx(SIGMA_M)


@given(st.floats(-3.0, 3.0))
def test_along_a_wall_it_tells_nothing(angle):
    seen = match(turned(angle)[1:], (0.4, -0.3, 0.1, 0.0))
    assert level_fix(seen, seen.variances, np.zeros(4), COVARIANCE) is None


def test_a_slope_seen_aslant_rests_on_the_known_height():
    slanting = [(1.0, 0.0, 0.0, 0.0), (0.0, 0.8, 0.6, 0.0)]
    seen = match(slanting, (0.4, -0.3, 0.0, 0.0))
    fix = level_fix(seen, seen.variances, np.zeros(4), COVARIANCE)
    assert fix is not None
    assert fix.offset_enu_m == pytest.approx((0.4, -0.3), abs=1e-6)
    assert SIGMA_M < fix.sigma_m < 0.3
