"""The mission protocol against the autopilot's own stores, with and without loss."""

import math
import random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flightsim.autopilot.fence import FenceStore, RallyStore
from flightsim.autopilot.mission import MissionStore
from flightsim.frames import Geodetic, LocalFrame
from flightsim.mavlink.dialect import dialect as mav
from flightsim.mavlink.mission import FENCE, MISSION, RALLY, MissionService
from flightsim.mavlink.service import Partners
from flightsim.mavlink.statustext import StatustextSender
from tests.flightsim.mavlink.wire import Loop, named

_FRAME = LocalFrame(Geodetic(47.4, 8.5, 488.0))
_RELATIVE_INT, _MISSION_FRAME = 6, 2


class _Bench:
    """A mission service with one partner, whose frames may be lost on both ways."""

    def __init__(self, loss: float = 0.0, seed: int = 0):
        self.stores = {
            MISSION: MissionStore(),
            FENCE: FenceStore(_FRAME),
            RALLY: RallyStore(_FRAME),
        }
        self.loop = Loop()
        self.partners = Partners()
        self.partners.channels = [self.loop.channel]
        self.service = MissionService(self.stores, self.partners, StatustextSender(self.partners))
        self._loss = loss
        self._random = random.Random(seed)

    def ask(self, name, *values, loop=None):
        loop = loop or self.loop
        if self._random.random() < self._loss:
            return []
        for message in loop.deliver(name, *values):
            self.service.handlers[name](loop.channel, message)
        return self.heard(loop)

    def heard(self, loop=None):
        answers = (loop or self.loop).answers()
        return [answer for answer in answers if self._random.random() >= self._loss]

    def wait(self, seconds):
        self.loop.now_s += seconds
        self.service.update(self.loop.channel)
        return self.heard()


def _waypoint(
    index, *, mission_type=MISSION, command=mav.MAV_CMD_NAV_WAYPOINT, frame=_RELATIVE_INT, p1=0.0
):
    x, y = round((47.4 + 1e-5 * index) * 1e7), round(8.5 * 1e7)
    values = (frame, command, 0, 1, p1, 0.0, 0.0, math.nan, x, y, 10.0 + index, mission_type)
    return (1, 1, index, *values)


def _upload(bench, items, mission_type=MISSION, seconds=60.0):
    """Upload as a client does, repeating what stays unanswered; the result of the ack."""
    pending = bench.ask("MISSION_COUNT", 1, 1, len(items), mission_type)
    last_sent = ("MISSION_COUNT", 1, 1, len(items), mission_type)
    idle_s = 0.0
    while bench.loop.now_s < seconds:
        if not pending:
            pending = bench.wait(0.05)
            idle_s += 0.05
            if idle_s >= 0.5:
                idle_s = 0.0
                pending += bench.ask(*last_sent)
            continue
        message = pending.pop(0)
        if message.get_type() == "MISSION_ACK":
            return message.type
        if message.get_type() == "MISSION_REQUEST_INT":
            last_sent = ("MISSION_ITEM_INT", *items[message.seq])
            pending += bench.ask(*last_sent)
            idle_s = 0.0
    return None


def _download(bench, mission_type=MISSION, request="MISSION_REQUEST_INT"):
    (count,) = bench.ask("MISSION_REQUEST_LIST", 1, 1, mission_type)
    assert count.mission_type == mission_type
    items = []
    for index in range(count.count):
        (item,) = bench.ask(request, 1, 1, index, mission_type)
        items.append(item)
    return items


def _fields(item):
    return (
        *(item.seq, item.frame, item.command, item.autocontinue, item.param1, item.param2),
        *(item.param3, item.x, item.y, item.z),
    )


def test_what_is_uploaded_is_downloaded():
    bench = _Bench()
    items = [_waypoint(0, command=mav.MAV_CMD_NAV_TAKEOFF), *map(_waypoint, range(1, 6))]
    items.append((1, 1, 6, _MISSION_FRAME, 20, 0, 1, 0, 0, 0, 0, 0, 0, 0, MISSION))
    assert _upload(bench, items) == 0
    downloaded = _download(bench)
    assert [_fields(item) for item in downloaded] == [
        (index, frame, command, auto, p1, p2, p3, x, y, z)
        for _, _, index, frame, command, _, auto, p1, p2, p3, _, x, y, z, _ in items
    ]
    assert math.isnan(downloaded[0].param4)
    assert [item.current for item in downloaded] == [1, 0, 0, 0, 0, 0, 0]


