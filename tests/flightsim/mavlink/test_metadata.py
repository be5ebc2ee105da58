"""Documents, events and the packed parameters, read as a ground station reads them."""

import json
import struct

import pytest

from flightsim.autopilot.modes import Mode
from flightsim.autopilot.parameters import PARAMETER_SPECS
from flightsim.mavlink.crc32 import crc32
from flightsim.mavlink.dialect import dialect as mav
from flightsim.mavlink.dialect import layout
from flightsim.mavlink.metadata import PackedParameters
from flightsim.mavlink.personalities import ARDUPILOT
from tests.flightsim.mavlink.conftest import Flight
from tests.flightsim.mavlink.wire import named

REQUEST = mav.MAV_CMD_REQUEST_MESSAGE
LIST, OPEN, READ, ACK = 3, 4, 5, 128
HEADER = struct.Struct("<HBBBBBxI")


def ftp(flight, opcode, data=b"", size=0, offset=0):
    """Opcode and data of the answer to one request."""
    request = HEADER.pack(1, 0, opcode, size or len(data), 0, 0, offset) + data
    flight.send("FILE_TRANSFER_PROTOCOL", 0, 1, 1, request.ljust(251, b"\0"))
    (answer,) = named(flight.step(), "FILE_TRANSFER_PROTOCOL")
    payload = bytes(answer.payload)
    _, _, answered, n_bytes, *_ = HEADER.unpack_from(payload)
    return answered, payload[HEADER.size : HEADER.size + n_bytes]


def read_file(flight, path):
    """A whole file."""
    answered, size = ftp(flight, OPEN, path.encode())
    assert answered == ACK
    (n_bytes,) = struct.unpack("<I", size)
    data = b""
    while len(data) < n_bytes:
        data += ftp(flight, READ, size=239, offset=len(data))[1]
    return data


def document(flight, uri):
    """A document and its checksum, by the address that the vehicle tells."""
    assert uri.startswith("mftp://")
    data = read_file(flight, uri.removeprefix("mftp://"))
    return json.loads(data), crc32(data)


def metadata(flight):
    """The general document."""
    assert flight.command(REQUEST, layout("COMPONENT_METADATA").message_id) == 0
    told = flight.last("COMPONENT_METADATA")
    general, checksum = document(flight, told.uri)
    assert checksum == told.file_crc
    return general


def further(flight, kind):
    """The document of a COMP_METADATA_TYPE."""
    (entry,) = [e for e in metadata(flight)["metadataTypes"] if e["type"] == kind]
    content, checksum = document(flight, entry["uri"])
    assert checksum == entry["fileCrc"]
    return content


def test_a_document_describes_each_parameter(flight):
    described = {entry["name"]: entry for entry in further(flight, 1)["parameters"]}
    assert list(described) == [spec.name for spec in PARAMETER_SPECS]
    speed = described["MPC_XY_CRUISE"]
    assert (speed["type"], speed["units"], speed["group"]) == ("Float", "m/s", "MPC")
    assert speed["min"] < speed["default"] < speed["max"]
    assert "min" not in described["CAL_ACC0_ID"]
    assert described["CAL_ACC0_ID"]["volatile"] is True


def events_of(flight):
    """Names of the events heard so far, by the vehicle's own document."""
    ((component, about),) = further(flight, 4)["components"].items()
    known = about["event_groups"]["default"]["events"]
    heard = named(flight.heard, "EVENT")
    assert {event.id >> 24 for event in heard} <= {int(component)}
    return [known[str(event.id & 0xFFFFFF)]["name"] for event in heard]


def test_a_flight_is_told_in_events(flight):
    flight.take_off(3.0)
    flight.autopilot.set_mode(Mode.LAND)
    flight.run_until(lambda: not flight.autopilot.is_armed)
    assert events_of(flight) == ["armed", "took_off", "landed", "disarmed"]
    assert [event.sequence for event in named(flight.heard, "EVENT")] == [0, 1, 2, 3]
    flight.run(5.0)
    assert flight.last("CURRENT_EVENT_SEQUENCE").sequence == 3


