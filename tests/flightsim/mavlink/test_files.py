"""File transfer: what is there can be listed and read, and nothing else can."""

import struct
import zlib

import pytest

from tests.flightsim.mavlink.wire import named

ACK, NAK = 128, 129
TERMINATE, RESET, LIST, OPEN, READ, CRC, BURST = 1, 2, 3, 4, 5, 14, 15
END, NOT_FOUND, UNKNOWN, PROTECTED, NO_SESSION = 6, 10, 7, 9, 4


class Answer:
    def __init__(self, message):
        payload = bytes(message.payload)
        head = struct.unpack_from("<HBBBBBxI", payload)
        self.sequence, self.session, self.opcode, size, self.request, self.is_last, self.offset = (
            head
        )
        self.data = payload[12 : 12 + size]


def ask(flight, opcode, data=b"", *, offset=0, size=None, session=0, ticks=1):
    length = len(data) if size is None else size
    payload = struct.pack("<HBBBBBxI", 41, session, opcode, length, 0, 0, offset) + data
    flight.send("FILE_TRANSFER_PROTOCOL", 0, 1, 1, payload.ljust(251, b"\0"))
    return [Answer(m) for m in named(flight.step(ticks), "FILE_TRANSFER_PROTOCOL")]


@pytest.fixture
def flown(flight):
    """A vehicle with one log, which has landed since."""
    flight.become_ready()
    assert flight.command(400, 1) == 0
    flight.skip(2.0)
    assert flight.command(400, 0) == 0
    flight.step()
    return flight


def test_there_are_no_logs_before_a_flight(flight):
    (answer,) = ask(flight, LIST, b"/")
    assert (answer.opcode, answer.data) == (ACK, b"D@PARAM\0Dmetadata\0")
    (answer,) = ask(flight, LIST, b"/log")
    assert (answer.opcode, answer.data) == (NAK, bytes((NOT_FOUND,)))


def test_directories_and_files_are_listed_once(flown):
    size = len(flown.server._watching[0].logs[0].data)
    for root in (b"/", b"", b"."):
        (answer,) = ask(flown, LIST, root)
        assert (answer.opcode, answer.data) == (ACK, b"D@PARAM\0Dlog\0Dmetadata\0")
        assert (answer.sequence, answer.request) == (42, LIST)
    (answer,) = ask(flown, LIST, b"/log")
    assert answer.data == b"F0.ulg\t%d\0" % size
    (answer,) = ask(flown, LIST, b"/log", offset=1)
    assert (answer.opcode, answer.data) == (NAK, bytes((END,)))


def test_a_file_is_read_piece_by_piece_and_in_a_burst(flown):
    whole = bytes(flown.server._watching[0].logs[0].data)
    (answer,) = ask(flown, OPEN, b"/log/0.ulg")
    assert struct.unpack("<I", answer.data) == (len(whole),)
    (answer,) = ask(flown, READ, offset=100, size=50)
    assert (answer.offset, answer.data) == (100, whole[100:150])
    (answer,) = ask(flown, READ, offset=len(whole), size=50)
    assert (answer.opcode, answer.data) == (NAK, bytes((END,)))
    pieces = ask(flown, BURST, size=239, ticks=40)
    assert b"".join(piece.data for piece in pieces) == whole
    assert [piece.is_last for piece in pieces] == [0] * (len(pieces) - 1) + [1]
    assert [piece.sequence for piece in pieces] == list(range(42, 42 + len(pieces)))
    (answer,) = ask(flown, CRC, b"/log/0.ulg")
    assert struct.unpack("<I", answer.data)[0] == zlib.crc32(whole, 0xFFFFFFFF) ^ 0xFFFFFFFF


@pytest.mark.parametrize(
    "path",
    [b"../../etc/passwd", b"/etc/passwd", b"/log/../../etc/passwd", b"/log", b"", b"\xff" * 239],
)
def test_nothing_of_the_host_can_be_opened(flown, path):
    (answer,) = ask(flown, OPEN, path)
    assert (answer.opcode, answer.data) == (NAK, bytes((NOT_FOUND,)))


@pytest.mark.parametrize(
    ("opcode", "error"),
    [
        *((op, PROTECTED) for op in range(6, 14)),
        (READ, NO_SESSION),
        (BURST, NO_SESSION),
        (77, UNKNOWN),
    ],
)
def test_what_is_not_to_be_had_is_refused_well_formed(flown, opcode, error):
    (answer,) = ask(flown, opcode, b"/log/0.ulg", session=3)
    assert (answer.opcode, answer.data) == (NAK, bytes((error,)))
    assert (answer.session, answer.request) == (3, opcode)


@pytest.mark.parametrize("opcode", [TERMINATE, RESET])
def test_sessions_can_be_ended(flown, opcode):
    ask(flown, OPEN, b"/log/0.ulg")
    (answer,) = ask(flown, opcode)
    assert answer.opcode == ACK
    (answer,) = ask(flown, READ, size=10)
    assert (answer.opcode, answer.data) == (NAK, bytes((NO_SESSION,)))


def test_a_file_is_read_in_the_session_that_opened_it(flown):
    (opened,) = ask(flown, OPEN, b"/log/0.ulg", session=129)  # MAVProxy chooses the number.
    assert (opened.opcode, opened.session) == (ACK, 129)
    (answer,) = ask(flown, READ, size=50)
    assert (answer.opcode, answer.data) == (NAK, bytes((NO_SESSION,)))
    for opcode in (READ, BURST):
        answer, *_ = ask(flown, opcode, size=50, session=129)
        assert (answer.opcode, answer.session, answer.data[:4]) == (ACK, 129, b"ULog")


def test_the_end_of_one_session_leaves_the_next_open(flown):
    whole = bytes(flown.server._watching[0].logs[0].data)
    for session in (8, 9):
        ask(flown, OPEN, b"/log/0.ulg", session=session)
    (answer,) = ask(flown, TERMINATE, session=8)
    assert answer.opcode == ACK
    pieces = ask(flown, BURST, size=239, session=9, ticks=40)
    assert b"".join(piece.data for piece in pieces) == whole
    (answer,) = ask(flown, READ, size=10, session=8)
    assert (answer.opcode, answer.data) == (NAK, bytes((NO_SESSION,)))


def test_a_partner_may_have_eight_files_open(flown):
    opened = [ask(flown, OPEN, b"/log/0.ulg", session=session)[0].opcode for session in range(9)]
    assert opened == [ACK] * 8 + [NAK]
    (answer,) = ask(flown, OPEN, b"/log/0.ulg", session=3)
    assert answer.opcode == ACK
    ask(flown, RESET)
    (answer,) = ask(flown, OPEN, b"/log/0.ulg", session=8)
    assert answer.opcode == ACK


def test_an_answer_of_somebody_else_is_not_answered(flown):
    assert not ask(flown, ACK)
