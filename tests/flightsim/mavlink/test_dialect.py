"""Layouts pack what pymavlink packs, byte for byte."""

import math
import struct

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pymavlink.dialects.v20 import ardupilotmega

from flightsim.mavlink.dialect import (
    LAYOUTS,
    LayoutError,
    UnknownMessageError,
    dialect,
    layout,
)

_INTEGERS = {
    "uint8_t": (0, 0xFF),
    "int8_t": (-0x80, 0x7F),
    "uint16_t": (0, 0xFFFF),
    "int16_t": (-0x8000, 0x7FFF),
    "uint32_t": (0, 0xFFFFFFFF),
    "int32_t": (-0x80000000, 0x7FFFFFFF),
    "uint64_t": (0, 2**64 - 1),
    "int64_t": (-(2**63), 2**63 - 1),
}


def _scalars(field_type: str):
    if field_type in _INTEGERS:
        return st.integers(*_INTEGERS[field_type])
    return st.floats(width=32, allow_nan=False)


@st.composite
def messages(draw):
    """A message class of the dialect with values for all its fields."""
    message_class = draw(st.sampled_from(sorted(dialect.mavlink_map.values(), key=lambda c: c.id)))
    values = {}
    for position, field in enumerate(message_class.fieldnames):
        order = message_class.orders[position]
        length = message_class.array_lengths[order]
        field_type = message_class.fieldtypes[position]
        if field_type == "char":
            values[field] = draw(st.binary(max_size=max(1, length)))
        elif length:
            scalars = _scalars(field_type)
            values[field] = draw(st.lists(scalars, min_size=length, max_size=length))
        else:
            values[field] = draw(_scalars(field_type))
    return message_class, values


@given(message=messages(), sequence=st.integers(0, 255), system_id=st.integers(1, 255))
@settings(max_examples=300)
def test_version_2_frames_equal_pymavlinks(message, sequence, system_id):
    message_class, values = message
    reference = dialect.MAVLink(None, system_id, 1)
    reference.seq = sequence
    found = LAYOUTS[message_class.msgname]
    frame = found.frame_v2(found.encode(**values), sequence, system_id, 1)
    assert frame == message_class(**values).pack(reference)


@given(message=messages(), place=st.integers(0, 300), change=st.integers(1, 255))
@settings(max_examples=300)
def test_payloads_come_back_from_version_2_frames_and_from_nothing_else(message, place, change):
    message_class, values = message
    found = LAYOUTS[message_class.msgname]
    payload = found.encode(**values)
    frame = found.frame_v2(payload, 7, 1, 1)
    assert found.payload_v2(frame) == payload
    assert found.pack(*found.unpack(payload)) == payload
    for other in (frame[:-1], frame + b"\0", frame + frame, frame[1:], b""):
        assert found.payload_v2(other) is None
    damaged = bytearray(frame)
    damaged[place % len(frame)] ^= change
    assert found.payload_v2(bytes(damaged)) is None
    assert layout("PING").payload_v2(frame) is None or found.name == "PING"


@given(message=messages())
@settings(max_examples=200)
def test_version_1_frames_decode_to_the_same_fields_without_extensions(message):
    message_class, values = message
    found = LAYOUTS[message_class.msgname]
    frame = found.frame_v1(found.encode(**values), 7, 1, 1)
    if message_class.id > 255:
        assert frame == b""
        return
    decoded = dialect.MAVLink(None).decode(bytearray(frame))
    assert len(frame) == 8 + found.base_size
    expected = message_class(**values)
    defaults = message_class.__init__.__defaults__ or ()
    n_extensions = getattr(message_class, "n_extensions", len(defaults))
    for field in message_class.fieldnames[: len(message_class.fieldnames) - n_extensions]:
        sent, received = getattr(expected, field), getattr(decoded, field)
        if isinstance(sent, str):
            sent, received = sent.rstrip("\0"), received.rstrip("\0")
        assert received == sent


def test_base_sizes_are_those_of_the_protocol_definition():
    # https://mavlink.io/en/messages/common.html, fields above the extension line
    sizes = {"GPS_RAW_INT": 30, "MISSION_ITEM_INT": 37, "COMMAND_ACK": 3, "BATTERY_STATUS": 36}
    assert {name: LAYOUTS[name].base_size for name in sizes} == sizes


