"""The gimbal keeps to its limits and rates, and points where it is told."""

from math import atan2, degrees, isclose, pi, radians

import pytest

from flightsim.payload.gimbal import TICK_S, Gimbal, Pointing

_HERE = (0.0, 0.0, 10.0)


def _run(gimbal, seconds, heading_rad=0.0, position_enu_m=_HERE):
    for _ in range(round(seconds / TICK_S)):
        gimbal.update(position_enu_m, heading_rad)


def test_it_turns_no_faster_than_its_rate_and_stops_at_its_limits():
    gimbal = Gimbal()
    gimbal.point(Pointing(pitch_down_rad=radians(120.0), yaw_rad=radians(90.0)))
    _run(gimbal, 0.5)
    assert isclose(degrees(gimbal.pitch_down_rad), 30.0)
    assert isclose(degrees(gimbal.pitch_down_rate_radps), 60.0)
    assert isclose(degrees(gimbal.yaw_rad), 30.0)
    _run(gimbal, 2.0)
    assert isclose(degrees(gimbal.pitch_down_rad), 90.0)
    assert isclose(degrees(gimbal.yaw_rad), 90.0)
    assert gimbal.pitch_down_rate_radps == gimbal.yaw_rate_radps == 0.0
    gimbal.point(Pointing(pitch_down_rad=radians(-80.0)))
    _run(gimbal, 3.0)
    assert isclose(degrees(gimbal.pitch_down_rad), -30.0)
    assert isclose(degrees(gimbal.yaw_rad), 90.0)


def test_a_rate_turns_on_until_it_is_told_otherwise():
    gimbal = Gimbal()
    gimbal.point(Pointing(yaw_rate_radps=radians(20.0)))
    _run(gimbal, 10.0)
    assert isclose(degrees(gimbal.yaw_rad), -160.0, abs_tol=1e-6)
    gimbal.point(Pointing(yaw_rad=radians(-150.0), yaw_rate_radps=radians(5.0)))
    _run(gimbal, 1.0)
    assert isclose(degrees(gimbal.yaw_rad), -155.0, abs_tol=1e-6)


def test_it_turns_the_shorter_way():
    gimbal = Gimbal()
    gimbal.point(Pointing(yaw_rad=radians(170.0)))
    _run(gimbal, 4.0)
    gimbal.point(Pointing(yaw_rad=radians(-170.0)))
    _run(gimbal, 20.0 / 60.0 + 0.02)
    assert isclose(degrees(gimbal.yaw_rad), -170.0, abs_tol=1e-6)


def test_a_locked_yaw_stays_with_the_world():
    gimbal = Gimbal()
    gimbal.point(Pointing(yaw_rad=radians(40.0), is_yaw_locked=True))
    _run(gimbal, 2.0)
    for heading_deg in range(0, 60, 1):
        gimbal.update(_HERE, radians(heading_deg))
        assert isclose(degrees(gimbal.yaw_rad) + heading_deg, 40.0, abs_tol=1e-6)
    gimbal.point(Pointing())
    _run(gimbal, 1.0, heading_rad=2.0)
    assert isclose(degrees(gimbal.yaw_rad), 40.0 - 59.0, abs_tol=1e-6)


@pytest.mark.parametrize("heading_rad", [0.0, 1.0, -3.0])
def test_it_follows_a_target(heading_rad):
    gimbal = Gimbal()
    gimbal.look_at(lambda: (10.0, 10.0, 0.0))
    _run(gimbal, 4.0, heading_rad)
    across = (gimbal.yaw_rad + heading_rad - pi / 4.0 + pi) % (2.0 * pi) - pi
    assert isclose(across, 0.0, abs_tol=1e-9)
    assert isclose(gimbal.pitch_down_rad, atan2(10.0, 200.0**0.5))
    _run(gimbal, 2.0, heading_rad, (10.0, 10.0, 30.0))
    assert isclose(degrees(gimbal.pitch_down_rad), 90.0)


def test_an_unknown_position_or_target_leaves_it_where_it_is():
    gimbal = Gimbal()
    gimbal.look_at(lambda: None)
    _run(gimbal, 1.0)
    gimbal.look_at(lambda: (float("nan"), 0.0, 0.0))
    _run(gimbal, 1.0)
    gimbal.update(_HERE, float("nan"))
    assert gimbal.pitch_down_rad == gimbal.yaw_rad == 0.0
