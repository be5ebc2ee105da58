"""Flight on three rotors: which are lost, and what the others make."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from autonomy.control import SETPOINT_DTYPE
from autonomy.control.controller import control
from autonomy.control.record import setpoint_row
from autonomy.control.rotor_loss import spare_allocations
from autonomy.model.dynamics import thrust_torque_matrix
from autonomy.types import OFF, ControlLevel, Setpoint
from tests.autonomy.sample_quadrotors import IRIS, PLUS, hovering, ring

HOLD = Setpoint(level=ControlLevel.TRAJECTORY, position_enu_m=(0.0, 0.0, 0.0))
TICKS = 8
"""Control ticks after which a rotor that does not turn counts as lost."""


def run(c, x, setpoint, ticks, speed_shares=(1.0, 1.0, 1.0, 1.0)):
    """Run the controller while its rotors turn at shares of what they should."""
    records = np.zeros(1, SETPOINT_DTYPE)
    records.view("f8")[:] = setpoint_row(setpoint)
    x["has_rotor_speeds"] = 1
    for k in range(ticks):
        n = c["n_rotors"]
        x["rotor_speed_radps"][:n] = np.multiply(c["rotor_model_radps"][:n], speed_shares)
        control(c, records[0], x, k == 0)


@pytest.mark.parametrize("quadrotor", [IRIS, PLUS])
def test_three_thrusts_make_the_collective_and_the_torques_of_tilt(quadrotor):
    hubs = np.array([rotor.position_flu_m for rotor in quadrotor.rotors])
    spare, balance = spare_allocations(quadrotor)
    for lost in range(4):
        wanted = np.array([15.0, 0.3, -0.2, 0.0])
        thrusts = spare[lost] @ wanted
        assert thrusts[lost] == 0.0
        made = (thrusts.sum(), hubs[:, 1] @ thrusts, -hubs[:, 0] @ thrusts)
        np.testing.assert_allclose(made, wanted[:3], atol=1e-12)
        balanced = spare[lost] @ (1.0, *balance[lost], 0.0)
        apart = np.linalg.norm(hubs[:, :2] - hubs[lost, :2], axis=1)
        opposite = int(apart.argmax())
        others = [i for i in range(4) if i not in {lost, opposite}]
        assert balanced[opposite] == pytest.approx(0.5 * balanced[others[0]])
        assert balanced[others[0]] == pytest.approx(balanced[others[1]])


def test_five_of_six_balance_without_torque_and_without_the_opposite_one():
    vehicle = ring(6)
    matrix = thrust_torque_matrix(vehicle)
    spare, balance = spare_allocations(vehicle)
    np.testing.assert_allclose(balance, 0.0, atol=1e-9)
    for lost in range(6):
        np.testing.assert_allclose(matrix @ spare[lost, :, 0], (1.0, 0.0, 0.0, 0.0), atol=1e-6)
        assert spare[lost, lost].tolist() == [0.0] * 4
        assert spare[lost, (lost + 3) % 6, 0] == pytest.approx(0.0, abs=1e-6)
        made = matrix[:3] @ spare[lost] @ (20.0, 0.4, -0.3, 0.0)
        np.testing.assert_allclose(made, (20.0, 0.4, -0.3), atol=1e-9)


def test_seven_of_eight_hold_the_yaw_too():
    vehicle = ring(8)
    spare, _ = spare_allocations(vehicle)
    for lost in range(8):
        made = thrust_torque_matrix(vehicle) @ spare[lost]
        np.testing.assert_allclose(made, np.eye(4), atol=1e-9)
        assert np.delete(spare[lost, :, 0], lost).min() > 0.25 / 7.0


@pytest.mark.parametrize("rotor", range(4))
def test_a_rotor_that_does_not_turn_is_lost_until_the_rotors_rest(rotor):
    c, x = hovering()
    shares = [1.0] * 4
    shares[rotor] = 0.5
    run(c, x, HOLD, TICKS - 1, shares)
    assert c["n_lost"] == 0
    run(c, x, HOLD, 1, shares)
    assert np.flatnonzero(c["is_lost"]).tolist() == [rotor]
    run(c, x, HOLD, 50)
    assert c["n_lost"] == 1, "it is commanded to idle: that it does so says nothing"
    run(c, x, OFF, 1)
    assert c["n_lost"] == 0
    assert not c["is_lost"].any()


def test_a_rotor_that_turns_slower_or_is_not_measured_is_not_lost():
    c, x = hovering()
    run(c, x, HOLD, 50, (0.85, 1.0, 1.0, 1.0))
    assert c["n_lost"] == 0
    c, x = hovering()
    records = np.zeros(1, SETPOINT_DTYPE)
    records.view("f8")[:] = setpoint_row(HOLD)
    for k in range(50):
        control(c, records[0], x, k == 0)
    assert c["n_lost"] == 0


@given(
    st.tuples(*[st.floats(-25.0, 25.0)] * 3),
    st.tuples(*[st.floats(-1.0, 1.0)] * 4).filter(lambda q: math.hypot(*q) > 0.1),
    st.sampled_from([ControlLevel.TRAJECTORY, ControlLevel.ATTITUDE, ControlLevel.RATE]),
)
def test_no_motion_makes_an_unsound_command(rate_radps, quat, level):
    c, x = hovering()
    c["n_lost"], c["is_lost"][2] = 1, 1
    x["angular_rate_flu_radps"] = rate_radps
    x["quat_wxyz"] = np.divide(quat, math.hypot(*quat))
    run(c, x, Setpoint(level=level, position_enu_m=(0.0, 0.0, 5.0), thrust=0.5), 3)
    command = c["rotor_command_radps"]
    assert np.all(np.isfinite(command))
    assert np.all(command >= c["idle_speed_radps"])
    assert np.all(command <= c["max_rotor_speed_radps"])


def test_level_and_at_rest_it_carries_the_weight():
    c, x = hovering()
    c["n_lost"], c["is_lost"][0] = 1, 1
    c["rotor_model_radps"][0] = 0.0
    run(c, x, HOLD, 1)
    assert c["collective_n"] == pytest.approx(IRIS.mass_kg * 9.81, rel=1e-6)
    assert c["rotor_thrust_n"][0] == c["min_rotor_thrust_n"][0]
