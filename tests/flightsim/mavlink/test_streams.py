"""Streams keep their rates, whatever was set before."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from flightsim.mavlink.dialect import LAYOUTS
from flightsim.mavlink.streaming import TICK_US, mark_due
from flightsim.mavlink.streams import StreamTable

_ATTITUDE = LAYOUTS["ATTITUDE"].message_id
_HEARTBEAT = LAYOUTS["HEARTBEAT"].message_id
_ODOMETRY = LAYOUTS["ODOMETRY"].message_id
_VFR_HUD = LAYOUTS["VFR_HUD"].message_id
_ALL = [layout.message_id for layout in LAYOUTS.values()]


def _due(table: StreamTable, now_us: int) -> list[int]:
    """Message ids to send at a tick, which then are due no longer."""
    mark_due(table.partner, len(table.is_due), now_us)
    due = [message_id for message_id, is_due in zip(table.ids, table.is_due, strict=True) if is_due]
    table.is_due[:] = 0
    return due


def _count(table: StreamTable, start_s: float, seconds: float) -> dict[int, int]:
    counts: dict[int, int] = {}
    first = round(start_s * 50) + 1
    for tick in range(first, first + round(seconds * 50)):
        for message_id in _due(table, tick * TICK_US):
            counts[message_id] = counts.get(message_id, 0) + 1
    return counts


def test_default_rates_of_both_profiles():
    normal = _count(StreamTable("normal", _ALL), 0.0, 20.0)
    onboard = _count(StreamTable("onboard", _ALL), 0.0, 20.0)
    assert normal[_ATTITUDE] == pytest.approx(20 * 15, abs=1)
    assert onboard[_ATTITUDE] == 20 * 50
    assert _ODOMETRY not in normal
    assert onboard[_ODOMETRY] == pytest.approx(20 * 30, abs=1)
    assert normal[_HEARTBEAT] == onboard[_HEARTBEAT] == 20


@given(rate_hz=st.floats(0.2, 50.0))
def test_a_rate_that_is_set_is_kept(rate_hz):
    table = StreamTable("normal", _ALL)
    assert table.set_interval(_ODOMETRY, 1e6 / rate_hz)
    assert _count(table, 0.0, 20.0)[_ODOMETRY] == pytest.approx(20.0 * rate_hz, abs=1.01)


@given(intervals=st.lists(st.sampled_from([-1.0, 0.0, 1.0, 20e3, 33e3, 1e6]), max_size=8))
def test_only_the_last_of_many_changes_counts(intervals):
    table = StreamTable("normal", _ALL)
    for step, interval_us in enumerate(intervals):
        table.set_interval(_ODOMETRY, interval_us)
        _count(table, 0.1 * step, 0.1)
    table.set_interval(_ODOMETRY, 100_000)
    assert _count(table, 0.1 * len(intervals), 10.0)[_ODOMETRY] == pytest.approx(100, abs=1)


def test_minus_one_stops_and_zero_restores_the_default():
    table = StreamTable("normal", _ALL)
    table.set_interval(_ATTITUDE, -1)
    assert table.interval_us(_ATTITUDE) == -1
    assert _ATTITUDE not in _count(table, 0.0, 2.0)
    table.set_interval(_ATTITUDE, 0)
    assert _count(table, 2.0, 2.0)[_ATTITUDE] == pytest.approx(30, abs=1)
    table.set_interval(_ODOMETRY, 0)
    assert table.interval_us(_ODOMETRY) == -1


def test_no_stream_is_faster_than_the_tick():
    table = StreamTable("normal", _ALL)
    table.set_interval(_ATTITUDE, 1)
    assert _count(table, 0.0, 1.0)[_ATTITUDE] == 50
    assert table.interval_us(_ATTITUDE) == TICK_US


def test_messages_that_are_never_streamed_are_refused():
    assert not StreamTable("normal", [_ATTITUDE]).set_interval(_ODOMETRY, 1e5)


def test_a_data_stream_request_sets_its_group_and_spares_the_heartbeat():
    table = StreamTable("normal", _ALL)
    assert table.set_group(11, 10.0, is_on=True)
    assert _count(table, 0.0, 2.0)[_VFR_HUD] == 20
    assert table.set_group(0, 4.0, is_on=False)
    counts = _count(table, 2.0, 2.0)
    assert _VFR_HUD not in counts
    assert counts[_HEARTBEAT] == 2
    assert not table.set_group(99, 4.0, is_on=True)


def test_ticks_that_are_left_out_are_made_up_for_once():
    table = StreamTable("onboard", [_ATTITUDE, _HEARTBEAT])
    assert _due(table, TICK_US) == [_ATTITUDE, _HEARTBEAT]
    assert _due(table, 200 * TICK_US) == [_ATTITUDE, _HEARTBEAT]
    assert _due(table, 201 * TICK_US) == [_ATTITUDE, _HEARTBEAT][: 1 + (201 % 50 == 1)]
    assert _due(table, 202 * TICK_US) == [_ATTITUDE]


@pytest.mark.parametrize("interval_us", [5e9, 1e30])
def test_no_interval_is_longer_than_can_be_told(interval_us):
    table = StreamTable("normal", _ALL)
    assert table.set_interval(_ATTITUDE, interval_us)
    assert table.interval_us(_ATTITUDE) == 2**31 - 1
