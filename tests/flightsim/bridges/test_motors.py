"""Rotor order, directions and thrust curve against what PX4 and ArduPilot expect."""

import math

import numpy as np
import pytest

from flightsim.bridges.launch.ardupilot import parameter_file, parameters
from flightsim.bridges.motors import MotorMap
from flightsim.vehicles.catalogue import AIRFRAMES

QUADROTORS = [name for name, a in AIRFRAMES.items() if len(a.quadrotor.rotors) == 4]
CCW, CW = 1, -1
# Bearing clockwise from the nose, and direction from above, of the motors 1 to 4.
X_FRAME = ((45, CCW), (-135, CCW), (-45, CW), (135, CW))
PLUS_FRAME = ((90, CCW), (-90, CCW), (0, CW), (180, CW))


@pytest.mark.parametrize("name", QUADROTORS)
def test_each_output_turns_the_rotor_that_both_stacks_mean(name):
    airframe = AIRFRAMES[name]
    motors = MotorMap(airframe)
    frame = PLUS_FRAME if parameters(airframe)["FRAME_TYPE"] == 0 else X_FRAME
    for k, (bearing_deg, spin) in enumerate(frame):
        outputs = tuple(float(i == k) for i in range(4))
        speeds = motors.rotor_speeds_radps(outputs)
        (turning,) = np.flatnonzero(speeds)
        rotor = airframe.quadrotor.rotors[turning]
        x, y, _ = rotor.position_flu_m
        off_deg = (math.degrees(math.atan2(-y, x)) - bearing_deg + 180) % 360 - 180
        assert abs(off_deg) < 20
        assert rotor.spin == spin
        assert speeds[turning] == pytest.approx(rotor.max_speed_radps)


def test_outputs_off_are_no_power_and_others_stay_in_range():
    motors = MotorMap(AIRFRAMES["iris"])
    assert motors.rotor_speeds_radps((0.0, -1.0, 0.0, 0.0)) is None
    assert motors.rotor_speeds_radps((2.0, -1.0, 0.0, 0.0)) == pytest.approx((1100.0, 0, 0, 0))


@pytest.mark.parametrize("name", QUADROTORS)
def test_the_thrust_curve_of_ardupilot_makes_our_thrust_linear(name):
    airframe = AIRFRAMES[name]
    p = parameters(airframe)
    motors, expo, least = MotorMap(airframe), p["MOT_THST_EXPO"], p["MOT_SPIN_MIN"]
    asked = np.linspace(0.0, 1.0, 11)
    # ArduCopter's inverse of thrust = (1 - expo) u + expo u^2, then its range of outputs.
    curve = (np.sqrt((1 - expo) ** 2 + 4 * expo * asked) - (1 - expo)) / (2 * expo)
    made = []
    for u in least + (p["MOT_SPIN_MAX"] - least) * curve:
        speeds = motors.rotor_speeds_radps((u,) * 4)
        rotors = airframe.quadrotor.rotors
        made.append(
            sum(r.thrust_constant * w**2 for r, w in zip(rotors, speeds, strict=True))
            / airframe.quadrotor.max_thrust_n
        )
    assert made == pytest.approx(made[0] + (1.0 - made[0]) * asked)
    # Where it believes that it hovers, our rotors carry our weight.
    at_hover = np.interp(p["MOT_THST_HOVER"], asked, made)
    assert at_hover == pytest.approx(airframe.quadrotor.hover_thrust_fraction, rel=1e-3)


@pytest.mark.parametrize("name", QUADROTORS)
def test_a_parameter_file_names_each_parameter_once_with_a_number(name):
    lines = [line.split() for line in parameter_file(AIRFRAMES[name]).splitlines()]
    rows = [line for line in lines if line and line[0] != "#"]
    assert all(len(row) == 2 and math.isfinite(float(row[1])) for row in rows)
    assert len({row[0] for row in rows}) == len(rows) > 20
