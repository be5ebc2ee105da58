"""The last stretch in wind: down where it is carried to, up where it blows, and down for good."""

import dataclasses
import math

import pytest

from scenarios.pilot import Phase
from scenarios.pilot.final_descent import (
    COMMIT_HEIGHTS_M,
    LAST_HEIGHT_M,
    MOST_TILT_RAD,
    MOST_WIND_MPS,
    FinalDescent,
)
from scenarios.pilot.flight_state import FlightState
from tests.scenarios.landing_scenes import yard


@pytest.fixture
def low(demo):
    """A flight that has just begun its last stretch."""
    flight = demo(yard()).fly_to(Phase.TOUCHDOWN)._flight
    flight.is_windy = True
    return flight


def be_at(flight, *, aside_m=0.0, height_m=0.5, speed_mps=0.0, wind_mps=8.0, tilt_rad=0.0):
    """Put the vehicle aside of the chosen place, at a height above that where it rests."""
    x, y, _ = flight.chosen.position_enu_m
    flight.senses.telemetry = dataclasses.replace(
        flight.telemetry,
        position_enu_m=(x + aside_m, y, flight.resting_height_m + height_m),
        velocity_enu_mps=(speed_mps, 0.0, 0.0),
        wind_mps=wind_mps,
        quat_wxyz=(math.cos(tilt_rad / 2), math.sin(tilt_rad / 2), 0.0, 0.0),
    )


def stay(flight, seconds):
    """Let the stretch decide for a while, wherever the vehicle was put; return the last step."""
    stretch, step = FinalDescent(flight), None
    for _ in range(round(seconds * 50)):
        flight.time_us += 20_000
        step = step or stretch.touch_down()
    return step


def test_pushed_down_to_the_ground_it_waits_no_longer(low):
    be_at(low, height_m=LAST_HEIGHT_M - 0.05, speed_mps=0.8)
    assert low.setpoint.position_enu_m[2] - low.resting_height_m > 0.5
    assert stay(low, 0.02) is None
    above_m = low.setpoint.position_enu_m[2] - low.resting_height_m
    assert above_m == pytest.approx(LAST_HEIGHT_M - 0.05, abs=0.02)
    stay(low, 1.0)
    assert low.setpoint.position_enu_m[2] < low.resting_height_m


def test_hanging_aside_in_wind_it_chooses_the_place_below(low):
    x, y, _ = low.chosen.position_enu_m
    be_at(low, aside_m=0.35)
    assert stay(low, 0.1) is None
    assert low.chosen.position_enu_m[:2] == pytest.approx((x + 0.35, y))
    assert low.setpoint.position_enu_m[:2] == pytest.approx((x + 0.35, y))


def test_carried_to_where_it_cannot_stand_it_climbs_back(low):
    before = low.chosen
    be_at(low, aside_m=3.0)
    assert stay(low, 0.1)[0] is Phase.CLIMB
    assert low.chosen == before


def test_without_wind_it_goes_to_the_place_that_it_chose(low):
    low.is_windy, before = False, low.chosen
    be_at(low, aside_m=0.35)
    assert stay(low, 0.5) is None
    assert low.chosen == before


@pytest.mark.parametrize(
    "blow", [{"wind_mps": MOST_WIND_MPS + 1.0}, {"tilt_rad": MOST_TILT_RAD + 0.1}]
)
def test_where_it_blows_it_waits_at_the_height_of_the_commitment(low, blow):
    stay(low, 0.8)
    be_at(low, **blow)
    z_m = low.setpoint.position_enu_m[2]
    assert z_m < low.resting_height_m + COMMIT_HEIGHTS_M[0] - 0.1
    stay(low, 2.0)
    risen_m = low.setpoint.position_enu_m[2] - low.resting_height_m
    assert risen_m == pytest.approx(COMMIT_HEIGHTS_M[0])
    be_at(low)
    stay(low, 1.0)
    assert low.setpoint.position_enu_m[2] - low.resting_height_m < risen_m - 0.2


def test_no_way_down_begins_while_a_gust_has_carried_it_off(demo, monkeypatch):
    demo = demo(yard())
    demo.fly_to(Phase.SEARCH)
    with monkeypatch.context() as gust:
        gust.setattr(FlightState, "level_deviation_m", property(lambda _: 0.6))
        begun_us = demo.bench.plant.time_us
        demo.fly(until=lambda: demo.bench.plant.time_us - begun_us > 6e6)
        assert demo.pilot.phase is Phase.SEARCH
    demo.fly()
    assert demo.pilot.verdict.success
    assert math.isfinite(demo.pilot.verdict.touchdown_error_m)
