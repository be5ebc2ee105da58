"""Which cameras look out for movers, and how often; and where they stand when they look."""

import dataclasses
from collections import Counter

import pytest

from flightsim.vehicles.catalogue import AIRFRAMES
from scenarios.mission.surroundings import survey
from scenarios.pilot.depth_frames import NoDepthError
from scenarios.pilot.senses import AHEAD, LOOK_PERIOD_US, OVERHEAD, Senses
from tests.flightsim.handmade import empty_scene


def looks(n_periods, *, expects_traffic):
    """Names of the cameras that were asked for a frame, period by period."""
    seen = Counter()

    def frames(camera):
        seen[camera] += 1
        raise NoDepthError

    senses = Senses(
        survey(empty_scene(), AIRFRAMES["iris"]), frames, expects_traffic=expects_traffic
    )
    for number in range(n_periods):
        senses._time_us = number * LOOK_PERIOD_US
        senses.look_about()
    return seen


def test_cameras_overhead_are_used_in_every_other_look():
    seen = looks(10, expects_traffic=True)
    assert {seen[camera] for camera in AHEAD} == {10}
    assert {seen[camera] for camera in OVERHEAD} == {5}


def test_the_first_look_uses_all_cameras():
    assert looks(1, expects_traffic=True) == dict.fromkeys((*AHEAD, *OVERHEAD), 1)


def test_without_movers_nothing_looks_about_in_a_known_place():
    assert not looks(10, expects_traffic=False)


def test_an_estimate_of_a_moment_ago_moves_on_along_its_velocity():
    """The height, too: it went on at 1 m/s, whatever the vehicle climbed at."""
    senses = Senses(survey(empty_scene(), AIRFRAMES["iris"]), lambda _: None, expects_traffic=False)
    told = dataclasses.replace(
        senses._estimate,
        position_enu_m=(1.0, 2.0, 3.0),
        velocity_enu_mps=(4.0, -5.0, -6.0),
        quat_wxyz=(1.0, 0.0, 0.0, 0.0),
        angular_rate_flu_radps=(0.0, 0.0, 1.0),
        position_time_ms=1000,
    )
    senses._estimate, senses._time_us = told, 1_050_000
    now = senses._now()
    assert now.position_enu_m == pytest.approx((1.2, 1.75, 2.7))
    assert now.quat_wxyz == pytest.approx((0.99969, 0.0, 0.0, 0.024997), abs=1e-5)
