"""Poses of a companion: the vehicle is where they say, unless satellites know better."""

import math

import pytest

from flightsim.frames import swap_yaw_enu_ned
from flightsim.mavlink.personalities import ARDUPILOT
from flightsim.plant import PlantCfg
from flightsim.sensors.failure import Failure
from tests.flightsim.mavlink.conftest import Flight
from tests.flightsim.mavlink.wire import named

_NED, _FRD, _BODY = 1, 20, 12
_UNKNOWN = [math.nan] + [0.0] * 20


def _texts(flight):
    return "".join(m.text for m in named(flight.heard, "STATUSTEXT"))


@pytest.fixture
def blind(field, monkeypatch):
    """A vehicle that knows its start, and has neither satellites nor odometry of its own."""
    monkeypatch.setattr(
        "tests.flightsim.mavlink.conftest.PlantCfg", lambda seed: PlantCfg(seed=seed, aiding="vio")
    )
    flight = Flight(field)
    flight.send("HEARTBEAT", 6, 8, 0, 0, 4, 3)
    flight.become_ready()
    flight.plant.failures.fail_sensor("vio", Failure.OFF)
    yield flight
    flight.close()


def _send(flight, name, offset, *, frame=_NED, velocity=(math.nan,) * 3):
    """Where the vehicle truly is, and how it truly heads, but for an offset in NED."""
    view, truth = flight.server._view, flight.plant.truth
    x, y, z = (c + d for c, d in zip(view.ned_from_enu(truth.position_enu_m), offset, strict=True))
    w, _, _, qz = truth.quat_wxyz
    yaw = swap_yaw_enu_ned(2.0 * math.atan2(qz, w))
    quat = [math.cos(yaw / 2), 0.0, 0.0, math.sin(yaw / 2)]
    now = flight.plant.time_us
    if name == "ODOMETRY":
        flight.send(name, now, frame, _BODY, x, y, z, quat, *velocity, 0, 0, 0, _UNKNOWN, _UNKNOWN)
    elif name == "ATT_POS_MOCAP":
        flight.send(name, now, quat, x, y, z)
    else:
        flight.send(name, now, x, y, z, 0.0, 0.0, yaw)


def _stream(flight, name, offset, n=40, **fields):
    for _ in range(n):
        _send(flight, name, offset, **fields)
        flight.step(2)


def _error_ned_m(flight):
    view = flight.server._view
    true = view.ned_from_enu(flight.plant.truth.position_enu_m)
    return tuple(a - b for a, b in zip(view.position_ned_m, true, strict=True))


@pytest.mark.parametrize(
    "name",
    [
        *("VISION_POSITION_ESTIMATE", "VICON_POSITION_ESTIMATE"),
        *("GLOBAL_VISION_POSITION_ESTIMATE", "ATT_POS_MOCAP", "ODOMETRY"),
    ],
)
def test_without_satellites_the_vehicle_is_where_a_companion_says(blind, name):
    _stream(blind, name, (3.0, -2.0, -1.0))
    assert _error_ned_m(blind) == pytest.approx((3.0, -2.0, -1.0), abs=0.1)
    assert f"{name} takes the place of the vehicle's odometry" in _texts(blind)
    assert f"Position starts anew from {name}" in _texts(blind)
    assert "Heading of" not in _texts(blind)


def test_an_outlier_is_refused_and_a_lasting_jump_is_not(blind):
    _stream(blind, "ATT_POS_MOCAP", (0.0, 0.0, 0.0))
    _stream(blind, "ATT_POS_MOCAP", (9.0, 0.0, 0.0), n=3)
    assert _error_ned_m(blind)[0] == pytest.approx(0.0, abs=0.1)
    _stream(blind, "ATT_POS_MOCAP", (9.0, 0.0, 0.0), n=20)
    assert _error_ned_m(blind)[0] == pytest.approx(9.0, abs=0.2)


def test_an_axis_of_a_huge_variance_is_not_used(blind):
    covariance = [0.0] * 21
    covariance[0] = covariance[6] = 0.01
    covariance[11] = covariance[20] = 1e6
    for _ in range(40):
        x, y, z = blind.server._view.ned_from_enu(blind.plant.truth.position_enu_m)
        now = blind.plant.time_us
        blind.send("VISION_POSITION_ESTIMATE", now, x + 3.0, y, z - 9.0, 0.0, 0.0, 1.5, covariance)
        blind.step(2)
    assert _error_ned_m(blind) == pytest.approx((3.0, 0.0, 0.0), abs=0.2)
    assert "Heading of" not in _texts(blind)


def test_a_frame_of_its_own_moves_nothing_and_carries_the_position(blind):
    _stream(blind, "ODOMETRY", (30.0, 40.0, 5.0), frame=_FRD)
    assert _error_ned_m(blind) == pytest.approx((0.0, 0.0, 0.0), abs=0.15)
    sigma_m = blind.plant.estimator.sigma_horizontal_m
    for step in range(20):
        _send(blind, "ODOMETRY", (30.0 + 0.02 * step, 40.0, 5.0), frame=_FRD)
        blind.step(2)
    assert _error_ned_m(blind)[0] > 0.1
    assert blind.plant.estimator.sigma_horizontal_m < sigma_m + 0.2


