"""From setpoints to references: what each axis follows, within which limits."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from autonomy.control import SETPOINT_DTYPE
from autonomy.control.record import setpoint_row
from autonomy.control.reference import start_reference, update_reference
from autonomy.control.setpoint_stream import accept_setpoint
from autonomy.types import ControlLevel, Setpoint
from tests.autonomy.sample_quadrotors import hovering

NAN = math.nan
DT = 0.004


class Follower:
    """A reference whose vehicle is exactly where the reference is."""

    def __init__(self, *, is_stuck=False):
        self.c, self.f = hovering()
        start_reference(self.c, self.f)
        self.is_stuck = is_stuck
        self.rows = []

    def follow(self, seconds, *, every=5, **setpoint):
        records = np.zeros(1, SETPOINT_DTYPE)
        for k in range(round(seconds / DT)):
            if k % every == 0:
                values = setpoint if "at" not in setpoint else setpoint["at"](k * DT)
                records.view("f8")[:] = setpoint_row(
                    Setpoint(level=ControlLevel.TRAJECTORY, **values)
                )
                accept_setpoint(self.c, records[0])
            update_reference(self.c, records[0], self.f)
            if not self.is_stuck:
                self.f["position_enu_m"] = self.c["reference_position_enu_m"]
                self.f["velocity_enu_mps"] = self.c["reference_velocity_enu_mps"]
                yaw = self.c["reference_yaw_rad"]
                self.f["quat_wxyz"] = (math.cos(yaw / 2), 0.0, 0.0, math.sin(yaw / 2))
            self.rows.append(self.c.copy())
        return self

    def column(self, name):
        return np.array([row[name] for row in self.rows])


targets = st.tuples(*[st.floats(-30.0, 30.0)] * 3)


@settings(max_examples=15)
@given(targets, targets)
def test_bare_setpoints_keep_to_the_limits(position, velocity):
    r = Follower().follow(1.5, position_enu_m=position).follow(1.0, velocity_enu_mps=velocity)
    c = r.c
    a, v = r.column("reference_acceleration_enu_mps2"), r.column("reference_velocity_enu_mps")
    jerk = np.diff(a, axis=0) / DT
    assert np.hypot(jerk[:, 0], jerk[:, 1]).max() <= c["max_jerk_mps3"] * (1.0 + 1e-6)
    assert np.hypot(a[:, 0], a[:, 1]).max() <= c["max_acceleration_mps2"] * (1.0 + 1e-6)
    assert np.abs(a[:, 2]).max() <= c["max_acceleration_vertical_mps2"] * (1.0 + 1e-6)
    np.testing.assert_allclose(np.diff(v, axis=0), a[1:] * DT, atol=1e-9)


@settings(max_examples=8)
@given(st.tuples(st.floats(-8.0, 8.0), st.floats(-8.0, 8.0), st.floats(-4.0, 4.0)))
def test_a_bare_position_is_reached_without_overshoot(target):
    r = Follower().follow(12.0, position_enu_m=target)
    p = r.column("reference_position_enu_m")
    np.testing.assert_allclose(p[-1], target, atol=0.02)
    beyond = np.max(p * np.sign(target), axis=0) - np.abs(target)
    assert beyond.max() < 0.03


def test_no_velocity_setpoint_flies_faster_than_allowed():
    r = Follower().follow(8.0, velocity_enu_mps=(900.0, -900.0, 900.0))
    vx, vy, vz = r.c["reference_velocity_enu_mps"]
    assert math.hypot(vx, vy) == pytest.approx(r.c["max_speed_mps"], rel=0.02)
    assert vz == pytest.approx(r.c["max_vertical_speed_mps"], rel=0.02)


def test_velocity_is_reached_quickly_without_overshoot():
    r = Follower().follow(3.0, velocity_enu_mps=(2.0, 0.0, 0.0))
    v = r.column("reference_velocity_enu_mps")
    assert v[round(1.5 / DT), 0] > 1.8
    assert v[:, 0].max() < 2.02
    np.testing.assert_array_equal(v[:, 1:], 0.0)


def test_axes_may_mix_position_and_velocity():
    r = Follower().follow(6.0, position_enu_m=(NAN, NAN, 3.0), velocity_enu_mps=(1.0, -0.5, NAN))
    np.testing.assert_allclose(r.c["reference_velocity_enu_mps"], (1.0, -0.5, 0.0), atol=0.02)
    assert r.c["reference_position_enu_m"][2] == pytest.approx(3.0, abs=0.03)


def test_nothing_at_all_brakes():
    r = Follower().follow(2.0, velocity_enu_mps=(3.0, 0.0, 0.0)).follow(4.0)
    np.testing.assert_allclose(r.c["reference_velocity_enu_mps"], 0.0, atol=0.01)


def test_acceleration_alone_frees_its_axis():
    r = Follower().follow(
        0.1, velocity_enu_mps=(NAN, 0.0, 0.0), acceleration_enu_mps2=(1.5, NAN, NAN)
    )
    np.testing.assert_array_equal(r.c["is_free"], (1, 0, 0))
    assert r.c["reference_acceleration_enu_mps2"][0] == 1.5


def circle(t, radius=2.0, w=0.5):
    """Starts from rest: the angle grows smoothly."""
    s, ds, dds = (t - math.sin(t)) * w, (1.0 - math.cos(t)) * w, math.sin(t) * w
    ddds = math.cos(t) * w
    x, y = math.cos(s), math.sin(s)
    position = np.array([x - 1.0, y, 0.0]) * radius
    velocity = np.array([-y, x, 0.0]) * ds * radius
    acceleration = (np.array([-x, -y, 0.0]) * ds**2 + np.array([-y, x, 0.0]) * dds) * radius
    jerk = (
        np.array([y, -x, 0.0]) * ds**3
        + 3.0 * np.array([-x, -y, 0.0]) * ds * dds
        + np.array([-y, x, 0.0]) * ddds
    ) * radius
    return position, velocity, acceleration, jerk


def circle_setpoint(t, *, jerk):
    p, v, a, j = (tuple(map(float, x)) for x in circle(t))
    return {
        "position_enu_m": p,
        "velocity_enu_mps": v,
        "acceleration_enu_mps2": a,
        "jerk_enu_mps3": j if jerk else (NAN, NAN, NAN),
    }


def test_a_trajectory_is_carried_on_between_its_points():
    r = Follower().follow(6.0, at=lambda t: circle_setpoint(t, jerk=True))
    for k in range(3, 1500, 7):
        p, v, _, _ = circle(k * DT)
        np.testing.assert_allclose(r.rows[k]["reference_position_enu_m"], p, atol=2e-5)
        np.testing.assert_allclose(r.rows[k]["reference_velocity_enu_mps"], v, atol=2e-3)
    assert r.c["is_direct"] == 1


def test_a_missing_jerk_is_derived_from_the_accelerations():
    r = Follower().follow(6.0, at=lambda t: circle_setpoint(t, jerk=False))
    for k in range(50, 1500, 5):
        j = circle(k * DT - 0.01)[3]
        np.testing.assert_allclose(r.rows[k]["reference_jerk_enu_mps3"], j, atol=0.1)


def test_a_missing_acceleration_is_derived_from_the_velocities():
    def at(t):
        return circle_setpoint(t, jerk=False) | {"acceleration_enu_mps2": (NAN, NAN, NAN)}

    r = Follower().follow(6.0, at=at)
    for k in range(50, 1500, 5):
        a = circle(k * DT - 0.01)[2]
        np.testing.assert_allclose(r.rows[k]["reference_acceleration_enu_mps2"], a, atol=0.05)


def test_a_slow_stream_is_as_smooth_as_a_fast_one():
    r = Follower().follow(6.0, every=25, at=lambda t: circle_setpoint(t, jerk=True))
    for k in range(30, 1500, 7):
        np.testing.assert_allclose(
            r.rows[k]["reference_position_enu_m"], circle(k * DT)[0], atol=1e-3
        )


def test_a_setpoint_said_again_is_no_new_one():
    """A trajectory that stops coming stands still soon, however often its last point is sent."""
    r = Follower().follow(2.0, at=lambda t: circle_setpoint(t, jerk=True))
    last = circle_setpoint(2.0 - 0.02, jerk=True)
    r.follow(1.0, **last)
    p = r.column("reference_position_enu_m")[-180:]
    assert np.ptp(p, axis=0).max() < 1e-12
    np.testing.assert_array_equal(r.c["reference_velocity_enu_mps"], 0.0)


def test_a_far_trajectory_point_is_approached_and_then_followed():
    def ahead(t):
        setpoint = circle_setpoint(t, jerk=True)
        x, y, z = setpoint["position_enu_m"]
        return setpoint | {"position_enu_m": (x, y + 6.0, z)}

    r = Follower().follow(9.0, at=ahead)
    assert r.rows[10]["is_direct"] == 0
    assert r.c["is_direct"] == 1
    a = r.column("reference_acceleration_enu_mps2")[:250]
    assert np.hypot(a[:, 0], a[:, 1]).max() <= r.c["max_acceleration_mps2"] * (1.0 + 1e-6)


def test_reference_waits_for_a_vehicle_that_stands_on_the_ground():
    r = Follower(is_stuck=True).follow(5.0, velocity_enu_mps=(1.0, 0.0, -0.5))
    leash = r.c["leash_m"]
    np.testing.assert_allclose(
        r.c["reference_position_enu_m"], (leash, 0.0, -0.5 * leash), atol=1e-9
    )


@settings(max_examples=10)
@given(st.floats(-3.14, 3.14))
def test_yaw_turns_the_short_way_within_its_limits(yaw):
    r = Follower().follow(6.0, position_enu_m=(0.0, 0.0, 0.0), yaw_rad=yaw)
    rate = r.column("reference_yaw_rate_radps")
    turned = np.cumsum(rate) * DT
    assert np.abs(rate).max() <= r.c["max_yaw_rate_radps"] + 1e-9
    assert np.abs(np.diff(rate)).max() <= r.c["max_yaw_acceleration_radps2"] * DT + 1e-9
    assert turned[-1] == pytest.approx(yaw, abs=0.01)
    assert np.abs(turned).max() <= abs(yaw) + 0.05


def test_yaw_rate_alone_turns_on_and_zero_holds():
    r = Follower().follow(3.0, velocity_enu_mps=(0.0, 0.0, 0.0), yaw_rate_radps=0.5)
    assert r.c["reference_yaw_rad"] == pytest.approx(1.5, abs=0.1)
    held = r.c["reference_yaw_rad"]
    r.follow(2.0, velocity_enu_mps=(0.0, 0.0, 0.0))
    assert r.c["reference_yaw_rad"] == pytest.approx(held, abs=0.1)
    assert r.c["reference_yaw_rate_radps"] == 0.0


def test_a_far_setpoint_is_approached_however_fast_it_moves():
    """A stream that circles at twice the speed limit draws the reference to its middle."""

    def at(t):
        s = 1.2 * t
        x, y = 20.0 * math.cos(s), 20.0 * math.sin(s)
        return {
            "position_enu_m": (60.0 + x, y, 0.0),
            "velocity_enu_mps": (-1.2 * y, 1.2 * x, 0.0),
        }

    r = Follower().follow(25.0, at=at)
    p = r.column("reference_position_enu_m")[-1500:]
    assert np.hypot(p[:, 0] - 60.0, p[:, 1]).max() < 25.0
    v = r.column("reference_velocity_enu_mps")
    assert np.hypot(v[:, 0], v[:, 1]).max() < r.c["max_speed_mps"] * 1.05


def test_where_a_trajectory_ends_its_acceleration_falls_to_the_limit_at_once():
    r = Follower().follow(
        0.02,
        position_enu_m=(0.0, 0.0, 0.0),
        velocity_enu_mps=(0.0, 0.0, 0.0),
        acceleration_enu_mps2=(6.0, -8.0, 9.0),
    )
    assert r.c["is_direct"] == 1
    r.follow(0.02, position_enu_m=(0.0, 0.0, 0.0))
    a = r.rows[5]["reference_acceleration_enu_mps2"]
    assert np.hypot(a[0], a[1]) <= r.c["max_acceleration_mps2"] * (1.0 + 1e-6)
    assert abs(a[2]) <= r.c["max_acceleration_vertical_mps2"] * (1.0 + 1e-6)
