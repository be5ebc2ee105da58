"""Rotors and air: each term of the model, in closed form."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from scipy.spatial.transform import Rotation

from autonomy.model.dynamics import thrust_torque_matrix
from flightsim.vehicles.catalogue import AIRFRAMES
from flightsim.vehicles.rotor_model import new_rotors, step_rotors

IRIS = AIRFRAMES["iris"].quadrotor
DT = 0.002
LEVEL = np.array([1.0, 0.0, 0.0, 0.0])
vectors = hnp.arrays(float, 3, elements=st.floats(-12.0, 12.0))


def rotors(speed=0.0, *, box=(0.0, 0.0, 0.0), axial=math.inf):
    r = new_rotors(IRIS, box, dt_s=DT, axial_limit_mps=axial)[0]
    r["speed_radps"] = speed
    return r


def wrench_of(r, command, quat=LEVEL, velocity=(0, 0, 0), rate=(0, 0, 0)):
    wrench = np.empty(6)
    step_rotors(
        r,
        np.broadcast_to(np.asarray(command, float), 4).copy(),
        np.asarray(quat, float),
        np.asarray(velocity, float),
        np.asarray(rate, float),
        wrench,
    )
    return wrench


@pytest.mark.parametrize(("start", "command", "tau"), [(0.0, 800.0, 0.0125), (800.0, 0.0, 0.025)])
def test_step_response_is_first_order_with_its_own_time_constant(start, command, tau):
    r = rotors(start)
    for k in range(1, 40):
        wrench_of(r, command)
        expected = command + (start - command) * math.exp(-k * DT / tau)
        np.testing.assert_allclose(r["speed_radps"], expected, rtol=1e-9)


@given(hnp.arrays(float, 4, elements=st.floats(0.0, 1100.0)))
def test_still_air_gives_thrusts_and_torques_of_the_allocation(speeds):
    wrench = wrench_of(rotors(speeds), speeds)
    expected = thrust_torque_matrix(IRIS) @ (5.84e-6 * speeds**2)
    np.testing.assert_allclose(wrench[2:], expected, atol=1e-9)
    np.testing.assert_allclose(wrench[:2], 0.0, atol=1e-12)


@given(vectors, st.floats(-3.0, 3.0))
def test_a_wrench_turns_with_the_body(velocity, yaw):
    turn = Rotation.from_euler("z", yaw)
    level = wrench_of(rotors(600.0), 600.0, velocity=velocity)
    turned = wrench_of(rotors(600.0), 600.0, turn.as_quat(scalar_first=True), turn.apply(velocity))
    np.testing.assert_allclose(turned[:3], turn.apply(level[:3]), atol=1e-9)
    np.testing.assert_allclose(turned[3:], turn.apply(level[3:]), atol=1e-9)


@given(vectors, vectors)
def test_only_the_velocity_relative_to_the_air_counts(velocity, wind):
    r = rotors(600.0, box=(0.5, 0.5, 0.1), axial=25.0)
    r["wind_enu_mps"] = wind
    windy = wrench_of(r, 600.0, velocity=velocity + wind)
    calm = wrench_of(rotors(600.0, box=(0.5, 0.5, 0.1), axial=25.0), 600.0, velocity=velocity)
    np.testing.assert_allclose(windy, calm, atol=1e-9)


@given(vectors)
def test_drag_opposes_motion_across_the_axis(velocity):
    w = 600.0
    wrench = wrench_of(rotors(w), w, velocity=velocity)
    np.testing.assert_allclose(wrench[:2], -4.0 * w * 1.75e-4 * velocity[:2], atol=1e-9)
    assert wrench[2] == pytest.approx(4.0 * 5.84e-6 * w**2)
    # drag acts at the hubs, above the centre of mass; the rolling moment adds to it
    height = IRIS.rotors[0].position_flu_m[2]
    fx, fy = wrench[:2]
    roll = -4.0 * w * 1e-6 * velocity
    assert wrench[3] == pytest.approx(-height * fy + roll[0], abs=1e-9)
    assert wrench[4] == pytest.approx(height * fx + roll[1], abs=1e-9)


@pytest.mark.parametrize(("climb", "share"), [(5.0, 0.8), (-5.0, 0.8), (25.0, 0.0), (40.0, 0.0)])
def test_thrust_fades_with_axial_speed(climb, share):
    still = wrench_of(rotors(600.0, axial=25.0), 600.0)[2]
    moving = wrench_of(rotors(600.0, axial=25.0), 600.0, velocity=(0, 0, climb))[2]
    assert moving == pytest.approx(share * still, abs=1e-9)


def test_turning_moves_the_hubs_through_the_air():
    """Yaw at rest is damped by the drag of rotors that go round."""
    wrench = wrench_of(rotors(600.0), 600.0, rate=(0.0, 0.0, 2.0))
    arms = sum(r.position_flu_m[0] ** 2 + r.position_flu_m[1] ** 2 for r in IRIS.rotors)
    assert wrench[5] == pytest.approx(-600.0 * 1.75e-4 * arms * 2.0, rel=1e-9)


def test_the_fuselage_adds_quadratic_drag():
    slow = wrench_of(rotors(box=(0.4, 0.4, 0.1)), 0.0, velocity=(2.0, 0.0, 0.0))
    fast = wrench_of(rotors(box=(0.4, 0.4, 0.1)), 0.0, velocity=(4.0, 0.0, 0.0))
    assert slow[0] < 0.0
    assert fast[0] == pytest.approx(4.0 * slow[0])


def test_commands_are_clipped_and_nan_stops_the_rotor():
    r = rotors(1000.0)
    for _ in range(500):
        wrench_of(r, [5000.0, -3.0, math.nan, 500.0])
    np.testing.assert_allclose(r["speed_radps"], (1100.0, 0.0, 0.0, 500.0), atol=1e-6)


def test_a_failed_rotor_makes_no_thrust():
    r = rotors(600.0)
    r["effectiveness"][2] = 0.0
    wrench = wrench_of(r, 600.0)
    assert wrench[2] == pytest.approx(3.0 * 5.84e-6 * 600.0**2)
