"""How well a vehicle follows is learned in flight, and the pilot's limits come from it."""

import dataclasses
import math

import pytest

from autonomy.planning import FlightLimits, plan_leg
from flightsim.vehicles.catalogue import AIRFRAMES
from scenarios.pilot import Phase
from scenarios.pilot.course import AT_PLACE_M, AT_REST_MPS
from scenarios.pilot.final_descent import (
    STEADY_IN_WIND_M,
    STEADY_IN_WIND_MPS,
    STEADY_M,
    STEADY_MPS,
    steady_within,
)
from scenarios.pilot.guard import LEAST_DEVIATION_M, MOST_DEVIATION_M, deviation_limit_m
from scenarios.pilot.pace import IN_WIND, USUAL
from scenarios.pilot.tracking_statistics import (
    MOST_AWAY_M,
    MOST_DRIFT_MPS,
    MOST_STRAY_M,
    SETTLING_US,
    TrackingStatistics,
)
from tests.scenarios.landing_scenes import yard

TICK_US = 20_000
USUAL_PLACE = (AT_PLACE_M, AT_REST_MPS)
SWAY_M, SWAY_RADPS = 0.28, 1.2


def heard(seconds, away_m, drift_mps=0.0, *, is_resting=True, before=None):
    """What was learned of some time in which the vehicle was so far from its setpoint."""
    tracking, begun_us = before if before is not None else (TrackingStatistics(), 0)
    for tick in range(round(seconds * 1e6) // TICK_US):
        tracking.update(begun_us + tick * TICK_US, away_m, drift_mps, is_resting=is_resting)
    return tracking


def test_nothing_is_learned_of_the_time_in_which_it_still_brakes():
    assert TrackingStatistics().at_place == USUAL_PLACE
    assert heard(SETTLING_US * 1e-6, 0.4, 0.4).at_place == USUAL_PLACE
    assert heard(30.0, 0.4, 0.4, is_resting=False).at_place == USUAL_PLACE


def test_what_it_keeps_as_it_hovers_counts_as_being_there():
    assert heard(3.0, 0.4, 0.3).at_place == (0.4, 0.3)
    assert heard(3.0, 0.1, 0.1).at_place == USUAL_PLACE
    assert heard(3.0, 5.7, 2.0).at_place == (MOST_AWAY_M, MOST_DRIFT_MPS)


def test_it_forgets_what_was_long_ago():
    tracking = heard(12.0, 0.4, 0.3)
    assert heard(9.0, 0.1, before=(tracking, 12_000_000)).at_place == USUAL_PLACE
    assert tracking.stray_m == pytest.approx(0.125)


def test_the_allowed_deviation_grows_with_what_it_strays():
    narrow = plan_leg((0, 0, 1), (4, 0, 1), 0.0, FlightLimits(), AIRFRAMES["iris"].quadrotor)
    narrow = dataclasses.replace(narrow, min_clearance_m=0.2)
    limit_m = [deviation_limit_m(narrow, heard(2.0, m).stray_m) for m in (0.0, 0.3, 0.58, 5.0)]
    assert limit_m[:2] == [LEAST_DEVIATION_M] * 2
    assert 0.58 < limit_m[2] < MOST_DEVIATION_M
    assert limit_m[3] == MOST_DEVIATION_M == MOST_STRAY_M


def test_it_sinks_within_what_it_keeps_but_never_beyond_what_wind_allows():
    assert steady_within(TrackingStatistics()) == (STEADY_M, STEADY_MPS)
    assert steady_within(heard(3.0, 0.2, 0.4)) == (0.2, 0.4)
    assert steady_within(heard(3.0, 0.45, 0.6)) == (STEADY_IN_WIND_M, STEADY_IN_WIND_MPS)


def test_plans_keep_as_far_from_obstacles_as_it_strays_and_are_slower(demo):
    flight = demo(yard()).fly_to(Phase.NAVIGATE)._flight
    assert flight.tracking.stray_m < LEAST_DEVIATION_M
    usual = flight.mission.surroundings.planner.margins_m
    flight.tracking = heard(2.0, 0.58)
    flight.learn_following()
    assert flight.mission.surroundings.planner.margins_m == (pytest.approx(0.8), *usual)
    assert flight.pace == IN_WIND != USUAL
    assert flight.mission.surroundings.limits == IN_WIND.limits
    flight.tracking = TrackingStatistics()
    flight.learn_following()
    assert flight.mission.surroundings.planner.margins_m[0] == pytest.approx(0.8)


def test_a_vehicle_that_circles_its_setpoint_lands(demo):
    demo = demo(yard())
    flight = demo.pilot._flight
    send = flight.client.send_setpoint

    def sway(setpoint):
        """Lead the vehicle around the setpoint, which it is therefore always beside."""
        x, y, z = setpoint.position_enu_m
        angle = SWAY_RADPS * flight.time_us * 1e-6
        aside = SWAY_M * math.cos(angle), SWAY_M * math.sin(angle)
        is_up = flight.is_clear and demo.pilot.phase is not Phase.DISARM
        place = (x + aside[0], y + aside[1], z) if is_up else (x, y, z)
        send(dataclasses.replace(setpoint, position_enu_m=place))

    flight.client.send_setpoint = sway
    pilot = demo.fly()
    assert pilot.verdict.success, pilot.verdict.reason
    assert Phase.RETURN not in demo.targets()
    keeps_m, keeps_mps = flight.tracking.keeps
    assert AT_PLACE_M < keeps_m < 0.4
    assert keeps_mps > AT_REST_MPS
    assert demo.score().touchdown_error_m < 0.5


def test_a_vehicle_that_lifts_off_late_is_not_stopped_before_it_has_risen(demo, monkeypatch):
    demo = demo(yard())
    pilot = demo.fly_to(Phase.TAKEOFF)
    flight, guard = pilot._flight, pilot._guard
    flight.time_us += 10_000_000  # The plan of the climb is over.
    x, y, top_m = flight.setpoint.position_enu_m
    # At the ground no straight way is free.
    monkeypatch.setattr(guard, "_is_free_between", lambda *_: False)
    for z, is_stopped in ((flight.home_resting_height_m + 0.1, False), (top_m, True)):
        flight.senses.telemetry = dataclasses.replace(
            flight.telemetry, position_enu_m=(x + 1.2, y, z)
        )
        assert (guard._deviation(Phase.TAKEOFF) is not None) is is_stopped


def test_a_hold_goes_on_within_what_the_vehicle_keeps(demo, monkeypatch):
    demo = demo(yard())
    pilot = demo.fly_to(Phase.NAVIGATE)
    flight, guard = pilot._flight, pilot._guard
    monkeypatch.setattr(guard, "_is_free_between", lambda *_: False)
    flight.time_us += 60_000_000
    flight.course.trajectory = dataclasses.replace(flight.course.trajectory, min_clearance_m=0.2)
    x, y, z = flight.setpoint.position_enu_m
    flight.senses.telemetry = dataclasses.replace(
        flight.telemetry, position_enu_m=(x + 0.58, y, z), velocity_enu_mps=(0.0, 0.0, 0.0)
    )
    flight.tracking = heard(2.0, 0.58)
    assert guard._deviation(Phase.HOLD) is None
    assert not flight.replans
    flight.tracking = TrackingStatistics()
    guard._deviation(Phase.HOLD)
    assert "0.58 m from the plan, 0.50 m are allowed" in flight.replans[-1].reason
