"""Scenes in which a pilot does worst: flown, ranked, kept, and not flown twice."""

import json

import numpy as np
import pytest

from aeroscene.scene.io import read_scene, write_scene
from flightsim.cameras import CameraError
from flightsim.vehicles.catalogue import AIRFRAMES
from scenarios import Verdict
from scenarios.baselines.named import NamedPilot
from scenarios.generation.text_options import GenerateError, asked_areas
from scenarios.generation.worst_scenes import Flight, Tries, fly, worst_first
from scenarios.mission.clearance import flown_clearance_m
from scenarios.mission.surroundings import sphere_radius_m
from tests.scenarios.landing_scenes import field, yard


class Stay:
    """Stays where it is."""

    area = None
    is_done = True
    verdict = Verdict(success=True, reason="stayed")
    n_made = 0

    def __init__(self, _):
        type(self).n_made += 1

    def update(self, time_us):
        pass


class Crash(Stay):
    """Raises an error in flight."""

    is_done = False

    def update(self, time_us):
        if time_us > 100_000:
            raise ZeroDivisionError("no wind\nat all")


def flight(seed, error_m=0.1, seconds=30.0, clearance_m=1.0, *, success=True):
    return Flight(
        seed=seed,
        success=success,
        reason="",
        touchdown_error_m=error_m,
        sim_seconds=seconds,
        least_clearance_m=clearance_m,
    )


def seeds(*flights):
    return [each.seed for each in worst_first(flights)]


def test_failed_flights_come_first_whatever_their_figures():
    assert seeds(flight(1, 2.0, 90.0, 0.0), flight(2, success=False), flight(3)) == [2, 1, 3]


def test_each_figure_makes_a_flight_worse():
    assert seeds(flight(1), flight(2, error_m=0.2)) == [2, 1]
    assert seeds(flight(1), flight(2, seconds=40.0)) == [2, 1]
    assert seeds(flight(1), flight(2, clearance_m=0.5)) == [2, 1]
    assert seeds(flight(1), flight(2, error_m=None)) == [2, 1]
    assert seeds(flight(2), flight(1)) == [1, 2]


def test_two_worse_figures_outweigh_one():
    one, two = flight(1, error_m=5.0), flight(2, seconds=31.0, clearance_m=0.9)
    assert seeds(one, two) == [2, 1]


def test_clearance_is_that_of_the_way_between_the_ends():
    scene, iris = yard(), AIRFRAMES["iris"]
    # Over the middle crate, whose top is at 1 m, in 2.2 m.
    rise = np.linspace(0.0, 2.2, 20)
    way = np.concatenate(
        [
            np.column_stack([np.zeros(20), np.zeros(20), rise]),
            np.column_stack([np.linspace(0.0, 5.5, 60), np.full(60, -0.5), np.full(60, 2.2)]),
        ]
    )
    found = flown_clearance_m(scene, iris, way, 1.5)
    assert found == pytest.approx(1.2 - sphere_radius_m(iris), abs=0.02)
    assert flown_clearance_m(scene, iris, way[:5], 1.5) is None
    assert flown_clearance_m(scene, iris, np.zeros((0, 3)), 1.5) is None


def test_a_flight_has_the_verdict_of_the_truth_and_an_error_of_the_pilot_is_a_failure():
    stayed = fly(yard(), NamedPilot(make=Stay))
    assert (stayed.success, stayed.reason) == (False, "never left the ground")
    assert stayed.sim_seconds > 0.5
    crashed = fly(yard(), NamedPilot(make=Crash))
    assert not crashed.success
    assert crashed.reason == "ZeroDivisionError: no wind at all"
    lost = fly(yard(areas=()), NamedPilot())
    assert not lost.success
    assert "no landing area suits class medium" in lost.reason


def test_a_machine_that_cannot_fly_says_nothing_of_the_pilot():
    class Blind(Stay):
        def __init__(self, _):
            raise CameraError("no renderer")

    with pytest.raises(CameraError, match="no renderer"):
        fly(yard(), NamedPilot(make=Blind))


def test_what_was_flown_is_not_flown_again_and_the_document_tells_of_it(tmp_path):
    asked = {"worst_for": "demo", "density": "None"}
    tries = Tries(tmp_path / "tried", asked)
    write_scene(field(), tries.scene_path(0))
    began = Stay.n_made
    first = tries.flight(0, NamedPilot(make=Stay))
    again = Tries(tmp_path / "tried", asked).flight(0, NamedPilot(make=Stay))
    assert first == again
    assert Stay.n_made == began + 1
    path = tries.keep(first, "my:Pilot", 7, tmp_path)
    kept = read_scene(path)
    assert kept.wishes == {"worst_for": "my:Pilot", "of": 7}
    assert kept.measured["flight_success"] is False
    assert kept.measured["flight_reason"] == "never left the ground"
    assert kept.objects == field().objects
    with pytest.raises(GenerateError, match="holds tries of other wishes; valid: another folder"):
        Tries(tmp_path / "tried", asked | {"density": "2.0"})
    assert json.loads((tmp_path / "tried" / "asked.json").read_text()) == asked


@pytest.mark.parametrize("text", ["many", "small", "small=x", "huge=3", "small=1,small=2", "1.5"])
def test_areas_that_cannot_be_read_are_refused(text):
    with pytest.raises(GenerateError, match=r"valid: a number, or counts of classes") as caught:
        asked_areas(text)
    assert repr(text) in str(caught.value)


def test_areas_are_a_number_or_counts_of_classes():
    assert asked_areas("12") == 12
    found = asked_areas("small=20, large=2")
    assert found.named == {"small": 20, "large": 2}
