"""What the kernel streams is what Python and pymavlink would say, byte for byte."""

import math
import random
import struct

import pytest

from flightsim.frames import Geodetic
from flightsim.mavlink.channel import Channel
from flightsim.mavlink.dialect import LAYOUTS
from flightsim.mavlink.dialect import dialect as mav
from flightsim.mavlink.outbox import LONG_LOCAL_BYTES
from flightsim.mavlink.personalities import ARDUPILOT, PX4
from flightsim.mavlink.streaming import KERNEL_MESSAGES, MOST_PARTS, KernelInputs, Streamer
from flightsim.mavlink.streams import StreamTable
from flightsim.sensors.failure import Failure
from tests.flightsim.mavlink.conftest import Flight
from tests.flightsim.mavlink.said import Said
from tests.flightsim.mavlink.wire import Wire


def _is_as_pymavlink_packs(name, frame):
    """Whether pymavlink, given what it reads in a frame, builds the same frame."""
    decoded = mav.MAVLink(None).decode(bytearray(frame))
    encoder = mav.MAVLink(None, decoded.get_srcSystem(), decoded.get_srcComponent())
    encoder.seq = decoded.get_seq()
    assert decoded.get_type() == name
    return bytes(decoded.pack(encoder)) == frame


def _split(data):
    """Frames of MAVLink 2, one after the other."""
    while data:
        end = 12 + data[1]
        yield data[:end]
        data = data[end:]


def _frames_of(flight):
    """Frames of a tick by the name of their message."""
    flight.simulator.step()
    frames = list(_split(flight.link.client.recv()))
    numbers = [frame[4] for frame in frames]
    assert numbers == [(numbers[0] + k) & 0xFF for k in range(len(numbers))]
    return {_name_of(frame): frame for frame in frames}


def _name_of(frame):
    return mav.mavlink_map[int.from_bytes(frame[7:10], "little")].msgname


def _payload(name, frame):
    return frame[10:-2].ljust(LAYOUTS[name].size, b"\0")


def _stream_everything(flight):
    for name in KERNEL_MESSAGES:
        wanted = (LAYOUTS[name].message_id, 20_000)
        assert flight.command(mav.MAV_CMD_SET_MESSAGE_INTERVAL, *wanted) == 0


def test_every_compiled_message_says_what_python_would(flight):
    _stream_everything(flight)
    said = set()

    def compare():
        frames = _frames_of(flight)
        expected = Said(flight)
        for name in KERNEL_MESSAGES:
            fields = expected.of(name)
            assert (name in frames) == (fields is not None), name
            if fields is not None:
                assert _payload(name, frames[name]) == LAYOUTS[name].encode(**fields), name
                said.add(name)

    for _ in range(80):  # The estimator aligns meanwhile.
        compare()
    flight.take_off()
    flight.command_int(
        mav.MAV_CMD_DO_REPOSITION, 6, -1, 1, 0, 0.8, round(47.4003e7), round(8.4997e7), 13.0
    )
    for _ in range(150):
        compare()
    assert said == set(KERNEL_MESSAGES)
    flight.plant.failures.fail_sensor("gnss", Failure.OFF)
    compare()


@pytest.mark.parametrize("personality", [PX4, ARDUPILOT], ids=lambda p: p.name)
def test_every_streamed_frame_is_one_of_pymavlinks_own(field, personality):
    flight = Flight(field, personality)
    flight.send("HEARTBEAT", 6, 8, 0, 0, 4, 3)
    seen = set()
    for _ in range(600):
        for name, frame in _frames_of(flight).items():
            assert _is_as_pymavlink_packs(name, frame), name
            seen.add(name)
    flight.close()
    assert len(seen) > 25


