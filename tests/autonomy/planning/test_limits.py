"""Limits leave accelerations that keep thrust and tilt, whatever the direction."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from autonomy.model.flatness import hover_drag_per_s
from autonomy.model.quadrotor import GRAVITY_MPS2
from autonomy.planning import FlightLimits, LimitsError
from tests.autonomy.planning_worlds import quadrotor


@given(
    st.floats(0.5, 10.0),
    st.floats(0.5, 10.0),
    st.floats(0.5, 1.0),
    st.floats(0.1, 1.2),
    st.floats(0, 2 * math.pi),
    st.floats(-1, 1),
)
def test_accelerations_keep_thrust_and_tilt(across, up, fraction, tilt, angle, share):
    limits = FlightLimits(
        acceleration_mps2=across,
        acceleration_vertical_mps2=up,
        thrust_fraction=fraction,
        tilt_rad=tilt,
    )
    horizontal, vertical = limits.accelerations_mps2(quadrotor())
    thrust = np.array(
        [
            horizontal * math.cos(angle),
            horizontal * math.sin(angle),
            share * vertical + GRAVITY_MPS2,
        ]
    )
    assert np.linalg.norm(thrust) <= limits.max_specific_thrust_mps2(quadrotor()) + 1e-9
    assert math.atan2(horizontal, thrust[2]) <= tilt + 1e-9
    assert horizontal <= across
    assert vertical <= up


def test_thrust_that_hardly_hovers_is_refused():
    with pytest.raises(LimitsError, match=r"thrust_fraction 0\.4 leaves"):
        FlightLimits(thrust_fraction=0.4).accelerations_mps2(quadrotor())


def test_a_tilt_that_only_holds_against_drag_lowers_the_speed():
    limits = FlightLimits(speed_horizontal_mps=60.0)
    bounds = limits.motion_bounds(quadrotor())
    drag = hover_drag_per_s(quadrotor()) * bounds.speed_horizontal_mps
    assert drag < math.tan(limits.tilt_rad) * GRAVITY_MPS2
    assert bounds.speed_horizontal_mps < 60.0
    assert FlightLimits().motion_bounds(quadrotor()).speed_horizontal_mps == 6.5
    with pytest.raises(LimitsError, match=r"tilt_rad 0\.01 leaves"):
        FlightLimits(tilt_rad=0.01).motion_bounds(quadrotor())


@pytest.mark.parametrize(
    ("name", "value"),
    [("speed_horizontal_mps", 0.0), ("tilt_rad", 1.6), ("thrust_fraction", 1.1)]
    + [("yaw_rate_radps", math.nan), ("acceleration_mps2", math.inf)],
)
def test_senseless_limits_are_refused_by_name(name, value):
    with pytest.raises(LimitsError, match=name):
        FlightLimits(**{name: value})


@pytest.mark.parametrize("name", ["acceleration_mps2", "acceleration_vertical_mps2"])
def test_too_little_acceleration_is_refused_by_name(name):
    with pytest.raises(LimitsError, match=rf"^{name} 0\.1 is too little.*valid: at least 0\.20"):
        FlightLimits(**{name: 0.1})
