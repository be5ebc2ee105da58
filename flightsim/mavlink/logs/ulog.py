"""Bytes of a ULog file, the format of PX4's logs.

https://docs.px4.io/main/en/dev_log/ulog_file_format.html
"""

from __future__ import annotations

import struct
from collections.abc import Iterable, Mapping

_MAGIC = b"ULog\x01\x12\x35\x01"
_NO_FLAGS = bytes(40)
_HEADER = struct.Struct("<HB")
"""Size and kind of a message, before its bytes."""
_DATA = ord("D")
_STRUCT_LETTERS = {
    "uint64_t": "Q",
    "double": "d",
    "int32_t": "i",
    "uint32_t": "I",
    "float": "f",
    "uint16_t": "H",
    "uint8_t": "B",
    "bool": "?",
}


class Topic:
    """A message type of the log: its name and its fields, larger types first.

    A field is written as in ULog, such as `float[4] q`; the first is always the time.

    Attributes:
        size: Bytes of a sample in the file.
    """

    def __init__(self, name: str, *fields: str) -> None:
        self.name = name
        self.definition = f"{name}:" + "".join(
            f"{field};" for field in ("uint64_t timestamp", *fields)
        )
        self._struct = struct.Struct("<HBHQ" + "".join(map(_letters, fields)))
        self.size = self._struct.size

    def pack(self, message_id: int, time_us: int, *values: float) -> bytes:
        """Return the data message of one sample.

        Args:
            message_id: Number of the topic in this file.
            time_us: Time of the sample.
            values: Values of the fields behind the time; arrays are spread out.
        """
        return self._struct.pack(self.size - _HEADER.size, _DATA, message_id, time_us, *values)


def message(kind: bytes, payload: bytes) -> bytes:
    """Return a message of the file: its size, its type, its bytes.

    Args:
        kind: One letter, such as b"D" for data.
        payload: Content without the header.
    """
    return _HEADER.pack(len(payload), ord(kind)) + payload


def start(
    time_us: int,
    topics: Iterable[Topic],
    info: Mapping[str, str],
    parameters: Mapping[str, float],
) -> bytes:
    """Return everything before the data: header, formats, information, parameters, subscriptions.

    Args:
        time_us: Time at which the log begins.
        topics: Topics that are logged; the position is the message id.
        info: Texts by their keys, such as `sys_name`.
        parameters: Values by name; an `int` is written as one.
    """
    listed = tuple(topics)
    parts = [_MAGIC + struct.pack("<Q", time_us), message(b"B", _NO_FLAGS)]
    parts += [message(b"F", topic.definition.encode("ascii")) for topic in listed]
    for key, text in info.items():
        value = text.encode("ascii", "replace")
        parts.append(message(b"I", _keyed(f"char[{len(value)}] {key}", value)))
    for name, number in parameters.items():
        is_integer = isinstance(number, int)
        value = struct.pack("<i" if is_integer else "<f", number)
        parts.append(message(b"P", _keyed(f"{'int32_t' if is_integer else 'float'} {name}", value)))
    for message_id, topic in enumerate(listed):
        subscription = struct.pack("<BH", 0, message_id) + topic.name.encode("ascii")
        parts.append(message(b"A", subscription))
    return b"".join(parts)


def text(time_us: int, severity: int, line: str) -> bytes:
    """Return a line of text for people, with its syslog severity."""
    # ULog stores severities as the digits of printk.
    level = ord("0") + severity
    return message(b"L", struct.pack("<BQ", level, time_us) + line.encode("ascii", "replace"))


def _keyed(key: str, value: bytes) -> bytes:
    name = key.encode("ascii")
    return bytes((len(name),)) + name + value


def _letters(field: str) -> str:
    kind, _, size = field.split(maxsplit=1)[0].partition("[")
    return f"{size.rstrip(']')}{_STRUCT_LETTERS[kind]}"
