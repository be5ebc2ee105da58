"""What a sensor says instead of what it has measured."""

import numpy as np
import pytest

from flightsim.plant.sensing import SENSORS
from flightsim.sensors.barometer import BAROMETER, BarometerCfg
from flightsim.sensors.failure import (
    MOST_ALIKE,
    N_CHANNELS,
    SLOW_FACTOR,
    Failure,
    is_heard,
    is_stuck,
    said,
)
from flightsim.sensors.sensor import SensorStart

PERIOD, FIRST = 5, 1001
NORMALS = np.array([0.5, -1.0])


def failing(failure, since=FIRST):
    """A barometer of 50 Hz in a plant of 250 Hz that fails in this way."""
    r = BAROMETER.new(BarometerCfg(), SensorStart(tick_hz=250))[0]
    r["failure"][0] = failure
    r["failing_since"][0] = since
    return r


def answers(r, n):
    """What it says at its next samples, which measure 0, 1, 2, ..."""
    ticks = range(FIRST + 4, FIRST + 4 + n * PERIOD, PERIOD)
    return [said(r, 0, tick, 0, float(value), NORMALS) for value, tick in enumerate(ticks)]


def test_a_sound_sensor_says_what_it_measures():
    assert answers(failing(Failure.NONE), 4) == [0.0, 1.0, 2.0, 3.0]


def test_a_stuck_sensor_repeats_its_first_sample():
    assert answers(failing(Failure.STUCK), 4) == [0.0] * 4


def test_a_wrong_sensor_is_off_by_a_constant_and_garbage_has_nothing_of_the_sample():
    (wrong,), (garbage,) = BAROMETER.wrong, BAROMETER.garbage
    assert answers(failing(Failure.WRONG), 3) == [wrong, 1.0 + wrong, 2.0 + wrong]
    assert answers(failing(Failure.GARBAGE), 3) == [0.5 * garbage] * 3


def test_a_delayed_sensor_is_half_a_second_behind():
    r = failing(Failure.DELAYED)
    assert r["n_late"] == 25
    assert answers(r, 40) == [0.0] * 25 + [float(k) for k in range(15)]


@pytest.mark.parametrize(
    ("failure", "share"),
    [
        (Failure.NONE, 1.0),
        (Failure.OFF, 0.0),
        (Failure.STUCK, 1.0),
        (Failure.SLOW, 1.0 / SLOW_FACTOR),
        (Failure.INTERMITTENT, 0.5),
    ],
)
def test_some_failures_are_silence(failure, share):
    r = failing(failure)
    heard = [is_heard(r, 0, tick) for tick in range(0, 5000, PERIOD)]
    assert np.mean(heard) == share


def test_a_driver_takes_a_sensor_that_repeats_itself_for_stuck():
    r = failing(Failure.NONE)
    assert not any(is_stuck(r, 0, value) for value in (1.0, *[2.0] * MOST_ALIKE))
    assert is_stuck(r, 0, 2.0)
    assert not is_stuck(r, 0, 2.5)
    assert not any(is_stuck(r, 0, np.inf) for _ in range(2 * MOST_ALIKE))


@pytest.mark.parametrize("sensor", SENSORS, ids=lambda sensor: sensor.name)
def test_every_sensor_has_its_own_way_to_be_wrong(sensor):
    assert any(sensor.wrong)
    assert all(sensor.garbage)
    assert len(sensor.wrong) <= len(sensor.garbage) <= N_CHANNELS
