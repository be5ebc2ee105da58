"""Recovery: when it begins and ends, and what it asks for meanwhile."""

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from autonomy.control import SETPOINT_DTYPE
from autonomy.control.controller import control
from autonomy.control.record import setpoint_row
from autonomy.types import ControlLevel, Setpoint
from tests.autonomy.sample_quadrotors import hovering

STAND_STILL = Setpoint(level=ControlLevel.TRAJECTORY, velocity_enu_mps=(0.0, 0.0, 0.0))
rotations = st.integers(0, 2**32 - 1).map(lambda seed: Rotation.random(random_state=seed))


def tick(c, x):
    records = np.zeros(1, SETPOINT_DTYPE)
    records.view("f8")[:] = setpoint_row(STAND_STILL)
    control(c, records[0], x, True)


def let_go(attitude, rate=(0.0, 0.0, 0.0), velocity=(0.0, 0.0, 0.0)):
    """A controller one tick after it was told to stand still."""
    c, x = hovering()
    x["quat_wxyz"] = attitude.as_quat(scalar_first=True)
    x["angular_rate_flu_radps"], x["velocity_enu_mps"] = rate, velocity
    tick(c, x)
    return c, x


@given(rotations)
def test_it_begins_where_the_thrust_points_down(attitude):
    height = attitude.as_matrix()[2, 2]
    assume(abs(height) > 1e-6)
    c, _ = let_go(attitude)
    assert c["is_recovering"] == (height < 0.0)


@pytest.mark.parametrize(("rate", "is_tumbling"), [(7.0, 0), (9.0, 1)])
def test_it_begins_where_the_vehicle_tumbles(rate, is_tumbling):
    c, _ = let_go(Rotation.identity(), rate=(0.0, rate, 3.0))
    assert c["is_recovering"] == is_tumbling


@given(rotations)
def test_no_thrust_is_asked_for_downwards_and_no_torque_about_yaw(attitude):
    assume(attitude.as_matrix()[2, 2] < -1e-6)
    c, _ = let_go(attitude)
    assert c["collective_n"] == 0.0
    assert c["torque_flu_nm"][2] == pytest.approx(0.0, abs=1e-9)
    assert np.hypot(*c["torque_flu_nm"][:2]) > 0.0


def test_the_heading_is_the_one_that_the_shortest_turn_leads_to():
    yaw = 0.7
    lean = Rotation.from_rotvec((math.radians(150.0), 0.0, 0.0))
    c, _ = let_go(lean * Rotation.from_euler("z", yaw))
    assert c["reference_yaw_rad"] == pytest.approx(yaw)


@pytest.mark.parametrize(
    ("tilt_deg", "rate", "climb_mps", "goes_on"),
    [(10.0, 0.5, 0.0, 0), (40.0, 0.5, 0.0, 1), (10.0, 5.0, 0.0, 1), (10.0, 0.5, -4.0, 1)],
)
def test_it_ends_level_calm_and_no_longer_falling(tilt_deg, rate, climb_mps, goes_on):
    c, x = let_go(Rotation.from_euler("x", 2.5))
    x["quat_wxyz"] = Rotation.from_euler("x", tilt_deg, degrees=True).as_quat(scalar_first=True)
    x["angular_rate_flu_radps"] = (rate, 0.0, 0.0)
    x["velocity_enu_mps"] = (2.0, 0.0, climb_mps)
    x["position_enu_m"] = (1.0, 2.0, -9.0)
    tick(c, x)
    assert c["is_recovering"] == goes_on
    if not goes_on:  # tracking goes on from here
        np.testing.assert_allclose(c["reference_position_enu_m"], (1.0, 2.0, -9.0), atol=0.01)


def test_a_fall_is_braked_with_all_thrust():
    c, x = let_go(Rotation.from_euler("x", 2.5), velocity=(0.0, 0.0, -6.0))
    x["quat_wxyz"] = (1.0, 0.0, 0.0, 0.0)
    tick(c, x)
    assert c["collective_n"] == pytest.approx(c["mass_kg"] * c["max_thrust_mps2"])


def test_another_level_ends_it():
    c, x = let_go(Rotation.from_euler("x", 2.5))
    records = np.zeros(1, SETPOINT_DTYPE)
    records.view("f8")[:] = setpoint_row(Setpoint(level=ControlLevel.RATE, thrust=0.5))
    control(c, records[0], x, True)
    x["quat_wxyz"] = (1.0, 0.0, 0.0, 0.0)
    tick(c, x)
    assert c["is_recovering"] == 0