def test_a_diverged_estimate_is_not_told(flight):
    _stream_everything(flight)
    flight.become_ready()
    expected = set(KERNEL_MESSAGES) - {"POSITION_TARGET_LOCAL_NED"}
    targets = {"POSITION_TARGET_GLOBAL_INT", "NAV_CONTROLLER_OUTPUT"}
    assert set(_frames_of(flight)) >= expected - targets
    told = KernelInputs(flight.server._view)
    streamer = Streamer([LAYOUTS[name] for name in KERNEL_MESSAGES], told)
    place, attitude = KERNEL_MESSAGES.index("LOCAL_POSITION_NED"), KERNEL_MESSAGES.index("ATTITUDE")
    whole = KERNEL_MESSAGES.index("GLOBAL_POSITION_INT")
    position = flight.plant.filter["position_enu_m"]
    for wrong, is_told in ((1e30, True), (1e39, False), (math.inf, True), (math.nan, True)):
        position[0] = wrong
        assert bool(streamer.fill(place, flight.plant.time_us)) is is_told
        assert not streamer.fill(whole, flight.plant.time_us)
        assert streamer.fill(attitude, flight.plant.time_us)


def test_ticks_at_which_nothing_is_due_are_passed_over_and_nothing_else_changes(field, monkeypatch):
    """The twin looks at every tick; rates change and streams begin and end at any."""
    rng = random.Random(5)
    passing, looking = Flight(field), Flight(field)
    flights, calls = (passing, looking), []
    streamer = passing.server.telemetry._streamer
    told = streamer.stream
    monkeypatch.setattr(streamer, "stream", lambda *of: calls.append(1) or told(*of))
    for each in flights:
        each.send("REQUEST_DATA_STREAM", 1, 1, 0, 0, 0)
        for name in ("ALTITUDE", "ODOMETRY", "ATTITUDE_QUATERNION", "ATTITUDE_TARGET"):
            each.send("COMMAND_LONG", 1, 1, 511, 0, LAYOUTS[name].message_id, -1, 0, 0, 0, 0, 0)
    n_ticks, n_quiet, n_bytes = 1000, 0, 0
    for _ in range(n_ticks):
        if rng.random() < 0.05:
            name, interval_us = rng.choice(KERNEL_MESSAGES), rng.choice((-1, 66_667, 100_000, 1e6))
            asked = (511, 0, LAYOUTS[name].message_id, interval_us, 0, 0, 0, 0, 0)
            for each in flights:
                each.send("COMMAND_LONG", 1, 1, *asked)
        looking.server.telemetry._next_us = 0
        calls.clear()
        for each in flights:
            each.simulator.step()
        came, expected = (each.link.client.recv() for each in flights)
        assert came == expected
        n_quiet += not calls
        n_bytes += len(came)
    for each in flights:
        each.close()
    assert n_bytes > 0
    assert n_quiet > 0.1 * n_ticks


class _Told:
    """Streams what Python packs, of any message, to a partner that gets it in each tick."""

    def __init__(self, names, seed, way=1):
        self.layouts = [LAYOUTS[name] for name in names]
        self.streamer = Streamer(self.layouts, None)
        self.table = StreamTable("normal", [layout.message_id for layout in self.layouts])
        for layout in self.layouts:
            self.table.set_interval(layout.message_id, 20_000)
        ids = (7, 9)
        self.streamed = self.streamer.new_partner(self.table.partner, self.table.is_due, *ids)
        self.streamer.serve([self.streamed])
        self.rng, self.way, self.now_us = random.Random(seed), way, 0
        self.packed = {}

    def tick(self, sequence):
        self.now_us += 20_000
        self.packed.clear()
        self.streamed.serve(self.way, sequence)
        self.streamer.stream(self.now_us, self._pack)

    def _pack(self, index):
        layout = self.layouts[index]
        parts = tuple(
            self.rng.randbytes(self.rng.randint(0, layout.size)).ljust(layout.size, b"\0")
            for _ in range(self.rng.randint(0, MOST_PARTS))
        )
        assert index not in self.packed, "packed twice in a tick"
        self.packed[index] = parts
        return parts


def test_frames_of_a_tick_are_those_of_its_messages():
    told = _Told(list(LAYOUTS), 0)
    for sequence in (0, 200, 255):
        told.tick(sequence)
        ordered = [(i, part) for i, parts in sorted(told.packed.items()) for part in parts]
        one_by_one = [
            told.layouts[index].frame_v2(payload, (sequence + number) & 0xFF, 7, 9)
            for number, (index, payload) in enumerate(ordered)
        ]
        assert len(told.packed) == len(LAYOUTS)
        assert told.streamed.n_frames == len(one_by_one)
        assert told.streamed.frames == b"".join(one_by_one)