def test_five_hundred_items_arrive_though_a_quarter_of_the_frames_is_lost():
    bench = _Bench(loss=0.25, seed=4)
    assert _upload(bench, [_waypoint(index) for index in range(500)], seconds=1e4) == 0
    assert len(bench.stores[MISSION]) == 500


def test_the_last_item_is_acknowledged_whenever_it_comes_again():
    bench, item = _Bench(), _waypoint(0)
    assert _upload(bench, [item]) == 0
    bench.wait(60.0)
    (ack,) = bench.ask("MISSION_ITEM_INT", *item)
    assert ack.type == 0


@given(latitude=st.floats(-90, 90), longitude=st.floats(-180, 180), altitude=st.floats(-99, 9e3))
@settings(max_examples=50)
def test_places_come_back_to_the_last_digit(latitude, longitude, altitude):
    x, y = round(latitude * 1e7), round(longitude * 1e7)
    bench = _Bench()
    item = (1, 1, 0, 5, 16, 0, 1, 0, 0, 0, 0, x, y, altitude, MISSION)
    assert _upload(bench, [item]) == 0
    (downloaded,) = _download(bench)
    assert (downloaded.x, downloaded.y) == (x, y)
    assert downloaded.z == pytest.approx(altitude, rel=1e-6)


def test_old_clients_upload_and_download_with_float_items():
    bench = _Bench()
    bench.ask("MISSION_COUNT", 1, 1, 2, MISSION)
    requests = [message.get_type() for _ in range(8) for message in bench.wait(0.3)]
    assert "MISSION_REQUEST" in requests
    answers = bench.ask("MISSION_ITEM", 1, 1, 0, 3, 22, 0, 1, 0, 0, 0, 0, 47.4, 8.5, 5.0)
    assert [message.get_type() for message in answers] == ["MISSION_REQUEST"]
    (ack,) = bench.ask("MISSION_ITEM", 1, 1, 1, 3, 16, 0, 1, 0, 0, 0, 0, 47.4, 8.5, 8.0)
    assert ack.type == 0
    downloaded = _download(bench, request="MISSION_REQUEST")
    assert [item.get_type() for item in downloaded] == ["MISSION_ITEM"] * 2
    assert downloaded[1].x == pytest.approx(47.4, abs=1e-5)


def test_fence_and_rally_points_are_kept_apart():
    bench = _Bench()
    corners = [(0, 0), (0, 1), (1, 1), (1, 0)]
    fence = [
        (1, 1, i, 5, 5001, 0, 1, 4, 0, 0, 0, 474000000 + 9000 * a, 85000000 + 9000 * b, 0, FENCE)
        for i, (a, b) in enumerate(corners)
    ]
    rally = [(1, 1, 0, 6, 5100, 0, 1, 0, 0, 0, 0, 474000000, 85000000, 20, RALLY)]
    assert _upload(bench, fence, FENCE) == 0
    assert _upload(bench, rally, RALLY) == 0
    counts = [len(bench.stores[key]) for key in (MISSION, FENCE, RALLY)]
    assert counts == [0, 4, 1]
    assert [item.mission_type for item in _download(bench, FENCE)] == [FENCE] * 4
    (ack,) = bench.ask("MISSION_CLEAR_ALL", 1, 1, 255)
    assert ack.type == 0
    assert [len(store) for store in bench.stores.values()] == [0, 0, 0]


