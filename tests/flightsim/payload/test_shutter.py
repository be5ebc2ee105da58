"""When pictures are taken."""

import pytest

from flightsim.autopilot.results import CommandResult
from flightsim.payload.shutter import Shutter

_HERE = (0.0, 0.0, 0.0)


def _times(shutter, seconds, speed_mps=0.0, start_us=0):
    """Seconds at which pictures are taken."""
    return [
        us * 1e-6
        for us in range(start_us, start_us + round(seconds * 1e6), 20_000)
        if shutter.is_due(us, (speed_mps * us * 1e-6, 0.0, 0.0))
    ]


def test_one_picture_is_taken_at_once_and_no_other():
    shutter = Shutter()
    assert shutter.shoot(0).is_accepted
    assert _times(shutter, 3.0) == [0.0]
    assert not shutter.is_in_series


def test_a_series_has_its_number_and_interval():
    shutter = Shutter()
    assert shutter.shoot(0, 3, 0.7).is_accepted
    assert shutter.interval_s == 0.7
    assert _times(shutter, 5.0) == pytest.approx([0.0, 0.7, 1.4])
    assert shutter.interval_s == 0.0


def test_a_series_without_end_goes_on_until_it_is_stopped():
    shutter = Shutter()
    shutter.shoot(0, 0, 1.0)
    assert len(_times(shutter, 10.0)) == 10
    shutter.stop()
    assert _times(shutter, 10.0, start_us=10_000_000) == []


def test_no_wish_makes_pictures_come_faster_than_the_camera_takes_them():
    shutter = Shutter()
    shutter.shoot(0, 0)
    shutter.each(0.001)
    assert len(_times(shutter, 10.0, speed_mps=5.0)) == 20
    assert shutter.shoot(10_000_000).result is CommandResult.TEMPORARILY_REJECTED
    assert Shutter().shoot(0, 5, 0.1).result is CommandResult.DENIED
    assert Shutter().shoot(0, -1).result is CommandResult.DENIED
    assert Shutter().each(float("nan")).result is CommandResult.DENIED


def test_pictures_by_the_way_come_after_each_part_of_it():
    shutter = Shutter()
    assert shutter.each(5.0).is_accepted
    assert _times(shutter, 7.01, speed_mps=2.0) == pytest.approx([2.5, 5.0])
    shutter.is_paused = True
    assert _times(shutter, 5.0, speed_mps=2.0, start_us=8_000_000) == []
    shutter.each(0.0)
    shutter.is_paused = False
    assert _times(shutter, 5.0, speed_mps=2.0, start_us=14_000_000) == []


def test_the_first_picture_by_the_way_may_come_at_once():
    shutter = Shutter()
    shutter.each(5.0, is_at_once=True)
    assert _times(shutter, 4.0, speed_mps=2.0) == pytest.approx([0.0, 2.5])
