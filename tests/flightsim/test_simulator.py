"""The loop steps its parts in order, stops when told, and keeps to the speed asked for."""

import itertools
import math

import pytest

from flightsim import simulator as simulator_module
from flightsim.simulator import Simulator, SpeedError, tick_seconds


class _Parts:
    """Plant, autopilot and server that note when they are called."""

    def __init__(self):
        self.calls = []
        self.time_us = 0

    def advance(self):
        self.time_us += 20_000
        self.calls.append("plant")

    def update(self):
        self.calls.append("update")


class _Clock:
    """Wall time that only sleeping, and work of a fixed length, moves."""

    def __init__(self, monkeypatch, work_s=0.0):
        self.now_s = 100.0
        self.slept_s = 0.0
        self.work_s = work_s
        monkeypatch.setattr(simulator_module.time, "perf_counter", lambda: self.now_s)
        monkeypatch.setattr(simulator_module.time, "sleep", self._sleep)

    def _sleep(self, seconds):
        assert seconds > 0
        self.now_s += seconds
        self.slept_s += seconds

    def work(self):
        self.now_s += self.work_s


def test_a_step_is_plant_autopilot_server_observers():
    plant, autopilot, server = _Parts(), _Parts(), _Parts()
    plant.calls = autopilot.calls = server.calls = calls = []
    observers = [lambda: calls.append("first"), lambda: calls.append("second")]
    simulator = Simulator(plant, autopilot, server, observers=observers, speed="max")
    simulator.step()
    assert calls == ["plant", "update", "update", "first", "second"]
    assert simulator.timing.n_steps == 1


def test_observers_may_come_later():
    plant, observers, seen = _Parts(), [], []
    simulator = Simulator(plant, _Parts(), None, observers=observers, speed="max")
    observers.append(lambda: seen.append(plant.time_us))
    simulator.step()
    assert seen == [20_000]


def test_a_run_ends_at_its_time_by_its_condition_or_on_request():
    plant = _Parts()
    simulator = Simulator(plant, _Parts(), None, speed="max")
    simulator.run(until_us=1_000_000)
    assert plant.time_us == 1_000_000
    counter = itertools.count()
    simulator.run(stop=lambda: next(counter) == 10)
    assert plant.time_us == 1_200_000
    observers = []
    stopping = Simulator(plant, _Parts(), None, observers=observers, speed="max")
    observers.append(stopping.request_stop)
    stopping.run()
    assert plant.time_us == 1_220_000


@pytest.mark.parametrize("speed", [0.5, 1, 5.0])
def test_a_paced_run_takes_the_wall_time_it_should_and_sleeps_the_rest(monkeypatch, speed):
    clock = _Clock(monkeypatch, work_s=0.001)
    simulator = Simulator(_Parts(), _Parts(), None, observers=[clock.work], speed=speed)
    simulator.run(until_us=10_000_000)
    assert clock.now_s - 100.0 == pytest.approx(10.0 / speed, abs=0.005)
    assert simulator.timing.idle_s == pytest.approx(clock.slept_s)
    assert clock.slept_s == pytest.approx(10.0 / speed - 0.5, abs=0.01)


def test_without_pacing_nothing_sleeps(monkeypatch):
    clock = _Clock(monkeypatch, work_s=0.001)
    Simulator(_Parts(), _Parts(), None, observers=[clock.work], speed="max").run(until_us=2_000_000)
    assert clock.slept_s == 0.0


def test_a_stall_is_not_raced_after(monkeypatch):
    clock = _Clock(monkeypatch)
    plant = _Parts()

    def stall_once():
        if plant.time_us == 1_000_000:
            clock.now_s += 30.0

    simulator = Simulator(plant, _Parts(), None, observers=[stall_once], speed=1)
    simulator.run(until_us=5_000_000)
    assert clock.now_s - 100.0 == pytest.approx(35.0, abs=0.05)


def test_a_loop_that_is_too_slow_never_sleeps(monkeypatch):
    clock = _Clock(monkeypatch, work_s=0.05)
    Simulator(_Parts(), _Parts(), None, observers=[clock.work], speed=1).run(until_us=2_000_000)
    assert clock.slept_s == 0.0


@pytest.mark.parametrize("speed", [0, -1, math.nan, math.inf, "fast", None])
def test_speeds_that_make_no_sense_are_refused(speed):
    with pytest.raises(SpeedError, match="positive numbers"):
        tick_seconds(speed)
