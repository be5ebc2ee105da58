"""MAVLink message types as byte layouts, and frames from payloads.

A payload is packed once and shared by all partners; each partner then costs a header and a
checksum. Packing takes 4 to 6 us with pymavlink's message objects and 0.6 us with a layout.
"""

from __future__ import annotations

import math
import re
import struct
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

# `development` is `common` plus messages proposed for it, among them AVAILABLE_MODES.
from pymavlink.dialects.v20 import development as dialect

from flightsim.mavlink.supplement import SUPPLEMENT, SupplementaryMessage

MARKER_V2 = 0xFD
SIGNED_FLAG = 0x01
"""Flag of a MAVLink 2 frame that a signature follows."""
_V1_IDS = 256  # messages with greater ids exist in MAVLink 2 only

_Range = tuple[float, float]
_FLOAT32_MAX = 3.4028234663852886e38
_RANGES: Mapping[str, _Range] = {
    "f": (-_FLOAT32_MAX, _FLOAT32_MAX),
    "d": (-math.inf, math.inf),
    **{
        letter: (-(1 << bits - 1), (1 << bits - 1) - 1)
        for letter, bits in zip("bhiq", (8, 16, 32, 64), strict=True)
    },
    **{letter: (0, (1 << bits) - 1) for letter, bits in zip("BHIQ", (8, 16, 32, 64), strict=True)},
}
"""Least and greatest number for each letter of a struct format."""

_HEADER_V2 = struct.Struct("<6B3s")
"""Length, two bytes of flags, sequence, system, component and message, behind the marker."""
_HEADER_END = 1 + _HEADER_V2.size
_CHECKSUM = struct.Struct("<H")
# pymavlink has the fast checksum only where the package `fastcrc` is installed.
_crc16: Callable[[bytes], int] = dialect.mcrf4xx or (lambda data: dialect.x25crc(data).crc)


class UnknownMessageError(KeyError):
    """The dialect has no message of this name."""


class LayoutError(ValueError):
    """The field names are not the start of a message's wire order."""


class Layout:
    """Wire layout of one message type.

    Attributes:
        fields: Field names in wire order (larger types first, extensions last).
        letters: Letter of `struct` for each value as packed, arrays spread out; "s" is a text.
        size: Bytes of a payload as packed, before zeros at its end are cut.
        base_size: Bytes without the extension fields, all that MAVLink 1 carries.
    """

    def __init__(
        self,
        name: str,
        message_id: int,
        crc_extra: int,
        wire_format: str,
        fields: Sequence[str],
        lengths: Sequence[int],
        n_extensions: int,
    ) -> None:
        self.name = name
        self.message_id = message_id
        self.crc_seed = bytes((crc_extra,))
        self.fields = tuple(fields)
        self._struct = struct.Struct(wire_format)
        self._id_v2 = message_id.to_bytes(3, "little")
        self._defaults = self._struct.unpack(bytes(self._struct.size))
        self._places = dict(zip(self.fields, _places(self._defaults, lengths), strict=True))
        self.size = self._struct.size
        self.base_size = _size_without_last(wire_format, n_extensions)
        self.letters = _letters(wire_format)
        self.unpack: Callable[[bytes], tuple[Any, ...]] = self._struct.unpack
        """All values of a whole payload in wire order, arrays spread out."""
        self.pack: Callable[..., bytes] = self._struct.pack
        """Pack a payload from all values in wire order, arrays spread out.

        It raises `struct.error` or `OverflowError` if a number does not fit into its field.
        """

    def encode(self, **values: Any) -> bytes:
        """Pack a payload from named values; other fields are zero, text may be `str` or `bytes`.

        A number beyond the range of its field is sent as the end of that range.

        Raises:
            LayoutError: If the message has no such field, or an array is too long.
        """
        flat = list(self._defaults)
        for field, value in values.items():
            if field not in self._places:
                raise LayoutError(f"{self.name} has no field {field!r}; it has {self.fields}")
            place = self._places[field]
            if isinstance(place, int):
                flat[place] = value.encode() if isinstance(value, str) else value
            else:
                flat[place] = _filled(value, place.stop - place.start)
        # Most values fit. Clamping each one beforehand would cost every message.
        try:
            return self._struct.pack(*flat)
        except (struct.error, OverflowError):
            return self._struct.pack(*map(_clamped, flat, self.letters))

    @property
    def counts(self) -> Mapping[str, int]:
        """Number of values of each field in wire order; a text is one."""
        places = self._places.items()
        return {name: 1 if isinstance(p, int) else p.stop - p.start for name, p in places}

    def frame_v2(
        self, payload: bytes, sequence: int, system_id: int, component_id: int, flags: int = 0
    ) -> bytes:
        """Build a MAVLink 2 frame; trailing zeros of the payload are cut as the protocol allows.

        Args:
            payload: Content of the message, packed.
            sequence: Number of the frame, 0 to 255, by which a receiver counts losses.
            system_id: System id of the sender.
            component_id: Component id of the sender.
            flags: Incompatibility flags; 1 announces a signature, which the caller appends.
        """
        # One byte must stay, even if all are zero.
        payload = payload.rstrip(b"\0") or b"\0"
        ids = (sequence, system_id, component_id, self._id_v2)
        body = _HEADER_V2.pack(len(payload), flags, 0, *ids) + payload
        return b"\xfd" + body + _CHECKSUM.pack(_crc16(body + self.crc_seed))

    def payload_v2(self, data: bytes) -> bytes | None:
        """Return the payload of an unsigned MAVLink 2 frame, with its cut zeros restored.

        Args:
            data: Bytes of the frame.

        Returns:
            None if the bytes are anything but one whole frame of this message.
        """
        end = len(data) - _CHECKSUM.size
        if end < _HEADER_END or (data[0], data[1], data[2]) != (MARKER_V2, end - _HEADER_END, 0):
            return None
        if data[_HEADER_END - 3 : _HEADER_END] != self._id_v2:
            return None
        if _CHECKSUM.unpack_from(data, end)[0] != _crc16(data[1:end] + self.crc_seed):
            return None
        return data[_HEADER_END:end].ljust(self.size, b"\0")[: self.size]

    def frame_v1(self, payload: bytes, sequence: int, system_id: int, component_id: int) -> bytes:
        """Build a MAVLink 1 frame without extension fields.

        Args:
            payload: Content of the message, packed; it may be cut short or have extensions.
            sequence: Number of the frame, 0 to 255.
            system_id: System id of the sender.
            component_id: Component id of the sender.

        Returns:
            The frame; empty for message ids above 255, which MAVLink 1 has no room for.
        """
        if self.message_id >= _V1_IDS:
            return b""
        payload = payload[: self.base_size].ljust(self.base_size, b"\0")
        header = bytes((len(payload), sequence, system_id, component_id, self.message_id))
        body = header + payload
        # Markers: 0xFE begins a MAVLink 1 frame, 0xFD one of MAVLink 2.
        return b"\xfe" + body + _crc16(body + self.crc_seed).to_bytes(2, "little")


