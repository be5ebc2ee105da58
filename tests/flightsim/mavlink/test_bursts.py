"""At full speed the streams of several ticks leave in one burst, and answers never wait."""

import contextlib
import socket

import pytest

from flightsim.mavlink.links import UdpLink
from flightsim.mavlink.server import MavlinkServer
from flightsim.testbench import TestbenchCfg
from tests.flightsim.mavlink.wire import Wire, named


class _Listener:
    """A companion behind a socket, and a server that sends to it; ticked by hand."""

    def __init__(self, flight, ticks_per_burst):
        self.flight, self.wire = flight, Wire()
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
                data, self.vehicle = self.socket.recvfrom(65536)
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

        def listening(ticks_per_burst):
            listener = _Listener(flight, ticks_per_burst)
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


@pytest.mark.parametrize(
    ("options", "n_ticks"),
    [({"speed": "max"}, 10), ({"speed": 1.0}, 1), ({"speed": "max", "lockstep": True}, 1)],
)
def test_only_full_speed_without_lockstep_makes_bursts(options, n_ticks):
    assert TestbenchCfg(**options).ticks_per_burst == n_ticks
