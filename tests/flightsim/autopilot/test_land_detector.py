"""When something seems to carry the vehicle, by estimates alone."""

import math
from types import SimpleNamespace

import pytest

from flightsim.autopilot.land_detector import LandDetector
from flightsim.autopilot.parameters import Parameters
from flightsim.autopilot.vehicle import TICK_S


def vehicle_at(height_m, *, up_mps, thrust, tilt_deg=0.0):
    return SimpleNamespace(
        is_landed=False,
        height_m=height_m,
        velocity_enu_mps=(0.0, 0.0, up_mps),
        cos_tilt=math.cos(math.radians(tilt_deg)),
        speed_xy_mps=0.0,
        is_position_ok=True,
        thrust_fraction=thrust,
        hover_thrust_fraction=1.0,
        angular_rate_flu_radps=(1.0, 0.0, 0.0),
    )


def seconds_to_contact(height_m, *, up_mps=-0.15, thrust=0.6, tilt_deg=0.0, limit_s=3.0):
    """How long rotors carry too little in a commanded descent until it counts as contact."""
    detector = LandDetector(Parameters())
    vehicle = vehicle_at(height_m, up_mps=up_mps, thrust=thrust, tilt_deg=tilt_deg)
    detector.has_contact = False
    for tick in range(1, round(limit_s / TICK_S) + 1):
        detector.update(vehicle, is_armed=True, is_descending=True, commanded_up_mps=-0.3)
        if detector.has_contact:
            return tick * TICK_S
    return None


@pytest.mark.parametrize(
    ("height_m", "tilt_deg", "least_s", "most_s"),
    [
        (0.03, 0.0, 0.0, 0.12),
        (0.1, 0.0, 1.0, 1.3),
        (0.1, 15.0, 0.3, 0.5),  # It may lean on the legs of one side,
        (0.13, 15.0, 1.0, 1.3),  # but not as high as that.
        (0.9, 15.0, 1.0, 1.3),
        (None, 0.0, 0.3, 0.5),
    ],
)
def test_a_gust_has_to_carry_for_long_unless_its_height_is_that_of_the_ground(
    height_m, tilt_deg, least_s, most_s
):
    assert least_s < seconds_to_contact(height_m, tilt_deg=tilt_deg) <= most_s


def test_a_descent_that_the_ground_ends_is_contact_at_once():
    assert seconds_to_contact(0.05, up_mps=0.0, thrust=1.0) <= 0.06


@pytest.mark.parametrize(("up_mps", "thrust"), [(-0.15, 0.9), (-0.6, 0.6)])
def test_rotors_that_carry_and_a_vehicle_that_sinks_are_in_the_air(up_mps, thrust):
    assert seconds_to_contact(0.2, up_mps=up_mps, thrust=thrust) is None


def test_whatever_sinks_about_as_fast_as_commanded_is_carried_by_nothing():
    assert seconds_to_contact(0.03, up_mps=-0.2) is None
    assert seconds_to_contact(0.03, up_mps=-0.1) <= 0.12


def test_an_updraught_that_carries_high_up_is_no_ground():
    assert seconds_to_contact(3.9) is None
    # It may stand at an edge, with the rangefinder beyond that.
    assert 1.0 < seconds_to_contact(3.9, thrust=0.4) <= 1.3


@pytest.mark.parametrize(("height_m", "is_landed"), [(0.05, True), (3.9, False)])
def test_an_updraught_does_not_land_a_vehicle_that_hovers(height_m, is_landed):
    detector, vehicle = LandDetector(Parameters()), vehicle_at(height_m, up_mps=0.0, thrust=0.7)
    vehicle.angular_rate_flu_radps = (0.1, 0.0, 0.0)
    for _ in range(round(3.0 / TICK_S)):
        detector.update(vehicle, is_armed=True, is_descending=False, commanded_up_mps=0.0)
    assert vehicle.is_landed == is_landed
