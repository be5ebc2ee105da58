"""Which cameras look out for movers, and how often."""

from collections import Counter

from flightsim.vehicles.catalogue import AIRFRAMES
from scenarios.mission.surroundings import survey
from scenarios.pilot.eyes import NoDepthError
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
