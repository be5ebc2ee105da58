from itertools import pairwise

from flightsim.autopilot.events import EventLog, MissionItemReached, Severity, Statustext


def test_the_same_line_is_not_repeated_at_once():
    log = EventLog(quiet_us=2_000_000)
    for time_us in range(0, 10_000_000, 20_000):
        log.time_us = time_us
        log.report(Severity.WARNING, "Low battery level")
    times = [event.time_us for event in log.pop()]
    assert len(times) == 5
    assert all(b - a >= 2_000_000 for a, b in pairwise(times))


def test_events_wait_in_order_until_they_are_popped():
    log = EventLog()
    log.report(Severity.INFO, "one")
    log.mission_item_reached(4)
    log.report(Severity.INFO, "two")
    assert log.pop() == [
        Statustext(0, Severity.INFO, "one"),
        MissionItemReached(0, 4),
        Statustext(0, Severity.INFO, "two"),
    ]
    assert log.pop() == []


def test_a_flood_keeps_only_the_latest():
    log = EventLog(capacity=8)
    for i in range(1000):
        log.report(Severity.INFO, f"line {i}")
    assert [event.text for event in log.pop()] == [f"line {i}" for i in range(992, 1000)]
