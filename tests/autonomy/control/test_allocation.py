"""Allocation: rotor limits always hold, and demands yield in the order of their priority."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from autonomy.control.allocation import allocate, lead_command
from autonomy.model.dynamics import thrust_torque_matrix
from autonomy.model.layout import inverse_allocation
from tests.autonomy.sample_quadrotors import IRIS, PLUS, ring

demands = st.tuples(
    st.sampled_from([IRIS, PLUS, ring(6), ring(8)]),
    st.floats(-5.0, 40.0),
    st.tuples(*[st.floats(-8.0, 8.0)] * 2, st.floats(-3.0, 3.0)),
)


def solve(vehicle, collective, torque):
    B = thrust_torque_matrix(vehicle)
    high = np.array([r.thrust_constant * r.max_speed_radps**2 for r in vehicle.rotors])
    low = 0.0144 * high
    thrust = np.empty(len(vehicle.rotors))
    allocate(inverse_allocation(vehicle), collective, np.array(torque), low, high, thrust)
    return thrust, B @ thrust, low, high


def fits(thrust, low, high, slack=1e-9):
    return np.all(thrust >= low - slack) and np.all(thrust <= high + slack)


@given(demands)
def test_rotor_limits_are_never_exceeded(demand):
    thrust, _, low, high = solve(*demand)
    assert np.all(thrust >= low)
    assert np.all(thrust <= high)


@given(demands)
def test_a_demand_that_fits_is_met_exactly(demand):
    vehicle, collective, torque = demand
    wanted = np.array([collective, *torque])
    exact = inverse_allocation(vehicle) @ wanted
    thrust, made, low, high = solve(*demand)
    if fits(exact, low, high, slack=0.0):
        np.testing.assert_allclose(made, wanted, atol=1e-9)
    else:
        assert not np.allclose(thrust, exact, atol=1e-12)


@given(demands)
def test_roll_and_pitch_are_met_whenever_any_collective_allows_it(demand):
    vehicle, _, torque = demand
    _, made, low, high = solve(*demand)
    A = inverse_allocation(vehicle)
    tilt = A[:, 1] * torque[0] + A[:, 2] * torque[1]
    least = np.max((low - tilt) / A[:, 0])
    most = np.min((high - tilt) / A[:, 0])
    if least <= most:
        np.testing.assert_allclose(made[1:3], torque[:2], atol=1e-9)
    else:  # direction kept, size reduced
        assert made[1] * torque[1] == pytest.approx(made[2] * torque[0], abs=1e-9)
        assert made[1] * torque[0] + made[2] * torque[1] >= 0.0
        assert np.linalg.norm(made[1:3]) < np.linalg.norm(torque[:2])


@given(demands)
def test_yaw_yields_before_the_collective(demand):
    vehicle, collective, torque = demand
    _, made, low, high = solve(*demand)
    A = inverse_allocation(vehicle)
    without_yaw = A @ np.array([collective, torque[0], torque[1], 0.0])
    if fits(without_yaw, low, high, slack=0.0):
        assert made[0] == pytest.approx(collective, abs=1e-9)
        assert abs(made[3]) <= abs(torque[2]) + 1e-9
        assert made[3] * torque[2] >= -1e-9


@given(st.floats(100.0, 1000.0), st.floats(100.0, 1000.0), st.sampled_from([0.0125, 0.025]))
def test_lead_makes_a_slow_rotor_as_fast_as_asked(speed, wanted, tau):
    dt, response = 0.004, 0.006
    command = lead_command(speed, wanted, tau, response, dt)
    reached = speed + (command - speed) * (1.0 - np.exp(-dt / tau))
    ideal = speed + (wanted - speed) * (1.0 - np.exp(-dt / response))
    assert reached == pytest.approx(ideal, abs=1e-9)


def test_a_fast_rotor_is_commanded_directly():
    assert lead_command(100.0, 500.0, 0.005, 0.006, 0.004) == 500.0
