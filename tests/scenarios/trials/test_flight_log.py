"""The log of a flight: every row counts, and only flights that are judged are kept."""

import hashlib
import tracemalloc
from types import SimpleNamespace

import numpy as np
import pytest

from scenarios.trials.flight_log import FlightLog
from tests.scenarios.trials.histories import AIR, LANDED, START, flight

N_ROWS = 5
WHOLE = flight((1, START, 1), (20, AIR, 0), (1, LANDED, 1))


def logged(history, *, is_judged):
    world = SimpleNamespace(obstacles=())
    plant = SimpleNamespace(history=history[:N_ROWS], world=world)
    log = FlightLog(plant, is_judged=is_judged)
    for start in range(0, len(history), N_ROWS):
        plant.history = history[start : start + N_ROWS]
        log.on_tick()
        if start == 400:
            log.state_hash()  # Asking for it in between changes nothing.
    return log


@pytest.mark.parametrize("is_judged", [True, False])
def test_the_hash_is_that_of_every_row(is_judged):
    expected = hashlib.blake2b(WHOLE.tobytes(), digest_size=16).hexdigest()
    assert logged(WHOLE, is_judged=is_judged).state_hash() == expected


def test_errors_of_a_flight_that_is_not_judged_are_those_of_all_rows():
    history = WHOLE.copy()
    error_m = np.random.default_rng(3).normal(size=(len(history), 3))
    history["position_est_enu_m"] += error_m
    score = logged(history, is_judged=False).score(None)
    rms_m = np.sqrt(np.mean(np.sum(error_m**2, axis=1)))
    assert score.position_rmse_m == pytest.approx(rms_m, rel=1e-12)
    assert not score.has_flown


def test_a_flight_that_is_not_judged_takes_no_more_memory_the_longer_it_lasts():
    plant = SimpleNamespace(history=WHOLE[:N_ROWS])
    log = FlightLog(plant, is_judged=False)
    for _ in range(1000):
        log.on_tick()
    tracemalloc.start()
    for _ in range(5000):
        log.on_tick()
    grown, _ = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert grown < 300_000  # A hundred seconds of rows are 10 MB or more.


def test_the_track_is_the_way_from_the_first_row_to_the_last():
    history = flight((1, START, 1), (9, AIR, 0))
    history["position_true_enu_m"][:, 0] = np.linspace(0.0, 9.999, len(history)) ** 2 / 10
    history["position_true_enu_m"][:, 1:] = 2.0
    log = logged(history, is_judged=True)
    before = log.state_hash()
    track = np.array(log.track())
    assert log.state_hash() == before
    assert track[0].tolist() == [0.0, 2.0, 2.0]
    assert track[-1] == pytest.approx([10.0, 2.0, 2.0], abs=0.05)
    assert len(track) == 2


def test_the_track_has_five_points_a_second_where_the_way_bends():
    history = flight((4, AIR, 0))
    angle_rad = np.arange(len(history)) * 0.01
    history["position_true_enu_m"][:, 0] = 30.0 * np.cos(angle_rad)
    history["position_true_enu_m"][:, 1] = 30.0 * np.sin(angle_rad)
    assert len(logged(history, is_judged=True).track()) == 21
