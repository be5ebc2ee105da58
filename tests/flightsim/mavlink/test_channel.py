"""A partner gets its own numbering, version and budget."""

import pytest

from flightsim.mavlink.channel import Channel
from flightsim.mavlink.dialect import layout
from flightsim.mavlink.outbox import LONG_BYTES, LONG_LOCAL_BYTES, MOST_WAITING, SHORT_BYTES
from tests.flightsim.mavlink.wire import Loop, Wire

_PING = layout("PING")
_AVAILABLE_MODES = layout("AVAILABLE_MODES")


def _pings(wire: Wire, count: int) -> list[bytes]:
    return [wire.encode("PING", 0, index, 0, 0) for index in range(count)]


def _datagram_channel() -> Channel:
    return Channel(
        "test",
        lambda _: None,
        profile="normal",
        clock=lambda: 0.0,
        is_datagram=True,
    )


def test_sequence_numbers_count_up_and_wrap():
    loop = Loop()
    for _ in range(258):
        loop.channel.send(_PING, _PING.encode())
    sequences = [message.get_seq() for message in loop.answers()]
    assert sequences == [*range(256), 0, 1]


def test_answers_come_in_the_version_that_the_partner_speaks():
    loop = Loop(is_version_1=True)
    loop.deliver("PING", 0, 0, 0, 0)
    loop.channel.send(_PING, _PING.encode())
    loop.channel.send(_AVAILABLE_MODES, _AVAILABLE_MODES.encode())  # has no MAVLink 1 id
    loop.channel.flush()
    assert loop.sent[0] == 0xFE
    assert [message.get_type() for message in loop.answers()] == ["PING"]


def test_version_2_is_spoken_to_who_has_said_nothing_yet():
    loop = Loop()
    loop.channel.send(_PING, _PING.encode())
    loop.channel.flush()
    assert loop.sent[0] == 0xFD
    assert not loop.channel.is_heard


class _Talk:
    """A channel whose datagrams are kept as the numbers of the pings in them."""

    def __init__(self, *, is_local=True):
        self.datagrams: list[list[int]] = []
        self.n_bytes = self.longest_bytes = 0
        self.channel = Channel(
            "test",
            self._write,
            profile="normal",
            clock=lambda: 0.0,
            is_datagram=True,
            is_local=is_local,
        )

    def _write(self, frames):
        joined = b"".join(frames)
        self.longest_bytes = max(self.longest_bytes, len(joined))
        self.n_bytes += len(joined)
        self.datagrams.append([message.seq for message in Wire().decode(joined)])

    def stream(self, *numbers):
        for number in numbers:
            frame = _PING.frame_v2(_PING.encode(seq=number), self.channel.sequence, 1, 1)
            self.channel.stream(frame, 1)

    def flush_answers(self):
        """Send, as the server does between bursts."""
        if not self.channel.can_wait:
            self.channel.flush()

    def answer(self, number):
        self.channel.send(_PING, _PING.encode(seq=number))


def test_streams_wait_for_a_burst_and_answers_take_them_along():
    talk = _Talk()
    talk.stream(1)
    talk.flush_answers()
    assert talk.datagrams == []
    talk.answer(2)
    talk.flush_answers()
    assert talk.datagrams == [[1, 2]]
    talk.stream(3, 4)
    talk.flush_answers()
    assert talk.datagrams == [[1, 2]]
    talk.channel.flush()
    assert talk.datagrams == [[1, 2], [3, 4]]
    talk.channel.flush()
    assert talk.datagrams == [[1, 2], [3, 4]]


def test_full_datagrams_leave_in_their_order_with_an_answer_behind_them():
    talk = _Talk()
    talk.stream(*range(1, 200))
    talk.flush_answers()
    assert talk.datagrams == []
    talk.answer(200)
    talk.flush_answers()
    assert len(talk.datagrams) > 3
    assert [number for datagram in talk.datagrams for number in datagram] == [*range(1, 201)]


def test_what_waits_for_a_burst_is_bounded_and_nothing_of_it_is_lost():
    talk = _Talk()
    queued = 0
    for number in range(1, 2001):
        talk.stream(number)
        queued += 12 + len(_PING.encode(seq=number).rstrip(b"\0"))
        assert queued - talk.n_bytes <= MOST_WAITING * SHORT_BYTES
    assert len(talk.datagrams) >= MOST_WAITING
    talk.channel.flush()
    assert [number for datagram in talk.datagrams for number in datagram] == [*range(1, 2001)]


@pytest.mark.parametrize(("is_local", "most"), [(True, LONG_LOCAL_BYTES), (False, LONG_BYTES)])
def test_datagrams_are_short_until_bursts_lengthen_them(is_local, most):
    talk = _Talk(is_local=is_local)
    talk.stream(*range(200))
    talk.channel.flush()
    assert SHORT_BYTES - 30 < talk.longest_bytes <= SHORT_BYTES
    talk.channel.lengthen_datagrams()
    talk.stream(*range(200, 400))
    talk.channel.flush()
    assert most - 30 < talk.longest_bytes <= most
    assert [number for datagram in talk.datagrams for number in datagram] == [*range(400)]


def test_who_reads_little_has_short_datagrams_whatever_comes():
    talk = _Talk()
    talk.channel.lengthen_datagrams()
    talk.stream(*range(100))
    talk.channel.keep_datagrams_short()
    assert talk.longest_bytes > SHORT_BYTES  # what was queued before
    talk.longest_bytes = 0
    talk.channel.lengthen_datagrams()
    talk.stream(*range(100, 300))
    talk.channel.flush()
    assert talk.longest_bytes <= SHORT_BYTES
    assert [number for datagram in talk.datagrams for number in datagram] == [*range(300)]


def test_what_has_no_datagrams_never_waits():
    written = []
    channel = Channel(
        "test", written.append, profile="normal", clock=lambda: 0.0, is_datagram=False
    )
    channel.stream(_PING.frame_v2(_PING.encode(), 0, 1, 1), 1)
    assert not channel.can_wait


def test_a_flood_of_datagrams_is_cut_to_the_budget_and_recovers():
    channel, wire = _datagram_channel(), Wire()
    for frame in _pings(wire, 2000):
        channel.receive(frame)
    assert len(channel.take_messages()) == 200
    assert channel.n_refused_bytes > 0
    for frame in _pings(wire, 2000):
        channel.receive(frame)
    assert len(channel.take_messages()) == 20


def test_a_stream_beyond_the_budget_waits_and_nothing_is_lost():
    loop = Loop()
    for frame in _pings(loop.wire, 1000):
        loop.channel.receive(frame)
    assert not loop.channel.has_room
    received = []
    for _ in range(50):
        received += loop.channel.take_messages()
    assert [message.seq for message in received] == list(range(1000))
    assert loop.channel.has_room
