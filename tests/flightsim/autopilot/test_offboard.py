"""Offboard: entering, following each kind of setpoint, landing by it."""

import math

import pytest

from autonomy.types import NAN3, ControlLevel, Setpoint
from flightsim.autopilot.modes import Mode
from tests.flightsim.autopilot.bench import NAN, Bench


def position(x, y, z, yaw_rad=0.0):
    return Setpoint(level=ControlLevel.TRAJECTORY, position_enu_m=(x, y, z + 0.11), yaw_rad=yaw_rad)


def velocity(x, y, z, **fields):
    return Setpoint(level=ControlLevel.TRAJECTORY, velocity_enu_mps=(x, y, z), **fields)


def flying():
    bench = Bench().take_off()
    bench.pilot.set_offboard_setpoint(position(0.0, 0.0, 3.0))
    assert bench.pilot.set_mode(Mode.OFFBOARD).is_accepted
    return bench


def test_one_fresh_setpoint_opens_the_door_a_stale_one_does_not():
    bench = Bench().take_off()
    bench.pilot.set_offboard_setpoint(position(0.0, 0.0, 3.0))
    bench.run(0.6)
    assert not bench.pilot.set_mode(Mode.OFFBOARD).is_accepted
    bench.pilot.set_offboard_setpoint(position(0.0, 0.0, 3.0))
    assert bench.pilot.set_mode(Mode.OFFBOARD).is_accepted


def test_a_position_above_takes_off_and_one_below_does_not():
    bench = Bench()
    bench.pilot.arm()
    bench.pilot.set_offboard_setpoint(position(0.0, 0.0, -0.2))
    assert bench.pilot.set_mode(Mode.OFFBOARD).is_accepted
    bench.stream(position(0.0, 0.0, -0.2), 3.0)
    assert bench.pilot.setpoint.level is ControlLevel.IDLE
    bench.stream(position(0.0, 0.0, 4.0), 8.0)
    assert bench.position == pytest.approx((0.0, 0.0, 4.0), abs=0.4)


def test_positions_and_yaw_are_reached():
    bench = flying()
    bench.stream(position(6.0, -4.0, 5.0, yaw_rad=1.2), 9.0)
    assert bench.position == pytest.approx((6.0, -4.0, 5.0), abs=0.4)
    assert bench.yaw_rad == pytest.approx(1.2, abs=0.1)


def test_velocities_are_followed():
    bench = flying()
    bench.stream(velocity(0.0, 3.0, 0.5), 4.0)
    assert bench.plant.truth.velocity_enu_mps == pytest.approx((0.0, 3.0, 0.5), abs=0.25)


def test_mixed_axes_are_followed():
    bench = flying()
    mixed = Setpoint(
        level=ControlLevel.TRAJECTORY,
        position_enu_m=(NAN, NAN, 5.11),
        velocity_enu_mps=(2.0, 0.0, NAN),
    )
    bench.stream(mixed, 6.0)
    assert bench.plant.truth.velocity_enu_mps == pytest.approx((2.0, 0.0, 0.0), abs=0.25)
    assert bench.position[2] == pytest.approx(5.0, abs=0.4)


def test_bare_velocities_are_held_to_the_vehicle_maxima():
    bench = flying()
    bench.pilot.parameters.set("MPC_XY_VEL_MAX", 4.0)
    bench.stream(velocity(30.0, 40.0, 0.0), 3.0)
    assert bench.pilot.setpoint.velocity_enu_mps == pytest.approx((2.4, 3.2, 0.0))
    assert bench.speed_mps < 4.5


def test_attitude_setpoints_pass_through():
    bench = flying()
    hover = bench.plant.world.airframe.quadrotor.hover_thrust_fraction
    tilt = math.radians(8.0)
    setpoint = Setpoint(
        level=ControlLevel.ATTITUDE,
        quat_wxyz=(math.cos(tilt / 2), 0.0, math.sin(tilt / 2), 0.0),
        thrust=hover / math.cos(tilt),
    )
    bench.stream(setpoint, 1.5)
    assert bench.plant.truth.velocity_enu_mps[0] > 1.0


def test_a_descent_into_the_ground_lands_and_disarms():
    bench = flying()
    sinking = velocity(0.0, 0.0, -0.5)
    assert bench.stream(sinking, 25.0, lambda: not bench.pilot.is_armed)
    assert bench.says("Landing detected")
    assert bench.says("Disarmed by landing")
    assert bench.position[2] == pytest.approx(0.0, abs=0.05)


def test_a_setpoint_without_any_number_holds():
    bench = flying()
    nothing = Setpoint(level=ControlLevel.TRAJECTORY, position_enu_m=NAN3)
    bench.stream(nothing, 3.0)
    assert bench.pilot.mode is Mode.OFFBOARD
    assert bench.position == pytest.approx((0.0, 0.0, 3.0), abs=0.5)


def test_leaving_offboard_at_speed_is_smooth():
    bench = flying()
    bench.stream(velocity(5.0, 0.0, 0.0), 4.0)
    assert bench.pilot.set_mode(Mode.HOLD).is_accepted
    before = bench.plant.truth.velocity_enu_mps
    bench.step()
    assert bench.pilot.setpoint.velocity_enu_mps == pytest.approx(before, abs=0.4)
    bench.run(5.0)
    assert bench.speed_mps < 0.2


