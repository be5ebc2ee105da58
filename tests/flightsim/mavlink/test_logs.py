"""Flight logs: recorded while armed, read over MAVLink, and what pyulog finds in them."""

import io
import struct

import pytest

from flightsim.autopilot.modes import Mode
from flightsim.mavlink.logs import recorder
from flightsim.mavlink.logs.ulog import Topic
from tests.flightsim.mavlink.wire import named


def entries(flight):
    flight.send("LOG_REQUEST_LIST", 1, 1, 0, 0xFFFF)
    return named(flight.step(2), "LOG_ENTRY")


def download(flight, entry):
    data = bytearray(entry.size)
    flight.send("LOG_REQUEST_DATA", 1, 1, entry.id, 0, 0xFFFFFFFF)
    n_got = 0
    for _ in range(2000):
        for piece in named(flight.step(), "LOG_DATA"):
            assert piece.id == entry.id
            data[piece.ofs : piece.ofs + piece.count] = bytes(piece.data[: piece.count])
            n_got += piece.count
        if n_got >= entry.size:
            return bytes(data)
    raise AssertionError(f"{n_got} of {entry.size} bytes")


def read(data):
    """Messages of a ULog file, in order: (kind, payload)."""
    assert data[:8] == b"ULog\x01\x12\x35\x01"
    at = 16
    while at < len(data):
        size, kind = struct.unpack_from("<Hc", data, at)
        yield kind, data[at + 3 : at + 3 + size]
        at += 3 + size
    assert at == len(data)


def test_there_is_no_log_before_a_flight(flight):
    (entry,) = entries(flight)
    assert (entry.num_logs, entry.id) == (0, 0)


def test_a_flight_is_logged_and_downloaded_whole(flight):
    flight.take_off(4.0)
    (entry,) = entries(flight)
    assert (entry.id, entry.num_logs, entry.last_log_num) == (0, 1, 0)
    messages = list(read(download(flight, entry)))
    kinds = [kind for kind, _ in messages]
    n_topics = len(recorder._TOPICS)
    assert kinds[0] == b"B"
    assert kinds.count(b"F") == kinds.count(b"A") == n_topics
    assert kinds.count(b"P") == len(flight.autopilot.parameters)
    assert any(b"Takeoff detected" in payload for kind, payload in messages if kind == b"L")
    positions = [p for kind, p in messages if kind == b"D" and p[:2] == b"\0\0"]
    down = [struct.unpack_from("<Q7f", p, 2)[3] for p in positions]
    assert down[0] == pytest.approx(0.0, abs=0.3)
    assert down[-1] == pytest.approx(-4.0, abs=0.7)


def test_pyulog_reads_it(flight):
    pyulog = pytest.importorskip("pyulog", reason="pyulog is not among what tests need")
    flight.take_off(4.0)
    (entry,) = entries(flight)
    log = pyulog.ULog(io.BytesIO(download(flight, entry)))
    assert log.initial_parameters["MIS_TAKEOFF_ALT"] == 4.0
    height = -log.get_dataset("vehicle_local_position").data["z"]
    assert height.max() == pytest.approx(4.0, abs=0.7)
    assert {d.name for d in log.data_list} == {topic.name for topic in recorder._TOPICS}


def test_a_part_is_sent_where_it_lies_and_what_is_not_there_is_empty(flight):
    flight.take_off(2.0)
    (entry,) = entries(flight)
    whole = download(flight, entry)
    flight.send("LOG_REQUEST_DATA", 1, 1, 0, 450, 120)
    pieces = [bytes(m.data[: m.count]) for m in named(flight.step(3), "LOG_DATA")]
    assert b"".join(pieces) == whole[450:570]
    flight.send("LOG_REQUEST_DATA", 1, 1, 7, 450, 90)
    (piece,) = named(flight.step(2), "LOG_DATA")
    assert (piece.id, piece.ofs, piece.count) == (7, 450, 0)


def test_only_the_latest_logs_are_kept_and_none_grows_without_end(flight, monkeypatch):
    monkeypatch.setattr(recorder, "MAX_BYTES", 12_000)
    flight.become_ready()
    for _ in range(recorder.MAX_LOGS + 2):
        assert flight.command(400, 1) == 0
        flight.skip(4.0)
        assert flight.command(400, 0) == 0
        flight.step()
    told = entries(flight)
    assert len(told) == recorder.MAX_LOGS
    assert all(entry.size <= 12_000 for entry in told)
    assert list(read(download(flight, told[0])))
    flight.send("LOG_ERASE", 1, 1)
    (entry,) = entries(flight)
    assert entry.num_logs == 0


def test_a_topic_packs_its_fields_in_order():
    topic = Topic("thing", "float[2] xy", "uint8_t kind")
    assert topic.definition == "thing:uint64_t timestamp;float[2] xy;uint8_t kind;"
    packed = topic.pack(3, 20, 1.0, 2.0, 9)
    assert packed == struct.pack("<HcHQffB", 19, b"D", 3, 20, 1.0, 2.0, 9)


def test_every_mode_has_a_number_of_its_own_in_the_log():
    assert set(recorder._NAV_STATES) == set(Mode)
    assert len(set(recorder._NAV_STATES.values())) == len(Mode)
