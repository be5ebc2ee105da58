"""The way begins while the vehicle still climbs, or above the start where it must look first."""

import math

from autonomy.planning import UnreachableError
from scenarios.pilot import Phase
from scenarios.pilot.flight_state import SET_OUT_M
from tests.scenarios.landing_scenes import yard


def up_mps(flight):
    return flight.telemetry.velocity_enu_mps[2]


def test_it_leaves_the_climb_from_where_it_is_at_the_speed_it_has(demo):
    demo = demo(yard())
    flight = demo.fly_to(Phase.NAVIGATE)._flight
    height_m = flight.telemetry.position_enu_m[2] - flight.home_resting_height_m
    assert SET_OUT_M <= height_m < SET_OUT_M + 0.1
    assert up_mps(flight) > 1.0
    begin_us = flight.take_over_us
    demo.fly(until=lambda: flight.time_us >= begin_us)
    assert math.dist(flight.telemetry.position_enu_m, flight.setpoint.position_enu_m) < 0.1
    assert abs(up_mps(flight) - flight.setpoint.velocity_enu_mps[2]) < 0.2


def test_among_movers_it_rises_and_looks_round_first(demo):
    demo = demo(yard(), expects_traffic=True)
    flight = demo.fly_to(Phase.NAVIGATE)._flight
    assert abs(up_mps(flight)) < 0.2
    assert flight.telemetry.position_enu_m[2] > flight.mission.takeoff_enu_m[2] - 0.3


def test_where_no_way_leads_on_from_the_climb_it_takes_the_one_from_above_the_start(
    demo, monkeypatch
):
    demo = demo(yard())
    asked = []

    def plan(_, start, goal_enu_m):
        asked.append(start)
        raise UnreachableError("there is no way")

    demo.fly_to(Phase.TAKEOFF)
    monkeypatch.setattr(type(demo.mission.surroundings), "plan", plan)
    pilot = demo.fly_to(Phase.NAVIGATE)
    assert len(asked) == 1  # Once, not in each tick of the climb.
    assert asked[0].velocity_enu_mps[2] > 1.0
    assert pilot.trajectory is demo.mission.trajectory
    assert demo.reason(Phase.NAVIGATE) == "above the start"