def test_a_partner_that_waits_gets_each_message_once_when_it_is_served_again():
    told = _Told(["ATTITUDE", "PING"], 0, way=0)
    for _ in range(5):
        told.tick(0)
        assert told.streamed.n_frames == 0
        assert not told.packed
    told.way = 1
    told.tick(0)
    assert sorted(told.packed) == [0, 1]
    assert told.streamed.n_frames == sum(map(len, told.packed.values()))


def test_who_is_sent_to_otherwise_has_what_is_due_and_no_frames():
    told = _Told(["ATTITUDE", "PING"], 0, way=2)
    told.tick(0)
    assert told.streamed.n_frames == 0
    assert told.streamed.take_due() == [0, 1]
    assert [tuple(told.streamer.payloads(index)) for index in (0, 1)] == [*told.packed.values()]
    assert told.streamed.take_due() == []


def test_a_tick_that_is_longer_than_a_datagram_is_divided_between_frames():
    datagrams = []
    channel = Channel(
        "test",
        lambda frames: datagrams.append(b"".join(frames)),
        profile="normal",
        clock=lambda: 0.0,
        is_datagram=True,
    )
    channel.lengthen_datagrams()
    told = _Told(list(LAYOUTS), 1)
    told.tick(channel.sequence)
    channel.stream(told.streamed.frames, told.streamed.n_frames)
    channel.flush()
    assert max(map(len, datagrams)) <= LONG_LOCAL_BYTES
    assert min(map(len, datagrams[:-1])) > LONG_LOCAL_BYTES / 2
    assert b"".join(datagrams) == told.streamed.frames
    frames = [frame for data in datagrams for frame in _split(data)]
    assert len(frames) == told.streamed.n_frames > 300
    assert channel.sequence == len(frames) & 0xFF
    assert len(Wire().decode(b"".join(datagrams))) == len(frames)


def test_what_is_asked_for_in_a_tick_does_not_make_its_stream_old(flight):
    flight.become_ready()
    flight.autopilot.set_home(None)
    told = KernelInputs(flight.server._view)
    streamer = Streamer([LAYOUTS["ALTITUDE"]], told)
    (before,) = streamer.fill(0, flight.plant.time_us)
    place = flight.autopilot.home.geodetic
    higher = Geodetic(place.latitude_deg, place.longitude_deg, place.altitude_m + 5.0)
    flight.autopilot.set_home(higher)
    table = StreamTable("normal", [LAYOUTS["ALTITUDE"].message_id])
    table.set_interval(LAYOUTS["ALTITUDE"].message_id, 20_000)
    streamed = streamer.new_partner(table.partner, table.is_due, 1, 1)
    streamed.serve(1, 0)
    streamer.serve([streamed])
    streamer.stream(flight.plant.time_us, lambda _: ())
    after = _payload("ALTITUDE", streamed.frames)
    then, now = (
        dict(zip(LAYOUTS["ALTITUDE"].fields, struct.unpack("<Q6f", payload), strict=True))
        for payload in (before, after)
    )
    assert now["altitude_relative"] == pytest.approx(then["altitude_relative"] - 5.0, abs=1e-3)


def test_two_partners_share_what_is_packed_once():
    told = _Told(["ATTITUDE", "PING", "HEARTBEAT"], 0)
    attitude, ping, heartbeat = told.table.ids
    told.table.set_interval(heartbeat, -1)
    other = StreamTable("normal", told.table.ids)
    for message_id, interval_us in ((attitude, -1), (ping, 20_000), (heartbeat, -1)):
        other.set_interval(message_id, interval_us)
    second = told.streamer.new_partner(other.partner, other.is_due, 7, 9)
    told.streamer.serve([told.streamed, second])
    for _ in range(20):
        second.serve(1, 3)
        told.tick(0)
        pings = told.packed[1]
        expected = [LAYOUTS["PING"].frame_v2(part, 3 + k, 7, 9) for k, part in enumerate(pings)]
        assert [*_split(second.frames)] == expected
