"""Rotors and air: each term of the model, in closed form."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from scipy.spatial.transform import Rotation

from autonomy.model.dynamics import thrust_torque_matrix
from flightsim.environment.effects import ALL_EFFECTS, NO_EFFECTS
from flightsim.vehicles.catalogue import AIRFRAMES
from flightsim.vehicles.rotor_model import new_rotors, step_rotors

AIRFRAME = AIRFRAMES["iris"]
IRIS = AIRFRAME.quadrotor
BARE = replace(AIRFRAME, body_size_m=(0.0, 0.0, 0.0))
DT = 0.002
DIRECTIONS = ((1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0))
LEVEL = np.array([1.0, 0.0, 0.0, 0.0])
vectors = hnp.arrays(float, 3, elements=st.floats(-12.0, 12.0))


def rotors(speed=0.0, *, airframe=BARE, axial=math.inf, effects=NO_EFFECTS):
    r = new_rotors(airframe, dt_s=DT, axial_limit_mps=axial, effects=effects)[0]
    r["speed_radps"][: r["n_rotors"]] = speed
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
        np.testing.assert_allclose(r["speed_radps"][:4], expected, rtol=1e-9)


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
    options = {"airframe": AIRFRAME, "axial": 25.0, "effects": ALL_EFFECTS}
    r = rotors(600.0, **options)
    r["wind_enu_mps"] = wind
    windy = wrench_of(r, 600.0, velocity=velocity + wind)
    calm = wrench_of(rotors(600.0, **options), 600.0, velocity=velocity)
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
def test_without_inflow_thrust_fades_with_axial_speed(climb, share):
    still = wrench_of(rotors(600.0, axial=25.0), 600.0)[2]
    moving = wrench_of(rotors(600.0, axial=25.0), 600.0, velocity=(0, 0, climb))[2]
    assert moving == pytest.approx(share * still, abs=1e-9)


def test_turning_moves_the_hubs_through_the_air():
    """Yaw at rest is damped by the drag of rotors that go round."""
    wrench = wrench_of(rotors(600.0), 600.0, rate=(0.0, 0.0, 2.0))
    arms = sum(r.position_flu_m[0] ** 2 + r.position_flu_m[1] ** 2 for r in IRIS.rotors)
    assert wrench[5] == pytest.approx(-600.0 * 1.75e-4 * arms * 2.0, rel=1e-9)


@pytest.mark.parametrize("effects", [NO_EFFECTS, replace(NO_EFFECTS, frame_drag=True)])
def test_the_frame_adds_quadratic_drag(effects):
    slow, fast = (
        wrench_of(rotors(airframe=AIRFRAME, effects=effects), 0.0, velocity=(speed, 0.0, 0.0))
        for speed in (2.0, 4.0)
    )
    assert slow[0] < 0.0
    assert fast[0] == pytest.approx(4.0 * slow[0])


@given(vectors, vectors)
def test_canted_rotors_pull_and_drag_along_and_across_their_axes(velocity, rate):
    tilt = 0.3
    axes = [(math.sin(tilt) * c, math.sin(tilt) * s, math.cos(tilt)) for c, s in DIRECTIONS]
    canted = tuple(replace(r, axis_flu=a) for r, a in zip(IRIS.rotors, axes, strict=True))
    airframe = replace(BARE, quadrotor=replace(IRIS, rotors=canted))
    speeds = np.array([700.0, 800.0, 900.0, 600.0])
    r = rotors(speeds, airframe=airframe)
    wrench = wrench_of(r, speeds, velocity=velocity, rate=rate)
    force, torque = np.zeros(3), np.zeros(3)
    for rotor, w in zip(canted, speeds, strict=True):
        axis, hub = np.array(rotor.axis_flu), np.array(rotor.position_flu_m)
        air = velocity + np.cross(rate, hub)
        across = air - (air @ axis) * axis
        thrust = rotor.thrust_constant * w**2
        pull = thrust * axis - w * rotor.drag_coefficient * across
        force += pull
        torque += np.cross(hub, pull) - rotor.spin * rotor.torque_per_thrust_m * thrust * axis
        torque -= w * rotor.rolling_moment_coefficient * across
    np.testing.assert_allclose(wrench, [*force, *torque], atol=1e-9)


def test_commands_are_clipped_and_nan_stops_the_rotor():
    r = rotors(1000.0)
    for _ in range(500):
        wrench_of(r, [5000.0, -3.0, math.nan, 500.0])
    np.testing.assert_allclose(r["speed_radps"][:4], (1100.0, 0.0, 0.0, 500.0), atol=1e-6)


def test_a_failed_rotor_makes_no_thrust():
    r = rotors(600.0)
    r["effectiveness"][2] = 0.0
    wrench = wrench_of(r, 600.0)
    assert wrench[2] == pytest.approx(3.0 * 5.84e-6 * 600.0**2)


def test_hover_is_the_same_with_inflow_and_without():
    w = IRIS.hover_speed_radps
    for effects in (ALL_EFFECTS, NO_EFFECTS):
        wrench = wrench_of(rotors(w, axial=25.0, effects=effects), w)
        assert wrench[2] == pytest.approx(IRIS.mass_kg * 9.81, rel=1e-9)


def test_slow_climb_costs_the_thrust_of_the_axial_limit():
    """By momentum theory half of the climb is made up by less induced velocity."""
    w, slow = IRIS.hover_speed_radps, 0.01
    r = rotors(w, axial=25.0, effects=ALL_EFFECTS)
    climbing = wrench_of(r, w, velocity=(0.0, 0.0, slow))[2]
    assert 1.0 - climbing / (IRIS.mass_kg * 9.81) == pytest.approx(slow / 25.0, rel=1e-2)


def test_a_rotor_without_power_coasts_by_its_torque():
    """J w' = -kf c w^2 without friction: w = w0 / (1 + kf c w0 t / J)."""
    r = rotors(800.0, axial=25.0, effects=ALL_EFFECTS)
    r["friction_radps"] = 0.0
    rotor, steps = IRIS.rotors[0], 200
    for _ in range(steps):
        wrench = wrench_of(r, 0.0)
    rate = rotor.thrust_constant * rotor.torque_per_thrust_m * 800.0 / AIRFRAME.rotor_inertia_kgm2
    np.testing.assert_allclose(r["speed_radps"][:4], 800.0 / (1.0 + rate * steps * DT), rtol=0.02)
    assert wrench[5] == pytest.approx(0.0, abs=1e-12)  # nothing drives it, nothing reacts


