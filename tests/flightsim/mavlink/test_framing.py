"""Frames that are built together are those that would be built one by one."""

import random

import pytest

from flightsim.mavlink.channel import DATAGRAM_BYTES, Channel
from flightsim.mavlink.dialect import LAYOUTS, layout
from flightsim.mavlink.framing import Framer
from tests.flightsim.mavlink.wire import Loop, Wire

FRAMER = Framer(list(LAYOUTS.values())[:256])


def _payload(rng: random.Random, size: int) -> bytes:
    """A payload that ends in any number of zeros."""
    return rng.randbytes(rng.randint(0, size)).ljust(size, b"\0")


@pytest.mark.parametrize("seed", range(100))
def test_frames_of_a_tick_are_those_of_its_messages(seed):
    rng = random.Random(seed)
    indexes = rng.sample(range(len(FRAMER.layouts)), rng.randint(1, 12))
    layouts = [FRAMER.layouts[index] for index in indexes]
    payloads = [_payload(rng, chosen.size) for chosen in layouts]
    first, system_id, component_id = rng.randrange(256), rng.randint(1, 255), rng.randint(1, 255)
    one_by_one = [
        chosen.frame_v2(payload, (first + number) & 0xFF, system_id, component_id)
        for number, (chosen, payload) in enumerate(zip(layouts, payloads, strict=True))
    ]
    ids = (first, system_id, component_id)
    assert FRAMER.frames_v2(bytes(indexes), b"".join(payloads), *ids) == b"".join(one_by_one)


def test_a_tick_that_is_longer_than_a_datagram_is_divided_between_frames():
    datagrams: list[bytes] = []
    channel = Channel(
        "test",
        lambda frames: datagrams.append(b"".join(frames)),
        profile="normal",
        clock=lambda: 0.0,
        is_datagram=True,
    )
    payloads = [b"\1" * chosen.size for chosen in FRAMER.layouts]
    channel.stream(FRAMER, range(len(payloads)), payloads)
    channel.flush()
    assert max(map(len, datagrams)) <= DATAGRAM_BYTES
    assert min(map(len, datagrams[:-1])) > DATAGRAM_BYTES / 3
    messages = [message for data in datagrams for message in Wire().decode(data)]
    # Without the few that pymavlink's own dialect lacks.
    came = [message.get_seq() for message in messages if message.get_type() in LAYOUTS]
    assert len(came) > 200
    assert came == sorted(came)


def test_a_partner_of_version_1_gets_streams_in_it():
    loop = Loop(is_version_1=True)
    loop.deliver("PING", 0, 0, 0, 0)
    framer = Framer([layout("ATTITUDE"), layout("ODOMETRY"), layout("VFR_HUD")])
    loop.channel.stream(framer, (0, 1, 2), [b"\1" * chosen.size for chosen in framer.layouts])
    answers = loop.answers()  # ODOMETRY has no MAVLink 1 id
    assert [message.get_type() for message in answers] == ["ATTITUDE", "VFR_HUD"]
    assert [message.get_seq() for message in answers] == [0, 1]
