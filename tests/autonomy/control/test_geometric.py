"""The geometric controller: its fixed points, and its rates against finite differences."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from scipy.spatial.transform import Rotation

from autonomy.control.geometric import (
    attitude_torque,
    command_attitude,
    demand_force,
    estimate_acceleration,
    rate_torque,
)
from autonomy.model.dynamics import thrust_torque_matrix
from tests.autonomy.sample_quadrotors import IRIS, G, hovering

vectors = hnp.arrays(float, 3, elements=st.floats(-1.0, 1.0))
rotations = st.integers(0, 2**32 - 1).map(lambda seed: Rotation.random(random_state=seed))


def test_hover_needs_weight_and_nothing_else():
    c, f = hovering()
    demand_force(c, f)
    np.testing.assert_allclose(c["force_enu_mps2"], (0.0, 0.0, G), atol=1e-12)
    command_attitude(c, f)
    np.testing.assert_allclose(c["R_cmd"], np.eye(3), atol=1e-12)
    attitude_torque(c, np.zeros(3))
    np.testing.assert_allclose(c["torque_flu_nm"], 0.0, atol=1e-12)


@given(vectors)
def test_feedback_acts_against_the_error_and_is_bounded(error):
    c, f = hovering()
    f["position_enu_m"] = -10.0 * error
    demand_force(c, f)
    demanded = c["force_enu_mps2"] - (0.0, 0.0, G) - c["integral_mps2"]
    assert demanded @ error >= -1e-12
    assert np.hypot(*demanded[:2]) <= c["max_feedback_mps2"] + 1e-9


@given(vectors, vectors)
def test_tilt_and_thrust_limits_hold_for_any_reference(acceleration, error):
    c, f = hovering()
    c["reference_acceleration_enu_mps2"] = 60.0 * acceleration
    f["velocity_enu_mps"] = 40.0 * error
    demand_force(c, f)
    force = c["force_enu_mps2"]
    assert force[2] > 0.0
    assert np.hypot(*force[:2]) <= c["max_tilt_tangent"] * force[2] + 1e-9
    assert np.linalg.norm(force) <= np.hypot(c["max_thrust_mps2"], 1.0) + 1e-9


def test_wind_seen_by_the_accelerometer_is_flown_against():
    c, f = hovering()
    f["acceleration_enu_mps2"] = (1.5, 0.0, 0.0)
    for _ in range(500):
        demand_force(c, f)
    np.testing.assert_allclose(c["force_enu_mps2"], (-1.5, 0.0, G), atol=1e-4)


def test_the_ground_that_holds_a_pressing_vehicle_is_no_wind():
    c, x = hovering()
    c["force_enu_mps2"] = (0.0, 0.0, 0.5 * G)
    c["disturbance_mps2"] = (0.3, 0.0, -0.2)
    x["acceleration_enu_mps2"] = (1.5, 0.0, 5.0)
    for _ in range(250):
        estimate_acceleration(c, x)
    np.testing.assert_allclose(c["disturbance_mps2"], (0.0, 0.0, -0.2), atol=1e-3)


def test_wind_is_flown_against_in_an_updraught_too_where_nothing_is_below():
    c, x = hovering()
    c["room_below_m"] = 0.3
    c["force_enu_mps2"] = (0.0, 0.0, 0.5 * G)
    x["acceleration_enu_mps2"] = (1.5, 0.0, 5.0)
    for _ in range(250):
        estimate_acceleration(c, x)
    np.testing.assert_allclose(c["disturbance_mps2"][:2], (1.5, 0.0), atol=1e-3)


def test_a_vehicle_that_presses_down_hardly_leans():
    c, x = hovering()
    x["position_enu_m"] = (2.0, -1.0, 0.8)
    c["disturbance_mps2"] = (0.0, 0.0, 1.5)  # the ground bears a part of it
    demand_force(c, x)
    force = c["force_enu_mps2"]
    assert np.degrees(np.arctan(np.hypot(*force[:2]) / force[2])) < 6.0


def test_lost_thrust_is_made_up_for_further_than_a_push_from_below():
    c, x = hovering()
    held = []
    for climbing in (-20.0, 20.0):
        c["force_enu_mps2"] = (0.0, 0.0, G)
        x["acceleration_enu_mps2"] = (0.0, 0.0, climbing)
        for _ in range(200):
            estimate_acceleration(c, x)
        held.append(c["disturbance_mps2"][2])
    limit = c["max_disturbance_mps2"]
    np.testing.assert_allclose(held, (-0.25 * limit, 0.125 * limit))


def test_a_storm_that_the_thrust_can_hold_is_held_without_an_error():
    c, f = hovering()
    f["acceleration_enu_mps2"] = (10.0, 0.0, 0.0)
    for _ in range(500):
        demand_force(c, f)
    np.testing.assert_allclose(c["force_enu_mps2"], (-10.0, 0.0, G), atol=1e-3)


@given(st.floats(2.0, 12.0), st.floats(1.0, 6.0))
def test_a_climb_leaves_thrust_to_hold_the_place_and_a_gust_thrust_to_climb(push, climb):
    c, f = hovering()
    c["max_thrust_mps2"] = 17.5
    c["disturbance_mps2"] = f["acceleration_enu_mps2"] = (push, 0.0, 0.0)
    f["position_enu_m"] = (0.0, 0.0, -climb / c["position_gain"])
    c["integral_gain"] = 0.0
    demand_force(c, f)
    east, _, up = c["force_enu_mps2"]
    assert np.hypot(east, up) <= 17.5 + 1e-9
    # Both get the same share of what they ask for beyond the weight.
    against, weight = -c["disturbance_mps2"][0], G - c["disturbance_mps2"][2]
    assert east / against == pytest.approx((up - weight) / climb, abs=1e-6)
    assert east / against > 0.5


def test_integral_removes_a_lasting_error_within_its_limit():
    c, f = hovering()
    f["position_enu_m"] = (-0.05, 0.0, 0.02)
    for _ in range(2500):
        f["acceleration_enu_mps2"] = 0.0
        demand_force(c, f)
    np.testing.assert_allclose(c["integral_mps2"], (1.0, 0.0, -0.6), atol=1e-6)


def reference(t):
    """A curve with yaw, its derivatives known."""
    a = np.array([2.0 * np.sin(t), 1.5 * np.cos(1.3 * t), 1.0 * np.sin(0.7 * t)])
    j = np.array([2.0 * np.cos(t), -1.95 * np.sin(1.3 * t), 0.7 * np.cos(0.7 * t)])
    return a, j, 0.4 * np.sin(0.9 * t), 0.36 * np.cos(0.9 * t)


def commanded(t):
    c, f = hovering()
    c["drag_coefficient"] = 0.0
    a, j, yaw, yaw_rate = reference(t)
    c["reference_acceleration_enu_mps2"], c["reference_jerk_enu_mps3"] = a, j
    c["reference_yaw_rad"], c["reference_yaw_rate_radps"] = yaw, yaw_rate
    c["velocity_gain"] = 0.0  # no feedback: the rates are the reference's alone
    demand_force(c, f)
    command_attitude(c, f)
    return c["R_cmd"].copy(), c["rate_cmd_flu_radps"].copy()


@given(st.floats(0.0, 20.0))
def test_commanded_rates_are_the_derivative_of_the_commanded_attitude(t):
    h = 1e-5
    before, after = commanded(t - h)[0], commanded(t + h)[0]
    R, rate = commanded(t)
    turn = Rotation.from_matrix(R.T @ after) * Rotation.from_matrix(R.T @ before).inv()
    np.testing.assert_allclose(turn.as_rotvec() / (2.0 * h), rate, atol=1e-4)
    np.testing.assert_allclose(R.T @ R, np.eye(3), atol=1e-12)


def turning(attitude, command=None):
    """Angular acceleration asked for, over the gains."""
    c, _ = hovering()
    c["R"] = attitude.as_matrix()
    c["R_cmd"] = np.eye(3) if command is None else command.as_matrix()
    attitude_torque(c, np.zeros(3))
    return c["torque_flu_nm"] / c["inertia_flu_kgm2"] / c["attitude_gain"]


@given(vectors)
def test_small_errors_are_those_of_lee(turn):
    attitude = Rotation.from_rotvec(1e-3 * turn)
    R = attitude.as_matrix()
    e_R = 0.5 * (R - R.T)[[2, 0, 1], [1, 2, 0]]  # eq. (10) for R_d = 1
    np.testing.assert_allclose(turning(attitude), -e_R, atol=1e-6)


@given(rotations)
def test_tilt_is_turned_back_the_shortest_way_and_harder_the_larger_it_is(attitude):
    up_flu = attitude.inv().apply((0.0, 0.0, 1.0))
    tilt = np.arccos(np.clip(up_flu[2], -1.0, 1.0))
    turn = turning(attitude)
    assert np.hypot(turn[0], turn[1]) == pytest.approx(2.0 * np.sin(0.5 * tilt), abs=1e-6)
    if 1e-3 < tilt < np.pi - 1e-3:
        axis = np.cross((0.0, 0.0, 1.0), up_flu) / np.sin(tilt)
        assert turn @ axis == pytest.approx(2.0 * np.sin(0.5 * tilt), abs=1e-6)


@given(rotations, st.floats(-3.0, 3.0))
def test_yaw_error_does_not_change_how_the_tilt_is_turned_back(attitude, yaw):
    command = Rotation.from_euler("z", yaw)
    tilted = turning(attitude)
    np.testing.assert_allclose(turning(attitude, command)[:2], tilted[:2], atol=1e-9)


@given(st.floats(-np.pi, np.pi), st.floats(0.0, 2.0 * np.pi), st.floats(-3.0, 3.0))
def test_yaw_counts_less_the_larger_the_tilt(tilt, about, yaw):
    lean = Rotation.from_rotvec(tilt * np.array([np.cos(about), np.sin(about), 0.0]))
    turn = turning(lean, Rotation.from_euler("z", yaw))
    assert turn[2] == pytest.approx(np.sin(yaw) * np.cos(0.5 * tilt) ** 2, abs=1e-9)


@given(st.floats(0.0, 2.0 * np.pi))
def test_upside_down_it_goes_on_turning_about_the_axis_it_turns_about(about):
    c, _ = hovering()
    c["R"], c["R_cmd"] = np.diag((1.0, -1.0, -1.0)), np.eye(3)
    axis = np.array([np.cos(about), np.sin(about), 0.0])
    c["angular_rate_gain"] = 0.0
    attitude_torque(c, 1e-3 * axis)
    turn = c["torque_flu_nm"] / c["inertia_flu_kgm2"] / c["attitude_gain"]
    np.testing.assert_allclose(turn, 2.0 * axis, atol=1e-5)


def test_a_limited_feedback_adds_no_rate():
    rates = []
    for position, acceleration in ((0.0, 0.0), (9.0, 0.0), (9.0, 4.0)):
        c, x = hovering()
        x["position_enu_m"] = (position, 0.0, 0.0)
        x["acceleration_enu_mps2"] = (acceleration, 0.0, 0.0)
        demand_force(c, x)
        command_attitude(c, x)
        assert c["is_limited"][0] == (position > 0.0)
        rates.append(c["rate_cmd_flu_radps"].copy())
    np.testing.assert_allclose(rates, 0.0, atol=1e-12)


@given(vectors)
def test_torques_cancel_the_gyroscopic_term(rate):
    c, _ = hovering()
    rate = 5.0 * rate
    c["R_cmd"] = np.eye(3)
    c["rate_cmd_flu_radps"] = rate
    J = c["inertia_flu_kgm2"]
    for law in (attitude_torque, rate_torque):
        law(c, rate)
        alpha = (c["torque_flu_nm"] - np.cross(rate, J * rate)) / J
        np.testing.assert_allclose(alpha, 0.0, atol=1e-9)


def test_thrust_torque_matrix_knows_the_axes():
    B = thrust_torque_matrix(IRIS)
    np.testing.assert_array_equal(B[0], 1.0)
    # front right pushed up: rolls left (negative y arm), pitches up (FLU: negative about y)
    assert B[1, 0] < 0.0
    assert B[2, 0] < 0.0
    # a counter-clockwise rotor turns the body clockwise
    assert B[3, 0] == pytest.approx(-0.06)
