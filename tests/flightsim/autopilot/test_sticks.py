"""A pilot at the sticks."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from autonomy.types import ControlLevel
from flightsim.autopilot.behaviours.manual import tilted
from flightsim.autopilot.modes import Mode
from flightsim.autopilot.parameters import Parameters
from flightsim.autopilot.streams import Sticks, StickStream, with_dead_zone
from tests.flightsim.autopilot.bench import Bench


def flying(mode):
    bench = Bench().take_off(8.0)
    bench.steer(0.2)
    assert bench.pilot.set_mode(mode).is_accepted
    return bench


def test_position_mode_takes_off_flies_and_lands_by_sticks():
    bench = Bench()
    bench.steer(0.2)
    assert bench.pilot.set_mode(Mode.POSITION).is_accepted
    assert bench.pilot.arm().is_accepted
    bench.steer(2.0)
    assert bench.pilot.setpoint.level is ControlLevel.IDLE
    bench.steer(4.0, throttle=0.8)
    assert bench.position[2] > 3.0
    bench.steer(3.0, pitch=0.5)
    assert bench.plant.truth.velocity_enu_mps[0] == pytest.approx(10.0 * 0.4 / 0.9, abs=0.5)
    bench.steer(4.0)
    there = bench.position
    bench.steer(3.0)
    assert bench.position == pytest.approx(there, abs=0.2)
    for _ in range(60):
        bench.steer(0.5, throttle=0.0)
        if not bench.pilot.is_armed:
            return
    pytest.fail("did not land")


@pytest.mark.parametrize(
    ("stick", "sign", "axis"), [("pitch", 1.0, 0), ("roll", -1.0, 1), ("roll", 1.0, 1)]
)
def test_sticks_move_the_vehicle_in_its_own_axes(stick, sign, axis):
    bench = flying(Mode.POSITION)
    bench.steer(2.5, **{stick: sign * 0.4})
    velocity = bench.plant.truth.velocity_enu_mps
    expected = sign if stick == "pitch" else -sign
    assert velocity[axis] * expected > 2.0
    assert abs(velocity[1 - axis]) < 0.3


def test_yaw_turns_clockwise():
    bench = flying(Mode.POSITION)
    bench.steer(1.0, yaw=0.5)
    assert -2.0 < bench.yaw_rad < -0.4


def test_altitude_mode_tilts_and_keeps_the_height():
    bench = flying(Mode.ALTITUDE)
    bench.steer(2.0, pitch=0.4)
    assert bench.plant.truth.velocity_enu_mps[0] > 2.0
    assert bench.position[2] == pytest.approx(8.0, abs=0.5)
    bench.steer(2.0)
    assert bench.plant.truth.velocity_enu_mps[0] > 1.0, "it drifts on: nobody brakes"


def test_from_altitude_mode_the_hold_begins_where_the_vehicle_is():
    bench = flying(Mode.ALTITUDE)
    bench.steer(2.0, pitch=0.4)
    x = bench.position[0]
    assert x > 2.0
    assert bench.pilot.set_mode(Mode.HOLD).is_accepted
    bench.steer(5.0)
    assert bench.position[0] > x
    assert bench.speed_mps < 0.2


def test_manual_mode_commands_tilt_and_thrust():
    bench = flying(Mode.STABILIZED)
    bench.steer(1.0, roll=0.3)
    assert bench.pilot.setpoint.level is ControlLevel.ATTITUDE
    assert bench.plant.truth.velocity_enu_mps[1] < -1.0
    height = bench.position[2]
    bench.steer(1.0, throttle=0.7)
    assert bench.position[2] > height + 0.5


def test_acro_mode_commands_rates():
    bench = flying(Mode.ACRO)
    bench.steer(0.3, pitch=0.5)
    assert bench.pilot.setpoint.level is ControlLevel.RATE
    assert bench.plant.truth.angular_rate_flu_radps[1] == pytest.approx(math.radians(50.0), abs=0.3)


def test_arming_in_manual_mode_wants_the_throttle_down():
    bench = Bench()
    bench.steer(0.2, throttle=0.5)
    assert bench.pilot.set_mode(Mode.STABILIZED).is_accepted
    assert bench.pilot.arm().reason == "arming denied: throttle is not down"
    bench.steer(0.2, throttle=0.0)
    assert bench.pilot.arm().is_accepted
    bench.steer(1.5, throttle=0.0)
    assert bench.pilot.setpoint.level is ControlLevel.IDLE


def test_moving_the_sticks_takes_over_from_automatic_flight():
    bench = Bench().take_off()
    bench.pilot.goto(bench.geodetic(30.0, 0.0))
    bench.steer(1.0)
    assert bench.pilot.mode is Mode.HOLD
    bench.steer(0.5, roll=0.5)
    assert bench.pilot.mode is Mode.POSITION
    assert bench.says("Pilot took over using sticks")


def test_taking_over_can_be_forbidden():
    bench = Bench(initial_parameters={"COM_RC_OVERRIDE": 0}).take_off()
    bench.steer(1.0, roll=0.9)
    assert bench.pilot.mode is Mode.HOLD


def test_sticks_can_be_switched_off_and_nonsense_is_ignored():
    bench = Bench(initial_parameters={"COM_RC_IN_MODE": 4}).take_off()
    bench.steer(1.0, roll=0.9)
    assert bench.pilot.mode is Mode.HOLD
    other = Bench().take_off()
    other.pilot.set_manual_control(pitch=math.nan, roll=9.0, throttle=0.5, yaw=0.0)
    other.run(1.0)
    assert other.pilot.mode is Mode.HOLD


def test_a_stream_that_stops_reads_as_centred():
    stream = StickStream(Parameters())
    stream.receive(Sticks(pitch=1.0), 1_000_000)
    assert stream.current(1_400_000).pitch == 1.0
    assert stream.current(1_600_000) == Sticks()


@given(st.floats(-1.0, 1.0), st.floats(0.0, 0.9))
def test_a_dead_zone_is_odd_and_reaches_the_ends(deflection, dead_zone):
    value = with_dead_zone(deflection, dead_zone)
    assert value == -with_dead_zone(-deflection, dead_zone)
    assert abs(value) <= abs(deflection) + 1e-9
    assert with_dead_zone(1.0, dead_zone) == pytest.approx(1.0)


@given(st.floats(-0.6, 0.6), st.floats(-0.6, 0.6), st.floats(-3.1, 3.1))
def test_the_commanded_attitude_is_a_rotation_tilted_no_more_than_allowed(pitch, roll, yaw):
    w, x, y, z = tilted(pitch, roll, yaw, 0.6)
    assert w * w + x * x + y * y + z * z == pytest.approx(1.0)
    tilt = math.acos(max(-1.0, min(1.0, 1.0 - 2.0 * (x * x + y * y))))
    assert tilt == pytest.approx(min(0.6, math.hypot(pitch, roll)), abs=1e-6)
    # The vehicle's thrust axis leans forward and right as seen along the heading.
    lean_east, lean_north = 2.0 * (x * z + w * y), 2.0 * (y * z - w * x)
    forward = lean_east * math.cos(yaw) + lean_north * math.sin(yaw)
    right = lean_east * math.sin(yaw) - lean_north * math.cos(yaw)
    assert forward * pitch >= -1e-9
    assert right * roll >= -1e-9
