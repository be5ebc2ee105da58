"""The pilot goes carefully in wind and among movers, which it sees all round."""

import math

import numpy as np
import pytest

from autonomy.planning import MovingObstacles
from flightsim.vehicles.catalogue import AIRFRAMES
from scenarios.pilot import Phase
from scenarios.pilot.pace import AMONG_MOVERS, IN_WIND, USUAL, WINDY_MPS
from scenarios.pilot.senses import WATCHING
from tests.scenarios.landing_scenes import yard

ASPECT = 4 / 3


def test_a_slowed_pace_is_the_slower_one_in_all_things():
    slow = AMONG_MOVERS.slowed(IN_WIND)
    assert slow.limits.speed_horizontal_mps == AMONG_MOVERS.limits.speed_horizontal_mps
    assert slow.limits.acceleration_mps2 == AMONG_MOVERS.limits.acceleration_mps2
    assert (slow.descent_mps, slow.touchdown_mps) == (IN_WIND.descent_mps, IN_WIND.touchdown_mps)
    assert USUAL.slowed(IN_WIND) == IN_WIND


def test_wind_that_the_autopilot_reports_slows_plans_for_the_rest_of_the_flight(demo):
    demo = demo(yard())
    demo.fly_to(Phase.TAKEOFF)
    flight = demo.pilot._flight
    assert 0.0 <= flight.telemetry.wind_mps < 1.0  # WIND_COV came
    flight.telemetry.wind_mps = WINDY_MPS
    flight.heed_wind()
    assert flight.pace == USUAL
    flight.telemetry.wind_mps = WINDY_MPS + 0.1
    flight.heed_wind()
    assert (flight.pace, flight.mission.surroundings.limits) == (IN_WIND, IN_WIND.limits)
    demo.fly_to(Phase.NAVIGATE)
    times = np.arange(0.0, flight.course.trajectory.duration_s, 0.05)
    speeds = [math.hypot(*flight.course.trajectory.sample(t).velocity_enu_mps) for t in times]
    assert 0.5 < max(speeds) <= math.hypot(5.0, 2.0)
    assert flight.course.trajectory is not demo.mission.trajectory


@pytest.mark.parametrize("airframe", AIRFRAMES.values(), ids=AIRFRAMES)
def test_some_camera_watches_each_direction_from_the_level_to_the_zenith_and_below(airframe):
    above, below = np.mgrid[0:360:5, 0:91:5], np.mgrid[0:360:5, -90:-60:5]
    azimuth, elevation = np.radians(np.hstack([above.reshape(2, -1), below.reshape(2, -1)]))
    level = np.cos(elevation)
    rays = np.stack([level * np.cos(azimuth), level * np.sin(azimuth), np.sin(elevation)])
    is_seen = np.zeros(rays.shape[1], dtype=bool)
    for mount in airframe.cameras:
        if mount.name in WATCHING:
            x, y, z = mount.rotation_flu_from_optical.T @ rays
            half = math.tan(mount.vertical_fov_rad / 2)
            is_seen |= (z > 0) & (np.abs(y) <= half * z) & (np.abs(x) <= ASPECT * half * z)
    blind = np.degrees(np.stack([azimuth, elevation]))[:, ~is_seen]
    assert is_seen.all(), f"azimuth, elevation: {blind.T.tolist()}"


def test_it_stops_short_where_something_comes_to_the_end_of_the_plan_afterwards(demo):
    demo = demo(yard(), expects_traffic=True)
    pilot = demo.fly_to(Phase.NAVIGATE)
    flight = pilot._flight
    end_us = flight.time_us + round(1e6 * (flight.course.trajectory.duration_s + 1.0))
    course = np.array([0.0, 1.5, 0.0])

    def moving(time_us):
        away_s = (end_us - time_us) * 1e-6
        return MovingObstacles(
            position_enu_m=np.array([flight.hover_enu_m]) - away_s * course,
            velocity_enu_mps=course[None],
            radius_m=np.array([0.3]),
            half_extent_m=np.zeros((1, 3)),
            yaw_rad=np.zeros(1),
            growth_mps=0.0,
            horizon_s=4.0,
        )

    flight.senses.moving = moving
    demo.fly(until=lambda: pilot.phase is not Phase.NAVIGATE)
    change = pilot.transitions[-1]
    assert change.target is Phase.HOLD
    assert "something that moves would come within" in change.reason
    assert math.dist(demo.bench.plant.truth.position_enu_m, flight.hover_enu_m) > 1.0