def number_range(letter: str) -> tuple[float, float]:
    """Return the least and the greatest number of a letter of a struct format."""
    return _RANGES[letter]


def _letters(wire_format: str) -> str:
    """Letter of each value of a struct format."""
    found = re.findall(r"(\d*)(\D)", wire_format[1:])
    return "".join(letter if letter == "s" else letter * int(count or 1) for count, letter in found)


def _clamped(value: Any, letter: str) -> Any:
    # NaN and infinity have a place in a float field; comparing them would destroy them.
    if letter == "s" or value != value or abs(value) == math.inf:  # noqa: PLR0124 - NaN
        return value
    least, most = _RANGES[letter]
    return max(least, min(most, value))


def _size_without_last(wire_format: str, n_fields: int) -> int:
    """Size of a struct format without its last n fields, each a letter with an optional count."""
    parts = re.findall(r"\d*\D", wire_format[1:])
    return struct.calcsize("<" + "".join(parts[: len(parts) - n_fields]))


def _places(defaults: Sequence[Any], lengths: Sequence[int]) -> Iterator[int | slice]:
    """Yield the place of each field among the values: an index, or a slice of an array."""
    start = 0
    for length in lengths:
        is_array = length > 1 and not isinstance(defaults[start], bytes)
        n_values = length if is_array else 1
        yield slice(start, start + n_values) if is_array else start
        start += n_values


def _filled(values: Sequence[Any], length: int) -> Sequence[Any]:
    """Return an array, filled up with zeros at its end."""
    if len(values) > length:
        raise LayoutError(f"an array of {len(values)} values does not fit into {length}")
    return (*values, *([0] * (length - len(values))))


def _layout_of(message_class: Any) -> Layout:
    is_ours = issubclass(message_class, SupplementaryMessage)
    # pymavlink's constructors have defaults for extension fields only
    defaults = message_class.__init__.__defaults__ or ()
    return Layout(
        message_class.msgname,
        message_class.id,
        message_class.crc_extra,
        message_class.unpacker.format,
        message_class.ordered_fieldnames,
        message_class.lengths,
        message_class.n_extensions if is_ours else len(defaults),
    )


# Messages that pymavlink's dialect lacks become known to its parser as well.
dialect.mavlink_map.update({message.id: message for message in SUPPLEMENT})

LAYOUTS: Mapping[str, Layout] = {
    message_class.msgname: _layout_of(message_class)
    for message_class in dialect.mavlink_map.values()
}
MESSAGE_NAMES: Mapping[int, str] = {layout.message_id: name for name, layout in LAYOUTS.items()}


def layout(name: str, *wire_order: str) -> Layout:
    """Return the layout of a message; state the wire order if values are packed by position.

    Args:
        name: Message name, such as "ATTITUDE".
        wire_order: All its fields in wire order, or none. A dialect that changes their order then
            fails at import, not in flight.

    Raises:
        UnknownMessageError: If the dialect has no such message.
        LayoutError: If `wire_order` is given and differs from the dialect.
    """
    if name not in LAYOUTS:
        raise UnknownMessageError(f"no message {name!r} in the MAVLink dialect")
    found = LAYOUTS[name]
    if wire_order and wire_order != found.fields:
        raise LayoutError(f"{name} is packed as {found.fields}, not {wire_order}")
    return found