def test_bearings_stop_a_rotor_that_coasts():
    r = rotors(100.0, effects=ALL_EFFECTS)
    for _ in range(1500):
        wrench_of(r, 0.0)
    np.testing.assert_array_equal(r["speed_radps"], 0.0)


@pytest.mark.parametrize(("climb", "sign"), [(18.0, 1.0), (-18.0, -1.0)])
def test_air_along_the_axis_turns_a_rotor_without_power(climb, sign):
    """It ends between rest and the speed at which the blades cut no air, v / pitch."""
    r = rotors(axial=25.0, effects=ALL_EFFECTS)
    for _ in range(3000):
        wrench = wrench_of(r, 0.0, velocity=(0.0, 0.0, climb))
    free = climb / (r["induced_m"][0] + 1.0 / r["rad_per_m"])
    assert 0.1 < r["speed_radps"][0] / free < 0.9
    assert wrench[2] * sign < 0.0  # and brakes the motion


def test_blades_that_stand_still_resist_about_like_plates():
    """Plates of 10% solidity, usual for two blades, have Cd 1.17 across the flow (Hoerner)."""
    effects = replace(NO_EFFECTS, inflow=True)
    lift = wrench_of(rotors(axial=25.0, effects=effects), 0.0, velocity=(0.0, 0.0, -10.0))[2]
    plate = 0.5 * 1.225 * 100.0 * 1.17 * 0.1 * math.pi * AIRFRAME.rotor_radius_m**2
    assert lift / 4.0 == pytest.approx(plate, rel=0.25)


@pytest.mark.parametrize(("name", "low", "high"), [("iris", 17, 20), ("hummingbird", 15, 18)])
def test_a_fall_ends_at_the_speed_of_mass_and_area(name, low, high):
    """Where drag is the weight; quadrotors of 0.7 to 1.5 kg fall at 15 to 20 m/s."""
    airframe = AIRFRAMES[name]
    r = new_rotors(airframe, dt_s=DT)[0]
    speed, mass = 0.0, airframe.quadrotor.mass_kg
    for _ in range(6000):
        lift = wrench_of(r, 0.0, velocity=(0.0, 0.0, -speed))[2]
        speed += (9.81 - lift / mass) * DT
    assert low < speed < high
    blades = lift - r["frame_drag"][2] * speed**2
    assert 0.15 < blades / lift < 0.6
    assert lift == pytest.approx(mass * 9.81, rel=1e-3)