@pytest.mark.parametrize("vehicle", ["iris", "hummingbird"])
@pytest.mark.parametrize("gnss", ["rtk", "standard"])
def test_a_bare_position_below_the_ground_lands_without_dancing(vehicle, gnss):
    bench = Bench(vehicle, gnss=gnss, seed=1).take_off()
    x, y, z = bench.plant.estimate.position_enu_m
    below = position(x, y, z - 8.0)
    bench.pilot.set_offboard_setpoint(below)
    assert bench.pilot.set_mode(Mode.OFFBOARD).is_accepted
    climbs = []

    def send():
        bench.pilot.set_offboard_setpoint(below)
        climbs.append(bench.plant.truth.velocity_enu_mps[2])

    assert bench.run(30.0, lambda: not bench.pilot.is_armed, each=send)
    assert max(climbs) < 0.6


def test_going_up_again_after_touching_the_ground_flies_on():
    bench = flying()
    assert bench.stream(velocity(0.0, 0.0, -0.4), 20.0, lambda: bench.position[2] < 0.01)
    bench.stream(velocity(0.0, 0.0, -0.4), 0.4)
    assert bench.pilot.setpoint.level is ControlLevel.IDLE
    bench.stream(velocity(0.0, 0.0, 1.0), 3.0)
    assert bench.position[2] > 1.5
    assert bench.pilot.is_armed


def touching():
    """A vehicle that a companion has just set down, before the autopilot calls it landed."""
    bench = flying()
    assert bench.stream(velocity(0.0, 0.0, -0.4), 20.0, lambda: bench.position[2] < 0.01)
    bench.stream(velocity(0.0, 0.0, -0.4), 0.3)
    assert bench.pilot.setpoint.level is ControlLevel.IDLE
    assert not bench.is_on_ground
    return bench


def place_below(bench, up_mps):
    """A place below the vehicle, in a frame that drifts upwards against the vehicle's own."""
    x, y, z = bench.plant.estimate.position_enu_m
    return Setpoint(
        level=ControlLevel.TRAJECTORY,
        position_enu_m=(x, y, z - 0.4),
        velocity_enu_mps=(0.0, 0.0, up_mps),
        yaw_rad=0.0,
    )


def test_rotors_that_rest_stay_idle_while_the_place_below_drifts_upwards():
    bench = touching()
    n = len(bench.setpoints)
    bench.stream(place_below(bench, 0.16), 6.0, lambda: not bench.pilot.is_armed)
    assert bench.says("Disarmed by landing")
    assert all(setpoint.level <= ControlLevel.IDLE for setpoint in bench.setpoints[n:])


def test_rotors_that_rest_stay_idle_when_the_mode_changes():
    bench = touching()
    n = len(bench.setpoints)
    assert bench.pilot.set_mode(Mode.HOLD).is_accepted
    assert bench.run(6.0, lambda: not bench.pilot.is_armed)
    assert all(setpoint.level <= ControlLevel.IDLE for setpoint in bench.setpoints[n:])


def test_a_place_that_rises_past_the_vehicle_lifts_it():
    bench = touching()
    x, y, z = bench.plant.estimate.position_enu_m
    for k in range(200):
        rising = Setpoint(
            level=ControlLevel.TRAJECTORY,
            position_enu_m=(x, y, z - 0.4 + 0.01 * k),
            velocity_enu_mps=(0.0, 0.0, 0.5),
            yaw_rad=0.0,
        )
        bench.stream(rising, 0.02)
    assert bench.position[2] > 0.8


FREE_YAW = {"yaw_rad": NAN}


def test_a_heading_asked_for_is_turned_to_while_setpoints_leave_it_free():
    bench = flying()
    assert bench.pilot.set_yaw(2.0).is_accepted
    bench.stream(velocity(1.0, 0.0, 0.0, **FREE_YAW), 5.0)
    assert bench.yaw_rad == pytest.approx(2.0, abs=0.05)
    bench.stream(velocity(1.0, 0.0, 0.0, yaw_rad=0.5), 5.0)
    assert bench.yaw_rad == pytest.approx(0.5, abs=0.05)
    bench.stream(velocity(1.0, 0.0, 0.0, **FREE_YAW), 3.0)
    assert bench.yaw_rad == pytest.approx(0.5, abs=0.05)


def test_a_turn_begun_while_holding_goes_on_offboard():
    bench = Bench().take_off()
    assert bench.pilot.set_yaw(-2.0, rate_radps=0.5).is_accepted
    bench.run(0.2)
    bench.pilot.set_offboard_setpoint(velocity(0.0, 0.0, 0.0, **FREE_YAW))
    assert bench.pilot.set_mode(Mode.OFFBOARD).is_accepted
    bench.stream(velocity(0.0, 0.0, 0.0, **FREE_YAW), 1.0)
    assert abs(bench.yaw_rad + 2.0) > 0.5  # It keeps to the rate that was asked for.
    bench.stream(velocity(0.0, 0.0, 0.0, **FREE_YAW), 8.0)
    assert bench.yaw_rad == pytest.approx(-2.0, abs=0.05)
