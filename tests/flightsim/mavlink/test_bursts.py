"""At full speed the streams of several ticks leave in one burst, and answers never wait."""

import contextlib
import socket

import pytest

from flightsim.mavlink.dialect import dialect
from flightsim.mavlink.links import UdpLink
from flightsim.mavlink.server import MavlinkServer
from flightsim.testbench import TestbenchCfg
from tests.flightsim.mavlink.wire import Wire, named


class _Listener:
    """A companion behind a socket, and a server that sends to it; ticked by hand."""

    def __init__(self, flight, ticks_per_burst, reads_bytes):
        self.flight, self.wire, self.reads_bytes = flight, Wire(), reads_bytes
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind(("127.0.0.1", 0))
        self.socket.setblocking(False)
        port = self.socket.getsockname()[1]
        link = UdpLink(local_port=0, remote_port=port, profile="onboard")
        self.server = MavlinkServer(
            flight.autopilot, flight.plant, flight.frame, [link], ticks_per_burst=ticks_per_burst
        )
        self.heard = []
        self.vehicle = None

    def tick(self):
        """Run a tick; the number of datagrams that came of it."""
        self.flight.plant.advance()
        self.server.update()
        return self.hear()

    def hear(self):
        n_datagrams = 0
        with contextlib.suppress(BlockingIOError):
            while True:
                data, self.vehicle = self.socket.recvfrom(self.reads_bytes)
                self.heard += self.wire.decode(data)
                n_datagrams += 1
        return n_datagrams

    def of_the_autopilot(self):
        return [message for message in self.heard if message.get_srcComponent() == 1]

    def end(self):
        """Close the server, and hear what it still sends."""
        self.server.close()
        self.hear()


@pytest.fixture
def listen(flight):
    with contextlib.ExitStack() as stack:

        def listening(ticks_per_burst, reads_bytes=65536):
            listener = _Listener(flight, ticks_per_burst, reads_bytes)
            stack.callback(listener.socket.close)
            stack.callback(listener.server.close)
            return listener

        yield listening


def _is_whole(messages):
    """Whether the numbers of messages go on without a gap, from 0."""
    numbers = [message.get_seq() for message in messages]
    return numbers == [number % 256 for number in range(len(numbers))]


def test_streams_come_in_bursts_and_nothing_is_lost_at_the_end(listen):
    alone, together = listen(1), listen(10)
    n_alone = [alone.tick() for _ in range(98)]  # streams begin with the second tick
    n_together = [together.tick() for _ in range(98)]
    assert min(n_alone[1:]) >= 1
    assert {tick for tick, n in enumerate(n_together, start=1) if n} == set(range(10, 98, 10))
    assert max(n_together) > 1  # a companion's are full before
    assert sum(n_together) < 0.6 * sum(n_alone)
    for listener in (alone, together):
        listener.end()
        messages = listener.of_the_autopilot()
        assert _is_whole(messages)
        times_us = [message.time_usec for message in named(messages, "HIGHRES_IMU")]
        assert times_us == sorted(times_us)
        assert len(times_us) == 97


def test_an_answer_leaves_at_once_behind_the_streams_before_it(listen):
    listener = listen(10)
    while not listener.heard:
        listener.tick()
    assert [listener.tick() for _ in range(4)] == [0] * 4
    ping = listener.wire.encode("PING", 0, 7, 0, 0)
    listener.socket.sendto(ping, listener.vehicle)
    listener.heard.clear()
    for _ in range(3):  # At the first one that has read it.
        if listener.tick():
            break
    messages = listener.of_the_autopilot()
    assert len(named(messages, "PING")) == 1
    numbers = [message.get_seq() for message in messages]
    assert numbers == [(numbers[0] + k) % 256 for k in range(len(numbers))]
    assert len(named(messages, "HIGHRES_IMU")) >= 5


_MAVROS_READS = 296
_MAVSDK_READS = 2048


def _says(listener, kind):
    """Let a listener say by a heartbeat what it is, and the vehicle read it."""
    listener.tick()
    heartbeat = listener.wire.encode("HEARTBEAT", kind, 8, 0, 0, 4, 3)
    listener.socket.sendto(heartbeat, listener.vehicle)
    listener.tick()


@pytest.mark.parametrize("reads_bytes", [_MAVROS_READS, 512, 1120])
def test_who_reads_little_at_a_time_hears_all_that_comes_tick_by_tick(listen, reads_bytes):
    listener = listen(1, reads_bytes)
    for _ in range(150):
        listener.tick()
    listener.end()
    messages = listener.of_the_autopilot()
    assert _is_whole(messages)
    assert len(messages) > 500
    assert named(messages, "ODOMETRY")  # the longest


def test_a_companion_that_reads_little_hears_all_of_bursts_once_it_has_said_what_it_is(listen):
    listener = listen(10, _MAVROS_READS)
    while listener.vehicle is None:
        listener.tick()
    _says(listener, dialect.MAV_TYPE_ONBOARD_CONTROLLER)
    for _ in range(30):
        listener.tick()
    listener.heard.clear()
    for _ in range(100):
        listener.tick()
    messages = listener.of_the_autopilot()
    numbers = [message.get_seq() for message in messages]
    assert numbers == [(numbers[0] + k) % 256 for k in range(len(numbers))]
    assert len(messages) > 300


def test_others_read_long_datagrams_of_bursts_whole(listen):
    listener = listen(10, _MAVSDK_READS)
    while listener.vehicle is None:
        listener.tick()
    _says(listener, dialect.MAV_TYPE_GCS)
    n_datagrams = sum(listener.tick() for _ in range(100))
    assert n_datagrams <= 50
    listener.end()
    assert _is_whole(listener.of_the_autopilot())


@pytest.mark.parametrize(
    ("options", "n_ticks"),
    [({"speed": "max"}, 10), ({"speed": 1.0}, 1), ({"speed": "max", "lockstep": True}, 1)],
)
def test_only_full_speed_without_lockstep_makes_bursts(options, n_ticks):
    assert TestbenchCfg(**options).ticks_per_burst == n_ticks
