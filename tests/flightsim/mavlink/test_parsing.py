"""Whatever bytes come, valid frames come out and nothing grows."""

from hypothesis import given, settings
from hypothesis import strategies as st

from flightsim.mavlink.dialect import dialect, layout
from flightsim.mavlink.parsing import FrameParser

_PING = layout("PING")


def _frame(sequence: int, *, is_version_1: bool = False) -> bytes:
    payload = _PING.encode(time_usec=sequence * 0xFD, seq=sequence, target_system=1)
    build = _PING.frame_v1 if is_version_1 else _PING.frame_v2
    return build(payload, sequence & 0xFF, 255, 190)


def _take_all(parser: FrameParser) -> list[int]:
    messages, left = parser.take(100_000)
    assert left > 0
    return [message.seq for message in messages]


@given(data=st.binary(max_size=600), is_datagram=st.booleans())
@settings(max_examples=300)
def test_random_bytes_raise_nothing(data, is_datagram):
    parser = FrameParser()
    parser.feed(data, is_datagram=is_datagram)
    messages, left = parser.take(10_000)
    assert left > 0
    assert not is_datagram or parser.n_buffered == 0
    assert len(messages) <= len(data) // 12


@given(data=st.lists(st.sampled_from([0xFD, 0xFE, 0, 1, 9, 0xFF]), max_size=400))
def test_bytes_that_look_like_frames_raise_nothing(data):
    parser = FrameParser()
    parser.feed(bytes(data))
    parser.take(10_000)
    assert parser.n_buffered <= 300


@given(
    parts=st.lists(st.tuples(st.binary(max_size=40), st.booleans()), min_size=1, max_size=12),
    chunk=st.integers(1, 97),
)
@settings(max_examples=200)
def test_valid_frames_between_garbage_are_all_found_in_a_stream(parts, chunk):
    stream = b"".join(
        garbage + _frame(index, is_version_1=is_version_1)
        for index, (garbage, is_version_1) in enumerate(parts)
    )
    stream += bytes(300)  # lets a marker in the garbage complete its pretended frame
    parser = FrameParser()
    found: list[int] = []
    for start in range(0, len(stream), chunk):
        parser.feed(stream[start : start + chunk])
        found += _take_all(parser)
    assert found == list(range(len(parts)))


def test_frames_in_a_datagram_survive_a_truncated_one_before_them():
    parser = FrameParser()
    parser.feed(_frame(1)[:9] + _frame(2) + _frame(3), is_datagram=True)
    assert _take_all(parser) == [2, 3]


def test_a_datagram_starts_afresh():
    parser = FrameParser()
    parser.feed(_frame(1) + _frame(2)[:10], is_datagram=True)
    assert _take_all(parser) == [1]
    parser.feed(_frame(3), is_datagram=True)
    assert _take_all(parser) == [3]


def test_the_budget_bounds_the_work_and_the_rest_waits():
    parser = FrameParser()
    parser.feed(b"".join(map(_frame, range(10))))
    messages, left = parser.take(4)
    assert ([m.seq for m in messages], left) == ([0, 1, 2, 3], 0)
    assert _take_all(parser) == list(range(4, 10))


def test_garbage_costs_budget_too():
    parser = FrameParser()
    parser.feed(b"\xfd\x00\x00" * 4000)
    assert parser.take(50) == ([], 0)
    assert parser.n_bad == 50


def test_a_partner_that_never_completes_a_frame_fills_no_memory():
    parser = FrameParser()
    for _ in range(1000):
        parser.feed(b"\xfd\xff" + b"\xfe" * 1000)
        parser.take(1)
    assert parser.n_buffered <= 65_536


def test_damaged_unknown_and_unknowable_frames_are_passed_over():
    damaged = bytearray(_frame(1))
    damaged[-1] ^= 1
    unknown = bytearray(_frame(2))
    unknown[7:10] = (0xFFFF).to_bytes(3, "little")
    strange = bytearray(_frame(3))
    strange[2] = 0x80
    parser = FrameParser()
    parser.feed(bytes(damaged + unknown + strange) + _frame(4), is_datagram=True)
    assert _take_all(parser) == [4]


def test_the_version_is_that_of_the_last_frame():
    parser = FrameParser()
    parser.feed(_frame(1, is_version_1=True))
    parser.take(1)
    assert parser.is_version_1
    parser.feed(_frame(2))
    parser.take(1)
    assert not parser.is_version_1


def test_signed_frames_are_read_without_checking_the_signature():
    mav = dialect.MAVLink(None, 255, 190)
    mav.signing.secret_key = bytes(32)
    mav.signing.sign_outgoing = True
    frame = dialect.MAVLink_ping_message(1, 77, 0, 0).pack(mav)
    parser = FrameParser()
    parser.feed(bytes(frame) + _frame(78), is_datagram=True)
    assert _take_all(parser) == [77, 78]
