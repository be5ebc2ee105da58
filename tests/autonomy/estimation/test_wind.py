"""Wind from drag: found in flight, not looked for on the ground, with the right derivatives."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from autonomy.estimation import DragModel, EstimatorCfg, new_filter
from autonomy.estimation.error_state import N_STATES
from autonomy.estimation.wind import fuse_drag
from tests.autonomy.sample_filters import DT, G, add_error, filter_at, moving_filter

DRAG = DragModel(
    rotor_mps_per_rad=(1.1e-4, 1.1e-4, 1.1e-4, 1.1e-4),
    fuselage_per_m=(3e-3, 6e-3),
    thrust_m=(3.8e-6, 3.8e-6, 3.8e-6, 3.8e-6),
)
HOVER = np.full(4, np.sqrt(G / (4 * 3.8e-6)))


def with_drag(f):
    donor = new_filter(
        EstimatorCfg(), dt_s=DT, field_enu_ut=(0.8, 21.5, -42.8), gravity_mps2=G, drag=DRAG
    )[0]
    for name in ("drag_ticks", "drag_rotor_mps_per_rad", "drag_fuselage_per_m", "thrust_m"):
        f[name] = donor[name]
    return f


def specific_force(f, wind=None):
    """The model's equation, in numpy, for the state of a filter."""
    R = Rotation.from_quat(f["quat_wxyz"], scalar_first=True).as_matrix()
    wind = f["wind_enu_mps"] if wind is None else wind
    u = R.T @ (f["velocity_enu_mps"] - [*wind, 0.0])
    linear = HOVER @ f["drag_rotor_mps_per_rad"][:4]
    across = -(linear + f["drag_fuselage_per_m"] * np.abs(u[:2])) * u[:2]
    return np.array([*(across + f["accel_bias_flu_mps2"][:2]), G])


@settings(max_examples=30)
@given(st.integers(0, 2**31))
def test_the_row_is_the_derivative_of_the_specific_force(seed):
    f = with_drag(filter_at(np.random.default_rng(seed)))
    f["covariance"] = 0.0
    f["wind_variance_rate"] = 0.0
    fuse_drag(f, specific_force(f), HOVER)  # leaves the row of body y, and moves nothing
    row = f["measurement_row"].copy()
    size = 1e-6
    for k in range(N_STATES):
        kicked, kick = f.copy(), np.zeros(N_STATES)
        kick[k] = size
        add_error(kicked, kick)
        slope = (specific_force(kicked)[1] - specific_force(f)[1]) / size
        assert row[k] == pytest.approx(slope, abs=1e-4)


def test_a_steady_wind_is_found_within_seconds():
    f = with_drag(moving_filter(np.array([3.0, 0.0, 0.0]), sigma=0.02))
    f["covariance"][23, 23] = f["covariance"][24, 24] = 25.0
    wind = np.array([-4.0, 3.0])
    for k in range(500):
        f["tick"] = k * f["drag_ticks"]
        fuse_drag(f, specific_force(f, wind), HOVER)
    np.testing.assert_allclose(f["wind_enu_mps"], wind, atol=0.1)
    assert np.sqrt(f["covariance"][23, 23]) < 0.3


def test_on_the_ground_and_without_a_model_nothing_is_looked_for():
    f = with_drag(filter_at(np.random.default_rng(0)))
    before = f.tobytes()
    fuse_drag(f, np.array([1.0, 1.0, G]), 0.6 * HOVER)
    f["tick"] = 1
    fuse_drag(f, np.array([1.0, 1.0, G]), HOVER)  # not its turn
    f["drag_accel_sum"], f["n_drag_accel"] = 0.0, 0  # that was kept for its turn
    f["tick"] = f["drag_ticks"] = 0
    fuse_drag(f, np.array([1.0, 1.0, G]), HOVER)
    f["drag_ticks"] = with_drag(filter_at(np.random.default_rng(0)))["drag_ticks"]
    assert f.tobytes() == before


def test_vibration_between_two_uses_is_averaged_away():
    """At the rate of the uses, it would otherwise fold into what looks like a steady wind."""
    f = with_drag(moving_filter(np.array([3.0, 0.0, 0.0]), sigma=0.02))
    f["covariance"][23, 23] = f["covariance"][24, 24] = 25.0
    force = specific_force(f)
    for k in range(1, 2001):
        f["tick"] = k
        shake = 2.0 * np.cos(2.0 * np.pi * k / f["drag_ticks"])
        fuse_drag(f, force + np.array([shake, 0.0, 0.0]), HOVER)
    np.testing.assert_allclose(f["wind_enu_mps"], 0.0, atol=0.1)
