"""Who flies which trial: few scenes opened, nobody idle, nothing flown twice."""

from collections import Counter

import pytest

from scenarios.campaigns.engines.crew import Crew, WorkerError, WorkerGoneError
from scenarios.campaigns.engines.forecast import Costs, forecast
from scenarios.campaigns.engines.schedule import Schedule
from scenarios.campaigns.flyer import Trial


def trials(n_scenes, n_trials, vehicles=("iris",)):
    return [
        Trial(str(scene), vehicle, number)
        for scene in range(n_scenes)
        for vehicle in vehicles
        for number in range(n_trials)
    ]


def test_a_worker_stays_with_scene_and_vehicle_and_then_with_the_scene():
    asked = trials(2, 3, ("iris", "hummingbird"))
    schedule, last, flown = Schedule(asked), None, []
    while (last := schedule.next(last)) is not None:
        flown.append(last)
    assert flown == asked
    assert schedule.n_left == 0


def test_workers_begin_apart_and_help_each_other_at_the_end():
    schedule = Schedule(trials(2, 4))
    first, second, third = (schedule.next(None) for _ in range(3))
    assert (first.scene, second.scene, third.scene) == ("0", "1", "0")
    # Of scene 0 two are left for two workers, of scene 1 three for one.
    assert schedule.next(None).scene == "1"


def test_a_place_that_a_dead_worker_has_left_is_gone_on_with_first():
    schedule = Schedule(trials(3, 4))
    flown = schedule.next(None)
    assert schedule.next(None).scene == "1"
    assert schedule.give_back(flown) is True
    assert schedule.next(None) == flown
    assert schedule.give_back(flown) is False
    assert schedule.next(None) == Trial("0", "iris", 1)


def test_a_forecast_flies_all_in_the_time_of_the_busiest_worker():
    costs = Costs(first_s=[6.0], others_s=[2.0])
    alone = forecast(trials(2, 10), costs, 1)
    assert alone.openings == 2
    assert 3.0 + 2 * (6.0 + 9 * 2.0) <= alone.wall_seconds < 52.0
    assert alone.share_at_work > 0.99
    two = forecast(trials(2, 10), costs, 2)
    assert alone.wall_seconds / two.wall_seconds > 1.85
    # Sixty-four workers open each of the scenes once, and some again to help at the end.
    many = forecast(trials(100, 100), costs, 64)
    assert many.openings < 100 + 2 * 64
    assert many.share_at_work > 0.95


def test_a_forecast_has_as_many_openings_as_scenes_where_nobody_needs_help():
    many = forecast(trials(8, 20), Costs(first_s=[6.0], others_s=[2.0]), 4)
    assert many.openings == 8
    assert Counter(trial.scene for trial in trials(8, 20)) == {str(n): 20 for n in range(8)}


class Stillborn:
    """An engine whose workers end before they fly."""

    def hire(self):
        return self

    def wait(self, _):
        return (self,)

    def receive(self):
        raise WorkerGoneError("no memory")

    def end(self):
        pass


def test_workers_that_end_before_they_fly_end_the_campaign_with_a_line():
    crew = Crew(Stillborn(), 1, 60.0)
    with pytest.raises(WorkerError, match="3 workers ended before they flew: no memory"):
        list(crew.fly(trials(1, 1)))
