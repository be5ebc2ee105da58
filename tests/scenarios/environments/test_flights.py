"""What is kept of flights, and that no verdict misses what is not."""

from typing import Any

import numpy as np
import pytest

from scenarios.environments import EnvironmentCfg
from scenarios.environments.batch import Batch
from scenarios.environments.episodes.ending import judge_episode
from scenarios.environments.episodes.flights import Flights
from scenarios.environments.tasks import task_by_name

DOWN = {"rates": (-1.0, 0.2, 0.0, 0.0), "velocity": (0.0, 0.0, -0.8, 0.0)}


class WholeFlights(Flights):
    """Keeps all rows of every flight."""

    def __init__(self, fleet, step_s):
        super().__init__(fleet, step_s)
        self._n_free = 1_000_000


def batch_of(task, level, n=6, hz=50):
    cfg = EnvironmentCfg(action=level, action_hz=hz, episode_s=6.0)
    batch = Batch(task_by_name(task), ["42", "field"] * (n // 2), cfg, n_threads=1)
    for i in range(n):
        batch.seed(i, i)
    return batch


def ends(batch, level, n_steps=250):
    """Judgements and rewards of the last steps while vehicles come down, from different heights."""
    found, aside = [], np.random.default_rng(2).uniform(-0.05, 0.05, (len(batch), 4))
    batch.begin(range(len(batch)))
    for _ in range(n_steps):
        step = batch.step(np.clip(DOWN[level] + aside, -1.0, 1.0))
        found += [(i, end, step.reward[i]) for i, end in step.outcomes.items()]
        if step.outcomes:
            batch.begin(list(step.outcomes))
    batch.close()
    return found


@pytest.mark.parametrize("hz", [50, 250])
@pytest.mark.parametrize(("task", "level"), [("hover", "rates"), ("landing", "velocity")])
def test_a_verdict_does_not_depend_on_the_flight_before_the_last_second(task, level, hz):
    kept = ends(batch_of(task, level, hz=hz), level, 5 * hz)
    whole = batch_of(task, level, hz=hz)
    whole._flights = WholeFlights(whole._fleet, 1.0 / hz)
    assert kept == ends(whole, level, 5 * hz)
    assert len(kept) >= 6


def test_rows_begin_a_second_before_the_first_contact_and_then_stay():
    batch = batch_of("hover", "velocity", n=2)
    fleet, flights = batch._fleet, Flights(batch._fleet, 0.02)
    batch.begin(range(2))
    histories, is_flying = [[], []], np.ones(2, dtype=bool)
    for k in range(300):
        fleet.advance()
        # The first one touches something from the 100th advance on, as far as flights are told.
        flights.take(is_flying, np.array([k == 100, False]))
        for i in range(2):
            histories[i].append(fleet.history[i].copy())
    for i, n_kept in ((0, 251), (1, 51)):
        rows, n_before = flights.of(i)
        whole = np.concatenate(histories[i])
        assert len(rows) == 5 * n_kept
        assert n_before == len(whole) - len(rows)
        for name in rows.dtype.names or ():
            np.testing.assert_array_equal(rows[name], whole[name][n_before:])
    flights.begin(0)
    fleet.advance()
    flights.take(is_flying, np.zeros(2, dtype=bool))
    assert len(flights.of(0)[0]) == 5
    assert flights.of(0)[1] == 0
    batch.close()


def test_a_flight_ends_with_its_rest():
    batch = batch_of("landing", "velocity", n=2)
    batch.begin(range(2))
    batch.step(np.zeros((2, 4)))
    batch._fleet.advance_one(1)
    last = batch._flights.last(1)
    rows, _ = batch._flights.of(1, [last, last])
    ticks = [*range(1, 11), *range(6, 11)]
    assert rows["time_us"].tolist() == [4_000 * tick for tick in ticks]
    batch.close()


def test_looks_at_what_is_touched_come_at_the_same_ticks_whatever_is_kept():
    looked = []

    class Finder:
        def find(self, history, _movers, counts):
            looked.append(history["time_us"][counts].tolist())
            return ()

    finder: Any = Finder()
    batch = batch_of("landing", "velocity", n=2)
    batch.begin(range(2))
    for _ in range(60):
        batch.step(np.zeros((2, 4)))
    (history, n_before), start = batch._flights.of(0), batch._episodes[0].start
    ending = batch._task.ending(batch._now, 0, 1.2, is_time_up=True)
    world = batch._fleet.worlds[0]
    judge_episode(history, n_before, world.airframe, start.goal, ending, finder)
    assert n_before > 0
    assert looked[0]
    assert all((time_us // 4_000 - 1) % 10 == 0 for time_us in looked[0])
    batch.close()
