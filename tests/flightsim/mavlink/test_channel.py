"""A partner gets its own numbering, version and budget."""

from flightsim.mavlink.channel import Channel
from flightsim.mavlink.dialect import layout
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


def test_streams_wait_for_a_datagram_and_answers_take_them_along():
    datagrams = []
    channel = Channel(
        "test",
        lambda frames: datagrams.append([*Wire().decode(b"".join(frames))]),
        profile="normal",
        clock=lambda: 0.0,
        is_datagram=True,
    )

    def put(kind, number):
        if kind == "send":
            channel.send(_PING, _PING.encode(seq=number))
        else:
            frame = _PING.frame_v2(_PING.encode(seq=number), channel.sequence, 1, 1)
            channel.stream(frame, 1)

    put("stream", 1)
    channel.flush(5)
    assert datagrams == []
    put("send", 2)
    channel.flush(5)
    put("stream", 3)
    channel.flush(5)
    put("stream", 4)
    channel.flush()
    assert [[message.seq for message in datagram] for datagram in datagrams] == [[1, 2], [3, 4]]


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