def test_a_failsafe_is_told_with_its_reason(flight):
    flight.take_off(3.0)
    flight.autopilot.parameters.set("COM_DL_LOSS_T", 5)
    flight.autopilot.parameters.set("NAV_DLL_ACT", 1)
    flight.run_until(lambda: flight.autopilot.failsafe is not None, limit_s=20.0)
    flight.step(2)
    assert events_of(flight)[-1] == "failsafe"
    about = further(flight, 4)["components"]["1"]
    entries = about["enums"]["failsafe_reason_t"]["entries"]
    told = named(flight.heard, "EVENT")[-1]
    assert entries[str(told.arguments[0])]["description"] == "ground station lost"
    assert told.log_levels == 0x44


def test_events_that_were_missed_are_told_again(flight):
    flight.take_off(3.0)
    flight.send("REQUEST_EVENT", 1, 1, 0, 1)
    again = named(flight.step(), "EVENT")
    assert [event.sequence for event in again] == [0, 1]
    flight.send("REQUEST_EVENT", 1, 1, 1, 7)
    came = flight.step()
    assert [event.sequence for event in named(came, "EVENT")] == [1]
    (refusal,) = named(came, "RESPONSE_EVENT_ERROR")
    assert (refusal.sequence, refusal.sequence_oldest_available) == (1, 0)


def unpacked(data):
    """Names and values of a packed file of parameters, as MAVProxy reads it."""
    magic, n_parameters, n_all = struct.unpack_from("<HHH", data)
    assert (magic, n_parameters) == (0x671B, n_all)
    values, before, start = {}, "", 6
    while start < len(data):
        kind, lengths = data[start] & 0xF, data[start + 1]
        end = start + 3 + (lengths >> 4)
        name = before[: lengths & 0xF] + data[start + 2 : end].decode()
        (values[name],) = struct.unpack_from({3: "<i", 4: "<f"}[kind], data, end)
        before, start = name, end + 4
    assert len(values) == n_all
    return values


@pytest.mark.parametrize("wish", ["", "?withdefaults=1"])
def test_all_parameters_come_as_one_file(flight, wish):
    flight.autopilot.parameters.set("MIS_TAKEOFF_ALT", 7.5)
    values = unpacked(read_file(flight, f"@PARAM/param.pck{wish}"))
    assert values == {name: flight.autopilot.parameters[name] for name in values}
    assert values["MIS_TAKEOFF_ALT"] == 7.5
    assert b"D@PARAM" in ftp(flight, LIST, b"/")[1]


def test_parameters_are_packed_anew_only_after_one_has_changed(flight):
    """To pack them takes as long as many answers, and a client may ask twenty times a tick."""
    parameters = flight.autopilot.parameters
    kept = PackedParameters(parameters)
    before = kept.file()
    assert kept.file() is before
    parameters.set("RTL_RETURN_ALT", 47.0)
    assert kept.file() == PackedParameters(parameters).file() != before
    assert unpacked(kept.file())["RTL_RETURN_ALT"] == 47.0
    parameters.set("RTL_RETURN_ALT", 47.0)
    after = kept.file()
    assert kept.file() is after


def test_ardupilot_packs_its_own_names_and_has_no_metadata(field):
    flight = Flight(field, ARDUPILOT)
    flight.send("HEARTBEAT", 6, 8, 0, 0, 4, 3)
    flight.step()
    values = unpacked(read_file(flight, "@PARAM/param.pck"))
    assert values["RTL_ALT"] == 1500
    assert "MIS_TAKEOFF_ALT" not in values
    # 1 and 2 are one choice of ours, so that only the client's number changes.
    for number in (1, 2):
        flight.send("PARAM_SET", 1, 1, b"FS_GCS_ENABLE", number, 9)
        flight.step()
        assert unpacked(read_file(flight, "@PARAM/param.pck"))["FS_GCS_ENABLE"] == number
    assert flight.command(REQUEST, layout("COMPONENT_METADATA").message_id) == 2
    flight.close()
