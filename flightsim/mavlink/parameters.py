"""Parameter protocol: list, read, set, and a hash that saves ground stations the list.

PX4 carries integers bytewise in the float field, and ArduPilot casts them to floats:
https://mavlink.io/en/services/parameter.html. A refused value is answered with the present one,
because clients wait for a PARAM_VALUE.
"""

from __future__ import annotations

import struct
from collections.abc import Collection, Iterator, Mapping
from typing import Protocol

from flightsim.autopilot.events import Severity
from flightsim.autopilot.parameters import (
    ParameterError,
    ReadOnlyParameterError,
    UnknownParameterError,
)
from flightsim.mavlink.channel import Channel
from flightsim.mavlink.crc32 import crc32
from flightsim.mavlink.dialect import MARKER_V2, layout
from flightsim.mavlink.dialect import dialect as mav
from flightsim.mavlink.parsing import Message
from flightsim.mavlink.service import Handler, Partners, send
from flightsim.mavlink.statustext import StatustextSender

_PARAM_VALUE = layout(
    "PARAM_VALUE", "param_value", "param_count", "param_index", "param_id", "param_type"
)
_INTEGER_TYPES = range(1, 7)  # MAV_PARAM_TYPE of whole numbers: UINT8 to INT32
_NO_INDEX = 0xFFFF
_HASH_NAME = "_HASH_CHECK"
_LIST_PER_TICK = 8  # so that a list of hundreds shares the link with telemetry


class NamedParameters(Protocol):
    """Parameters by name and by index, as `flightsim.autopilot.parameters.Parameters` has them."""

    def __len__(self) -> int: ...

    def __iter__(self) -> Iterator[str]: ...

    def __getitem__(self, name: str, /) -> float: ...

    def is_integer(self, name: str) -> bool:
        """Return true if the parameter is a whole number."""
        ...

    def index(self, name: str) -> int:
        """Return the index of a parameter."""
        ...

    def name_at(self, index: int) -> str:
        """Return the name of the parameter with this index."""
        ...

    def set(self, name: str, value: float) -> float:
        """Change a parameter.

        Args:
            name: Name of the parameter.
            value: New value.

        Returns:
            The value as stored, rounded to 32 bits, which clients are sent.
        """
        ...