def test_fields_not_named_are_zero_and_short_arrays_are_filled():
    found = layout("BATTERY_STATUS")
    decoded = dialect.MAVLink(None).decode(
        bytearray(found.frame_v2(found.encode(voltages=[1, 2]), 0, 1, 1))
    )
    assert decoded.voltages == [1, 2] + [0] * 8
    assert decoded.current_battery == 0


def test_a_wire_order_that_differs_from_the_dialect_is_refused():
    assert layout("SYSTEM_TIME", "time_unix_usec", "time_boot_ms").message_id == 2
    with pytest.raises(LayoutError, match="SYSTEM_TIME is packed as"):
        layout("SYSTEM_TIME", "time_boot_ms", "time_unix_usec")


def test_names_that_do_not_exist_are_refused():
    with pytest.raises(UnknownMessageError, match="NO_SUCH_MESSAGE"):
        layout("NO_SUCH_MESSAGE")
    with pytest.raises(LayoutError, match="no field"):
        layout("HEARTBEAT").encode(kind=2)
    with pytest.raises(LayoutError, match="does not fit"):
        layout("BATTERY_STATUS").encode(voltages=[0] * 11)


@given(message=messages(), excess=st.integers(1, 2**70), is_low=st.booleans())
def test_numbers_beyond_their_field_are_sent_as_the_end_of_its_range(message, excess, is_low):
    message_class, values = message
    found = LAYOUTS[message_class.msgname]
    fields = zip(message_class.fieldnames, message_class.fieldtypes, strict=True)
    ranges = {name: _INTEGERS[kind] for name, kind in fields if kind in _INTEGERS}
    ends = {name: low if is_low else high for name, (low, high) in ranges.items()}
    beyond = {name: end - excess if is_low else end + excess for name, end in ends.items()}
    arrays = {name: len(values[name]) for name in ranges if isinstance(values[name], list)}
    for name, length in arrays.items():
        ends[name], beyond[name] = [ends[name]] * length, [beyond[name]] * length
    assert found.encode(**(values | beyond)) == found.encode(**(values | ends))


def test_no_float_is_too_large_and_infinity_stays():
    attitude = LAYOUTS["ATTITUDE"]
    largest = dialect.MAVLink_attitude_message.unpacker.unpack(attitude.encode(roll=-1e300))[1]
    assert largest == -3.4028234663852886e38
    infinite = dialect.MAVLink_attitude_message.unpacker.unpack(attitude.encode(roll=math.inf))[1]
    assert infinite == math.inf


def test_what_is_no_number_of_its_field_is_refused():
    with pytest.raises(struct.error):
        LAYOUTS["MESSAGE_INTERVAL"].encode(interval_us=math.nan)


@pytest.mark.parametrize(
    ("name", "crc_extra"),
    [
        *(("ESC_INFO", 251), ("ESC_STATUS", 10), ("PROTOCOL_VERSION", 217)),
        *(("COMPONENT_METADATA", 182), ("EVENT", 160), ("CURRENT_EVENT_SEQUENCE", 106)),
        *(("REQUEST_EVENT", 33), ("RESPONSE_EVENT_ERROR", 77), ("PLAY_TUNE_V2", 110)),
    ],
)
def test_messages_that_pymavlink_lacks_have_the_checksum_that_mavlink_publishes(name, crc_extra):
    assert layout(name).crc_seed == bytes((crc_extra,))


@pytest.mark.parametrize("name", ["simstate", "rangefinder", "ekf_status_report"])
def test_messages_of_ardupilot_are_laid_out_as_its_dialect_has_them(name):
    theirs = getattr(ardupilotmega, f"MAVLink_{name}_message")
    ours = dialect.mavlink_map[theirs.id]
    for what in ("fieldnames", "ordered_fieldnames", "fieldtypes", "orders", "array_lengths"):
        assert getattr(ours, what) == getattr(theirs, what)
    assert (ours.crc_extra, ours.unpacker.format) == (theirs.crc_extra, theirs.unpacker.format)
    found = layout(name.upper())
    assert found.base_size == theirs.unpacker.size - 4 * (name == "ekf_status_report")
