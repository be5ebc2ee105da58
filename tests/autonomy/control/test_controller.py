"""The controller as a whole: levels, and nothing but sound commands to the rotors."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from autonomy.control import SETPOINT_DTYPE
from autonomy.control.cfg import controller_cfg_for
from autonomy.control.controller import control
from autonomy.control.record import setpoint_row
from autonomy.types import IDLE, OFF, ControlLevel, Setpoint
from tests.autonomy.sample_quadrotors import HOVER, IRIS, hovering

NAN = math.nan
anything = st.one_of(st.just(NAN), st.just(math.inf), st.floats(-1e3, 1e3))
triples = st.tuples(anything, anything, anything)


def run(c, f, setpoint, ticks=1):
    records = np.zeros(1, SETPOINT_DTYPE)
    records.view("f8")[:] = setpoint_row(setpoint)
    for k in range(ticks):
        control(c, records[0], f, k == 0)
    return c["rotor_command_radps"][:4].copy()


def test_off_stops_and_idle_idles():
    c, f = hovering()
    np.testing.assert_array_equal(run(c, f, OFF), 0.0)
    np.testing.assert_array_equal(run(c, f, IDLE), c["idle_speed_radps"][:4])
    assert c["thrust_fraction"] == 0.0


def test_holding_still_commands_hover_speed():
    c, f = hovering()
    command = run(
        c, f, Setpoint(level=ControlLevel.TRAJECTORY, velocity_enu_mps=(0.0, 0.0, 0.0)), 5
    )
    np.testing.assert_allclose(command, HOVER, rtol=0.1)
    made = np.sum(c["rotor_thrust_n"])
    assert made == pytest.approx(IRIS.mass_kg * 9.81, rel=1e-6)
    assert c["thrust_fraction"] == pytest.approx(IRIS.hover_thrust_fraction, rel=1e-6)


@given(triples, triples, triples, triples, anything, anything)
def test_no_trajectory_setpoint_makes_an_unsound_command(p, v, a, j, yaw, yaw_rate):
    c, f = hovering()
    setpoint = Setpoint(
        level=ControlLevel.TRAJECTORY,
        position_enu_m=p,
        velocity_enu_mps=v,
        acceleration_enu_mps2=a,
        jerk_enu_mps3=j,
        yaw_rad=yaw,
        yaw_rate_radps=yaw_rate,
    )
    for ticks in (1, 7):
        command = run(c, f, setpoint, ticks)
        assert np.all(command >= c["idle_speed_radps"][:4])
        assert np.all(command <= c["max_rotor_speed_radps"][:4])
        assert np.all(np.isfinite(c["reference_position_enu_m"]))


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_rate_level_makes_torque_about_the_asked_axis(axis):
    c, f = hovering()
    rate = [0.0, 0.0, 0.0]
    rate[axis] = 0.3
    run(
        c,
        f,
        Setpoint(
            level=ControlLevel.RATE,
            angular_rate_flu_radps=tuple(rate),
            thrust=IRIS.hover_thrust_fraction,
        ),
    )
    torque = c["torque_flu_nm"]
    assert torque[axis] > 0.0
    assert np.abs(np.delete(torque, axis)).max() < 1e-12
    assert c["thrust_fraction"] == pytest.approx(IRIS.hover_thrust_fraction)


def test_attitude_level_turns_towards_the_quaternion():
    c, f = hovering()
    quat = (math.cos(0.1), 0.0, math.sin(0.1), 0.0)
    run(c, f, Setpoint(level=ControlLevel.ATTITUDE, quat_wxyz=quat, thrust=0.5))
    assert c["torque_flu_nm"][1] > 0.0
    assert abs(c["torque_flu_nm"][0]) < 1e-12


def test_every_return_to_trajectory_starts_from_where_the_vehicle_is():
    c, f = hovering()
    hold = Setpoint(level=ControlLevel.TRAJECTORY, velocity_enu_mps=(0.0, 0.0, 0.0))
    run(c, f, hold, 3)
    run(c, f, Setpoint(level=ControlLevel.RATE, thrust=0.5), 3)
    f["position_enu_m"] = (7.0, 8.0, 9.0)
    run(c, f, hold)
    np.testing.assert_allclose(c["reference_position_enu_m"], (7.0, 8.0, 9.0))


def test_default_gains_are_those_measured_for_the_iris():
    cfg = controller_cfg_for(IRIS)
    assert cfg.attitude_bandwidth_radps == pytest.approx(10.0, abs=0.1)
    assert cfg.position_bandwidth_radps == pytest.approx(4.0, abs=0.05)
    assert cfg.yaw_bandwidth_radps == 5.0
