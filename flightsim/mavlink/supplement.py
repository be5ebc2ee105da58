"""Messages that the dialects of pymavlink lack: declared here, read and packed like the others.

Most belong to MAVLink's `common`. The last ones belong to ArduPilot's own dialect, whose thousands
of lines need not be loaded for them. pymavlink's dialect file is not changed, so that its updates
need no merge.
"""

from __future__ import annotations

import re
import struct
from typing import Any

from pymavlink.dialects.v20 import development as dialect
from pymavlink.generator.mavcrc import x25crc

_LETTERS = {
    "double": "d",
    "uint64_t": "Q",
    "int64_t": "q",
    "float": "f",
    "uint32_t": "I",
    "int32_t": "i",
    "uint16_t": "H",
    "int16_t": "h",
    "uint8_t": "B",
    "int8_t": "b",
    "char": "s",
}
_FIELD = re.compile(r"(\w+?)(?:\[(\d+)\])? (\w+)")


class SupplementaryMessage(dialect.MAVLink_message):
    """A message as pymavlink reads and packs it; its members are named as pymavlink wants them."""

    id: int
    msgname: str
    fieldnames: list[str]
    ordered_fieldnames: list[str]
    n_extensions: int
    crc_extra: int
    unpacker: struct.Struct

    def __init__(self, *values: Any, **named: Any) -> None:
        super().__init__(self.id, self.msgname)
        self._fieldnames = self.fieldnames
        given = dict(zip(self.fieldnames, values, strict=False), **named)
        self._given: dict[str, Any] = given
        vars(self).update({name: _readable(value) for name, value in given.items()})

    def pack(self, mav: Any, force_mavlink1: bool = False) -> bytes:
        """Return the frame of the message, as pymavlink's `MAVLink.send` calls it."""
        values: list[Any] = []
        for name in self.ordered_fieldnames:
            value = self._given.get(name, 0)
            values += value if isinstance(value, list | tuple) else [value]
        return self._pack(mav, self.crc_extra, self.unpacker.pack(*values), force_mavlink1)


def _readable(value: Any) -> Any:
    """Return a text as `str`, as pymavlink's messages have it, and a number as it is."""
    if isinstance(value, bytes):
        return value.split(b"\0", 1)[0].decode("ascii", "replace")
    return value


def message(
    name: str, message_id: int, *fields: str, extensions: tuple[str, ...] = ()
) -> type[SupplementaryMessage]:
    """Make the class of a message from its definition.

    Args:
        name: Name of the message.
        message_id: Its number.
        fields: Type and name of each field in the order of the definition: "uint8_t[40] arguments".
        extensions: Fields that only MAVLink 2 carries, written in the same form.

    Returns:
        The class. It must also enter pymavlink's table of messages.
    """
    parsed = [_parsed(field) for field in fields]
    # https://mavlink.io/en/guide/serialization.html: larger types first, extensions last.
    wire = sorted(parsed, key=lambda field: -_size(field[0])) + [_parsed(e) for e in extensions]
    names = [field for *_, field in (*parsed, *wire[len(parsed) :])]
    wire_names = [field for *_, field in wire]
    counts = [count for _, count, _ in wire]
    letters = [f"{count or ''}{_LETTERS[kind]}" for kind, count, _ in wire]
    # A text is one value for `struct`, an array many.
    lengths = [1 if kind == "char" else count or 1 for kind, count, _ in wire]
    return type(
        name,
        (SupplementaryMessage,),
        {
            "id": message_id,
            "msgname": name,
            "fieldnames": names,
            "ordered_fieldnames": wire_names,
            "fieldtypes": [kind for kind, *_ in (*parsed, *wire[len(parsed) :])],
            "orders": [wire_names.index(field) for field in names],
            "lengths": lengths,
            "array_lengths": counts,
            "n_extensions": len(extensions),
            "crc_extra": _crc_extra(name, wire[: len(parsed)]),
            "unpacker": struct.Struct("<" + "".join(letters)),
        },
    )


def _parsed(field: str) -> tuple[str, int, str]:
    """Return type, length of the array or 0, and name of a field."""
    found = _FIELD.fullmatch(field)
    assert found is not None, field
    kind, count, name = found.groups()
    return kind, int(count or 0), name


def _size(kind: str) -> int:
    return struct.calcsize("<" + _LETTERS[kind])


def _crc_extra(name: str, wire: list[tuple[str, int, str]]) -> int:
    """Return the seed of the checksum: https://mavlink.io/en/guide/serialization.html#crc_extra."""
    crc = x25crc()
    crc.accumulate_str(f"{name} ")
    for kind, count, field in wire:
        crc.accumulate_str(f"{kind} {field} ")
        if count:
            crc.accumulate([count])
    return (crc.crc & 0xFF) ^ (crc.crc >> 8)


