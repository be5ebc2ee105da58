"""Effort of a flight: time, energy and jerk, against closed forms."""

import math

import numpy as np
import pytest

from flightsim.vehicles.battery import Battery
from flightsim.vehicles.catalogue import AIRFRAMES
from scenarios.trials.measures.effort import measure_effort
from tests.scenarios.trials.histories import AIR, HOVER, LANDED, START, flight

IRIS = AIRFRAMES["iris"]
WHOLE = flight((2, START, 1, HOVER), (20, AIR, 0, HOVER), (3, LANDED, 1, HOVER))
LIFT_OFF_S, TOUCHDOWN_S = 2_004_000 * 1e-6, 22_004_000 * 1e-6
TIMES = {"lift_off_s": LIFT_OFF_S, "reached_s": 12.0, "touchdown_s": TOUCHDOWN_S}


def test_times_count_from_lift_off():
    effort = measure_effort(WHOLE, IRIS, **TIMES)
    assert effort.navigation_s == pytest.approx(9.996)
    assert effort.flight_s == pytest.approx(20.0)
    aborted = measure_effort(WHOLE, IRIS, lift_off_s=LIFT_OFF_S, reached_s=None, touchdown_s=None)
    assert (aborted.navigation_s, aborted.flight_s) == (None, None)
    assert aborted.energy_j == pytest.approx(effort.energy_j * 23.0 / 20.0, rel=1e-3)


def test_energy_is_what_the_battery_delivers_in_flight():
    effort = measure_effort(WHOLE, IRIS, **TIMES)
    battery, delivered_j = Battery(IRIS.battery), 0.0
    for _ in range(20 * 250):
        battery.step([HOVER] * 4, 0.004)
        delivered_j += battery.voltage_v * battery.current_a * 0.004
    assert effort.energy_j == pytest.approx(delivered_j, rel=1e-6)


def test_jerk_is_that_of_a_swing_and_none_of_a_steady_acceleration():
    history = WHOLE.copy()
    time_s = history["time_us"] * 1e-6
    history["velocity_true_enu_mps"] = np.outer(time_s, [1.0, -2.0, 0.5])
    assert measure_effort(history, IRIS, **TIMES).jerk_rms_mps3 == pytest.approx(0.0, abs=1e-9)
    rate_radps, speed_mps = math.pi, 2.0  # Ten whole swings in 20 s.
    history["velocity_true_enu_mps"][:, 1] = speed_mps * np.sin(rate_radps * time_s)
    expected_mps3 = speed_mps * rate_radps**2 / math.sqrt(2.0)
    jerk_mps3 = measure_effort(history, IRIS, **TIMES).jerk_rms_mps3
    assert jerk_mps3 == pytest.approx(expected_mps3, rel=0.02)


def test_a_hop_is_too_short_for_a_jerk():
    times = {"lift_off_s": 2.0, "reached_s": None, "touchdown_s": 2.25}
    assert measure_effort(WHOLE, IRIS, **times).jerk_rms_mps3 is None