class ParameterService:
    """Answers requests for the autopilot's parameters; a list is sent in small batches."""

    def __init__(
        self,
        parameters: NamedParameters,
        partners: Partners,
        statustext: StatustextSender,
        *,
        has_bytewise_integers: bool = True,
    ) -> None:
        """Serve parameters.

        Args:
            parameters: The autopilot's parameters, or those of them that a flight stack names.
            partners: All partners, which get each changed value.
            statustext: Texts for people, with reasons of refusals.
            has_bytewise_integers: True sends integers bytewise as in PX4; false casts them to
                floats as ArduPilot does, which has no hash of its parameters either.
        """
        self._parameters = parameters
        self._has_bytewise_integers = has_bytewise_integers
        self._partners = partners
        self._statustext = statustext
        self._listing: dict[Channel, int] = {}
        self.handlers: Mapping[str, Handler] = {
            "PARAM_REQUEST_LIST": self._on_list,
            "PARAM_REQUEST_READ": self._on_read,
            "PARAM_SET": self._on_set,
        }

    @property
    def busy(self) -> Collection[Channel]:
        """Partners that are being sent the list."""
        return self._listing

    def update(self, channel: Channel) -> None:
        """Continue the list that a partner requested, by at most 8 parameters."""
        start = self._listing.get(channel)
        if start is None:
            return
        stop = min(start + _LIST_PER_TICK, len(self._parameters))
        for index in range(start, stop):
            self._send_value(channel, self._parameters.name_at(index))
        if stop == len(self._parameters):
            del self._listing[channel]
        else:
            self._listing[channel] = stop

    def forget(self, channel: Channel) -> None:
        """Stop the list of a partner that left."""
        self._listing.pop(channel, None)

    def _on_list(self, channel: Channel, _: Message) -> None:
        if self._has_bytewise_integers:
            # First: a ground station whose cache has this hash stops the list at once.
            self._send_hash(channel)
        self._listing[channel] = 0

    def _on_read(self, channel: Channel, message: Message) -> None:
        name = message.param_id
        if name == _HASH_NAME and self._has_bytewise_integers:
            self._send_hash(channel)
            return
        try:
            # An index of -1 means that the name counts.
            if message.param_index >= 0:
                name = self._parameters.name_at(message.param_index)
            self._send_value(channel, name)
        except UnknownParameterError:
            self._refuse(channel, message, message.param_index, mav.MAV_PARAM_ERROR_DOES_NOT_EXIST)

    def _on_set(self, channel: Channel, message: Message) -> None:
        name = message.param_id
        if name == _HASH_NAME:  # the ground station has cached the same parameters
            self.forget(channel)
            return
        try:
            self._parameters.set(name, self._received_value(message))
        except UnknownParameterError:
            self._refuse(channel, message, -1, mav.MAV_PARAM_ERROR_DOES_NOT_EXIST)
            return
        except ParameterError as error:
            self._statustext.broadcast(Severity.ERROR, str(error))
            reason = mav.MAV_PARAM_ERROR_VALUE_OUT_OF_RANGE
            if isinstance(error, ReadOnlyParameterError):
                reason = mav.MAV_PARAM_ERROR_READ_ONLY
            self._refuse(channel, message, self._parameters.index(name), reason)
            self._send_value(channel, name)
            return
        # Everybody gets the new value: several ground stations show the same table.
        for partner in self._partners.channels:
            self._send_value(partner, name)

    def _send_value(self, channel: Channel, name: str) -> None:
        is_integer = self._parameters.is_integer(name)
        value = self._parameters[name]
        is_bytewise = is_integer and self._has_bytewise_integers
        data = struct.pack("<i", int(value)) if is_bytewise else struct.pack("<f", value)
        self._send_bytes(
            channel,
            name,
            data,
            param_type=mav.MAV_PARAM_TYPE_INT32 if is_integer else mav.MAV_PARAM_TYPE_REAL32,
            index=self._parameters.index(name),
        )

    def _send_hash(self, channel: Channel) -> None:
        data = struct.pack("<I", parameter_hash(self._parameters))
        self._send_bytes(
            channel, _HASH_NAME, data, param_type=mav.MAV_PARAM_TYPE_UINT32, index=_NO_INDEX
        )

    def _send_bytes(
        self, channel: Channel, name: str, data: bytes, *, param_type: int, index: int
    ) -> None:
        count = len(self._parameters)
        payload = _PARAM_VALUE.pack(0.0, count, index, name.encode(), param_type)
        # The value is put in as bytes: a float of some integers would be a NaN, which may change.
        channel.send(_PARAM_VALUE, data + payload[4:])

    def _refuse(self, channel: Channel, message: Message, index: int, error: int) -> None:
        send(
            channel,
            "PARAM_ERROR",
            target_system=message.get_srcSystem(),
            target_component=message.get_srcComponent(),
            param_id=message.param_id.encode("ascii", "replace"),
            param_index=index,
            error=error,
        )

    def _received_value(self, message: Message) -> float:
        """Return the value of a message: the float as it is, or the bytes of an integer type.

        Clients that send integers as floats with a float type are understood as well.
        """
        if message.param_type not in _INTEGER_TYPES or not self._has_bytewise_integers:
            return message.param_value
        # Not through the decoded float: Python would change the bits of a signalling NaN.
        frame = message.get_msgbuf()
        # The value is the first field, behind the header of the version.
        start = 10 if frame[0] == MARKER_V2 else 6
        return struct.unpack("<i", frame[start : start + 4])[0]


def parameter_hash(parameters: NamedParameters) -> int:
    """Return the checksum of names and values in order, as PX4 computes it.

    A ground station compares it with that of its cache, and needs no list if both are equal.
    """
    crc = 0
    for name in parameters:
        value = parameters[name]
        is_integer = parameters.is_integer(name)
        data = struct.pack("<i", int(value)) if is_integer else struct.pack("<f", value)
        crc = crc32(name.encode() + data, crc)
    return crc
