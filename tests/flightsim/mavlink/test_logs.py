"""Flight logs: recorded while armed, read over MAVLink, and what pyulog finds in them."""

import io
import struct

import numpy as np
import pytest
import pyulog
from pyulog.px4 import PX4ULog
from pyulog.ulog2csv import convert_ulog2csv
from pyulog.ulog2kml import convert_ulog2kml

from flightsim.autopilot.modes import Mode
from flightsim.mavlink.logs import recorder
from flightsim.mavlink.logs.topics import NAV_STATES, SENSOR_COMBINED, InertialPacker
from flightsim.mavlink.logs.ulog import Topic
from flightsim.plant.record import HISTORY_DTYPE
from tests.flightsim.mavlink.wire import named

PX4_RATES_HZ = {
    "sensor_combined": 250,
    "vehicle_angular_velocity": 50,
    "vehicle_attitude": 20,
    "vehicle_local_position": 10,
    "trajectory_setpoint": 5,
    "estimator_status": 5,
}


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
    down = [struct.unpack_from("<3Q2d3f", p, 2)[7] for p in positions]
    assert down[0] == pytest.approx(0.0, abs=0.3)
    assert down[-1] == pytest.approx(-4.0, abs=0.7)


def test_pyulog_reads_it(flight):
    flight.take_off(4.0)
    (entry,) = entries(flight)
    log = pyulog.ULog(io.BytesIO(download(flight, entry)))
    assert log.initial_parameters["MIS_TAKEOFF_ALT"] == 4.0
    height = -log.get_dataset("vehicle_local_position").data["z"]
    assert height.max() == pytest.approx(4.0, abs=0.7)
    assert {d.name for d in log.data_list} == {topic.name for topic in recorder._TOPICS}
    for name, rate_hz in PX4_RATES_HZ.items():
        time_us = log.get_dataset(name).data["timestamp"]
        assert (len(time_us) - 1) / (time_us[-1] - time_us[0]) * 1e6 == pytest.approx(
            rate_hz, rel=0.05
        )


def test_what_is_demanded_and_measured_is_in_the_log(flight):
    """Tracking can be judged: set points beside what was flown, and what the motors got."""
    flight.take_off(4.0)
    flight.skip(4.0)
    (entry,) = entries(flight)
    log = pyulog.ULog(io.BytesIO(download(flight, entry)))
    flown = log.get_dataset("vehicle_local_position").data
    asked = log.get_dataset("vehicle_local_position_setpoint").data
    for name in ("x", "y", "z"):
        assert asked[name][-1] == pytest.approx(flown[name][-1], abs=0.3)
    assert flown["xy_valid"][-1] == 1
    attitude, wanted = (
        log.get_dataset(name).data for name in ("vehicle_attitude", "vehicle_attitude_setpoint")
    )
    agreement = sum(attitude[f"q[{i}]"][-1] * wanted[f"q_d[{i}]"][-1] for i in range(4))
    assert abs(agreement) == pytest.approx(1.0, abs=0.01)
    inertial = log.get_dataset("sensor_combined").data
    assert inertial["accelerometer_m_s2[2]"][-250:].mean() == pytest.approx(-9.8, abs=0.3)
    outputs = log.get_dataset("actuator_outputs").data
    assert outputs["noutputs"][-1] == 4
    assert all(1300 < outputs[f"output[{i}]"][-1] < 1900 for i in range(4))
    assert outputs["output[4]"][-1] == 0
    gps = log.get_dataset("vehicle_gps_position").data
    place = flight.frame.geodetic_from_enu(flight.plant.estimate.position_enu_m)
    assert gps["latitude_deg"][-1] == pytest.approx(place.latitude_deg, abs=1e-4)
    status = log.get_dataset("estimator_status").data
    assert 0 < status["pos_horiz_accuracy"][-1] < 2
    assert log.get_dataset("vehicle_status").data["system_type"][-1] == 2  # a quadrotor


def test_px4s_tools_open_it(flight, tmp_path):
    """What the commands ulog_info, ulog2csv and ulog2kml do."""
    flight.take_off(4.0)
    (entry,) = entries(flight)
    path = tmp_path / "flight.ulg"
    path.write_bytes(download(flight, entry))
    convert_ulog2csv(str(path), None, str(tmp_path), ",", None, None)
    assert (tmp_path / "flight_vehicle_attitude_setpoint_0.csv").exists()
    convert_ulog2kml(str(path), str(tmp_path / "flight.kml"))
    assert "<coordinates>" in (tmp_path / "flight.kml").read_text()
    log = PX4ULog(opened(path))
    assert log.get_mav_type() == "Quadrotor"


def opened(path):
    from pyulog import ULog  # only if it is there

    return ULog(str(path))


def test_every_inertial_sample_has_its_own_time():
    history = np.zeros(5, HISTORY_DTYPE)
    history["time_us"] = range(4000, 24_000, 4000)
    history["gyro_flu_radps"] = (1.0, 2.0, 3.0)
    packed = InertialPacker(7, history, 4000).pack()
    assert len(packed) == 5 * SENSOR_COMBINED.size
    second = packed[SENSOR_COMBINED.size : 2 * SENSOR_COMBINED.size]
    expected = SENSOR_COMBINED.pack(7, 8000, 1.0, -2.0, -3.0, 4000, 0.0, 0.0, 0.0, 4000, 0, 0)
    np.testing.assert_array_equal(
        np.frombuffer(second[13:], "<f4", 3), np.frombuffer(expected[13:], "<f4", 3)
    )
    assert second[:13] == expected[:13]


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
    monkeypatch.setattr(recorder, "MAX_BYTES", 120_000)
    flight.become_ready()
    for _ in range(recorder.MAX_LOGS + 2):
        assert flight.command(400, 1) == 0
        flight.skip(4.0)
        assert flight.command(400, 0) == 0
        flight.step()
    told = entries(flight)
    assert len(told) == recorder.MAX_LOGS
    assert all(entry.size <= 120_000 for entry in told)
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
    assert set(NAV_STATES) == set(Mode)
    assert len(set(NAV_STATES.values())) == len(Mode)