@pytest.mark.parametrize(
    ("item", "result"),
    [
        (_waypoint(0, command=4242), 3),
        (_waypoint(0, frame=77), 2),
        (_waypoint(0, frame=1), 2),
        ((1, 1, 0, 6, 16, 0, 1, 0, 0, 0, 0, 2**31 - 2, 0, 5.0, MISSION), 10),
        ((1, 1, 0, 6, 16, 0, 1, 0, 0, 0, 0, 0x7FFFFFFF, 0, 5.0, MISSION), 10),
        ((1, 1, 0, 6, 16, 0, 1, 0, 0, 0, 0, 1, 0, math.nan, MISSION), 12),
        ((1, 1, 0, 6, 16, 0, 1, math.inf, 0, 0, 0, 1, 0, 5.0, MISSION), 6),
        ((1, 1, 0, 2, 177, 0, 1, 900, 0, 0, 0, 0, 0, 0, MISSION), 6),
    ],
)
def test_items_that_cannot_be_flown_are_refused_by_field_and_the_old_mission_stays(item, result):
    bench = _Bench()
    assert _upload(bench, [_waypoint(0), _waypoint(1)]) == 0
    assert _upload(bench, [item]) == result
    assert len(bench.stores[MISSION]) == 2


def test_counts_and_types_beyond_what_exists_are_refused():
    bench = _Bench()
    assert bench.ask("MISSION_COUNT", 1, 1, 65535, MISSION)[0].type == 4
    assert bench.ask("MISSION_COUNT", 1, 1, 3, 7)[0].type == 3
    assert bench.ask("MISSION_REQUEST_LIST", 1, 1, 7)[0].type == 3
    assert bench.ask("MISSION_CLEAR_ALL", 1, 1, 7)[0].type == 3
    assert bench.ask("MISSION_REQUEST_INT", 1, 1, 0, MISSION)[0].type == 13
    assert bench.ask("MISSION_REQUEST_PARTIAL_LIST", 1, 1, 0, 1, MISSION)[0].type == 3
    assert bench.ask("MISSION_WRITE_PARTIAL_LIST", 1, 1, 0, 1, MISSION)[0].type == 13
    assert bench.ask("MISSION_WRITE_PARTIAL_LIST", 1, 1, -5, 32767, MISSION)[0].type == 13


def test_a_count_of_zero_clears():
    bench = _Bench()
    _upload(bench, [_waypoint(0)])
    assert bench.ask("MISSION_COUNT", 1, 1, 0, MISSION)[0].type == 0
    assert len(bench.stores[MISSION]) == 0


def test_part_of_a_mission_is_replaced():
    bench = _Bench()
    _upload(bench, [_waypoint(index) for index in range(5)])
    (request,) = bench.ask("MISSION_WRITE_PARTIAL_LIST", 1, 1, 2, 3, MISSION)
    assert request.seq == 2
    (request,) = bench.ask("MISSION_ITEM_INT", *_waypoint(2, p1=7.0))
    assert request.seq == 3
    (ack,) = bench.ask("MISSION_ITEM_INT", *_waypoint(3, p1=8.0))
    assert ack.type == 0
    assert [item.param1 for item in bench.stores[MISSION].items] == [0, 0, 7, 8, 0]


def test_a_silent_client_ends_its_upload_and_another_may_begin():
    bench = _Bench()
    other = Loop()
    bench.ask("MISSION_COUNT", 1, 1, 3, MISSION)
    (refusal,) = bench.ask("MISSION_COUNT", 1, 1, 3, MISSION, loop=other)
    assert refusal.type == 14
    answers = bench.wait(6.0)
    assert [message.type for message in named(answers, "MISSION_ACK")] == [15]
    (request,) = bench.ask("MISSION_COUNT", 1, 1, 3, MISSION, loop=other)
    assert request.get_type() == "MISSION_REQUEST_INT"


def test_a_client_that_vanishes_is_forgotten_with_its_upload():
    bench = _Bench()
    bench.ask("MISSION_COUNT", 1, 1, 3, MISSION)
    bench.service.forget(bench.loop.channel)
    assert bench.wait(1.0) == []


def test_a_client_may_cancel():
    bench = _Bench()
    bench.ask("MISSION_COUNT", 1, 1, 3, MISSION)
    bench.ask("MISSION_ACK", 1, 1, 15, MISSION)
    assert bench.wait(1.0) == []


def test_items_out_of_turn_change_nothing():
    bench = _Bench()
    bench.ask("MISSION_ITEM_INT", *_waypoint(0))
    assert len(bench.stores[MISSION]) == 0
    bench.ask("MISSION_COUNT", 1, 1, 2, MISSION)
    bench.ask("MISSION_ITEM_INT", *_waypoint(1))
    (request,) = bench.wait(0.3)
    assert request.seq == 0