def test_with_satellites_poses_are_relative(flight):
    flight.become_ready()
    _stream(flight, "VISION_POSITION_ESTIMATE", (30.0, 0.0, 0.0))
    assert _error_ned_m(flight)[0] == pytest.approx(0.0, abs=0.2)
    flight.run(2.0)
    assert "VISION_POSITION_ESTIMATE lost: there is no other odometry" in _texts(flight)


def test_the_parameter_says_what_is_used(blind):
    blind.autopilot.parameters.set("EKF2_EV_CTRL", 0)
    _stream(blind, "ATT_POS_MOCAP", (3.0, 0.0, 0.0), n=5)
    assert "ATT_POS_MOCAP is not used: EKF2_EV_CTRL = 15 lets it be used" in _texts(blind)
    assert abs(_error_ned_m(blind)[0]) < 0.5
    blind.autopilot.parameters.set("EKF2_EV_CTRL", 2)  # the height alone
    _stream(blind, "ATT_POS_MOCAP", (3.0, 0.0, -2.0), n=10)
    error = _error_ned_m(blind)
    assert abs(error[0]) < 0.5
    assert error[2] == pytest.approx(-2.0, abs=0.1)


def test_arducopter_wants_viso_type(field):
    copter = Flight(field, ARDUPILOT)
    try:
        copter.send("HEARTBEAT", 6, 8, 0, 0, 4, 3)
        copter.become_ready()
        _stream(copter, "VISION_POSITION_ESTIMATE", (0.0, 0.0, 0.0), n=3)
        assert "VISION_POSITION_ESTIMATE is not used: VISO_TYPE = 1 lets" in _texts(copter)
        copter.send("PARAM_SET", 1, 1, b"VISO_TYPE", 1.0, 9)
        copter.step(2)
        _stream(copter, "VISION_POSITION_ESTIMATE", (0.0, 0.0, 0.0), n=3)
        assert copter.plant.external_aids.is_fed_poses
    finally:
        copter.close()


def test_a_heading_that_the_compass_contradicts_is_refused_and_the_place_is_used(blind):
    view = blind.server._view
    for _ in range(10):
        x, y, z = view.ned_from_enu(blind.plant.truth.position_enu_m)
        yaw = view.rpy_rad[2] + 2.0
        blind.send("VISION_POSITION_ESTIMATE", blind.plant.time_us, x + 3.0, y, z, 0, 0, yaw)
        blind.step(2)
    assert "it differs from the compass" in _texts(blind)
    assert _error_ned_m(blind)[0] == pytest.approx(3.0, abs=0.1)


def test_velocities_are_used_and_impossible_poses_are_not(blind):
    _stream(blind, "ODOMETRY", (0.0, 0.0, 0.0), velocity=(0.5, 0.0, 0.0))
    assert "ODOMETRY gives the velocity" in _texts(blind)
    speed = math.hypot(*blind.plant.estimate.velocity_enu_mps[:2])
    assert speed > 0.05
    blind.send("VISION_POSITION_ESTIMATE", 0, math.nan, 0.0, 0.0, 0.0, 0.0, 0.0)
    blind.send("ODOMETRY", 0, 12, _BODY, 0, 0, 0, [1, 0, 0, 0], *[0] * 6, _UNKNOWN, _UNKNOWN)
    blind.step(3)
    assert "VISION_POSITION_ESTIMATE refused: position nan, 0, 0 m" in _texts(blind)
    assert "ODOMETRY refused: frame_id = 12; valid are 1 (local NED) and 20" in _texts(blind)


def test_the_own_odometry_goes_on_afterwards(blind):
    blind.plant.failures.fail_sensor("vio", Failure.NONE)
    _stream(blind, "ATT_POS_MOCAP", (3.0, 0.0, 0.0))
    assert blind.plant._record["vio"]["is_replaced"] == 1
    blind.run(2.0)
    assert "ATT_POS_MOCAP lost: the vehicle's own goes on" in _texts(blind)
    assert blind.plant.filter["has_vio"] == 1
    assert _error_ned_m(blind)[0] == pytest.approx(3.0, abs=0.2)


def test_a_filter_that_waits_for_a_place_starts_at_the_one_that_it_is_told(field):
    flight = Flight(field)
    try:
        flight.plant.failures.fail_sensor("gnss", Failure.OFF)
        flight.send("HEARTBEAT", 6, 8, 0, 0, 4, 3)
        flight.run(2.0)
        assert not flight.plant.is_aligned
        _stream(flight, "ATT_POS_MOCAP", (3.0, 0.0, 0.0))
        assert flight.plant.is_aligned
        assert _error_ned_m(flight)[0] == pytest.approx(3.0, abs=0.2)
    finally:
        flight.close()