SUPPLEMENT = (
    # Deprecated in 2024; PX4 still answers with it.
    message(
        "PROTOCOL_VERSION",
        300,
        *("uint16_t version", "uint16_t min_version", "uint16_t max_version"),
        *("uint8_t[8] spec_version_hash", "uint8_t[8] library_version_hash"),
    ),
    message(
        "PLAY_TUNE_V2",
        400,
        *("uint8_t target_system", "uint8_t target_component", "uint32_t format"),
        "char[248] tune",
    ),
    message(
        "COMPONENT_METADATA",
        397,
        *("uint32_t time_boot_ms", "uint32_t file_crc", "char[100] uri"),
    ),
    message(
        "EVENT",
        410,
        *("uint8_t destination_component", "uint8_t destination_system", "uint32_t id"),
        *("uint32_t event_time_boot_ms", "uint16_t sequence", "uint8_t log_levels"),
        "uint8_t[40] arguments",
    ),
    message("CURRENT_EVENT_SEQUENCE", 411, "uint16_t sequence", "uint8_t flags"),
    message(
        "REQUEST_EVENT",
        412,
        *("uint8_t target_system", "uint8_t target_component"),
        *("uint16_t first_sequence", "uint16_t last_sequence"),
    ),
    message(
        "RESPONSE_EVENT_ERROR",
        413,
        *("uint8_t target_system", "uint8_t target_component", "uint16_t sequence"),
        *("uint16_t sequence_oldest_available", "uint8_t reason"),
    ),
    message(
        "ESC_INFO",
        290,
        *("uint8_t index", "uint64_t time_usec", "uint16_t counter", "uint8_t count"),
        *("uint8_t connection_type", "uint8_t info", "uint16_t[4] failure_flags"),
        *("uint32_t[4] error_count", "int16_t[4] temperature"),
    ),
    message(
        "ESC_STATUS",
        291,
        *("uint8_t index", "uint64_t time_usec", "int32_t[4] rpm"),
        *("float[4] voltage", "float[4] current"),
    ),
    # From ArduPilot's dialect.
    message(
        "SIMSTATE",
        164,
        *(f"float {name}" for name in ("roll", "pitch", "yaw", "xacc", "yacc", "zacc")),
        *("float xgyro", "float ygyro", "float zgyro", "int32_t lat", "int32_t lng"),
    ),
    message("RANGEFINDER", 173, "float distance", "float voltage"),
    message(
        "EKF_STATUS_REPORT",
        193,
        *("uint16_t flags", "float velocity_variance", "float pos_horiz_variance"),
        *("float pos_vert_variance", "float compass_variance", "float terrain_alt_variance"),
        extensions=("float airspeed_variance",),
    ),
    message(
        "DIGICAM_CONTROL",
        155,
        *("uint8_t target_system", "uint8_t target_component", "uint8_t session"),
        *("uint8_t zoom_pos", "int8_t zoom_step", "uint8_t focus_lock", "uint8_t shot"),
        *("uint8_t command_id", "uint8_t extra_param", "float extra_value"),
    ),
    message(
        "MOUNT_CONFIGURE",
        156,
        *("uint8_t target_system", "uint8_t target_component", "uint8_t mount_mode"),
        *("uint8_t stab_roll", "uint8_t stab_pitch", "uint8_t stab_yaw"),
    ),
    message(
        "MOUNT_CONTROL",
        157,
        *("uint8_t target_system", "uint8_t target_component"),
        *("int32_t input_a", "int32_t input_b", "int32_t input_c", "uint8_t save_position"),
    ),
    message(
        "MOUNT_STATUS",
        158,
        *("uint8_t target_system", "uint8_t target_component"),
        *("int32_t pointing_a", "int32_t pointing_b", "int32_t pointing_c"),
        extensions=("uint8_t mount_mode",),
    ),
    # No service here uses these. They are read in order to answer that they are ignored.
    message(
        "FENCE_POINT",
        160,
        *("uint8_t target_system", "uint8_t target_component", "uint8_t idx", "uint8_t count"),
        *("float lat", "float lng"),
    ),
    message(
        "FENCE_FETCH_POINT",
        161,
        *("uint8_t target_system", "uint8_t target_component", "uint8_t idx"),
    ),
    message(
        "RALLY_POINT",
        175,
        *("uint8_t target_system", "uint8_t target_component", "uint8_t idx", "uint8_t count"),
        *("int32_t lat", "int32_t lng", "int16_t alt", "int16_t break_alt"),
        *("uint16_t land_dir", "uint8_t flags"),
    ),
    message(
        "RALLY_FETCH_POINT",
        176,
        *("uint8_t target_system", "uint8_t target_component", "uint8_t idx"),
    ),
    message(
        "LED_CONTROL",
        186,
        *("uint8_t target_system", "uint8_t target_component", "uint8_t instance"),
        *("uint8_t pattern", "uint8_t custom_len", "uint8_t[24] custom_bytes"),
    ),
    message(
        "VISION_POSITION_DELTA",
        11011,
        *("uint64_t time_usec", "uint64_t time_delta_usec"),
        *("float[3] angle_delta", "float[3] position_delta", "float confidence"),
    ),
)
