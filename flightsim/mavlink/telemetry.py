"""Telemetry service: streams, intervals and single messages on request."""

from __future__ import annotations

import struct
from collections.abc import Callable, Collection, Mapping

from flightsim.mavlink.channel import Channel
from flightsim.mavlink.dialect import LAYOUTS, MESSAGE_NAMES, Layout
from flightsim.mavlink.framing import Framer
from flightsim.mavlink.parsing import Message
from flightsim.mavlink.service import Handler, Partners, send
from flightsim.mavlink.streams import StreamTable

Producer = Callable[[], bytes | tuple[bytes, ...] | None]
"""Packs a message of this tick, or the parts of one that comes in several; None if there is no data
yet."""

# Answered on request, never streamed.
_ON_REQUEST_ONLY = frozenset(
    {"AUTOPILOT_VERSION", "PROTOCOL_VERSION", "FLIGHT_INFORMATION", "COMPONENT_METADATA"}
)


class TelemetryService:
    """Streams to each partner at its own rates; a payload is packed once for all of them."""

    def __init__(
        self, producers: Mapping[str, Producer], partners: Partners, now_us: Callable[[], int]
    ) -> None:
        self._producers: dict[int, tuple[Layout, Producer]] = {
            LAYOUTS[name].message_id: (LAYOUTS[name], producer)
            for name, producer in producers.items()
        }
        self._streamed = [
            LAYOUTS[name].message_id for name in producers if name not in _ON_REQUEST_ONLY
        ]
        self._partners = partners
        self._now_us = now_us
        self._tables: dict[Channel, StreamTable] = {}
        self._framer = Framer([LAYOUTS[MESSAGE_NAMES[i]] for i in self._streamed])
        self._indexes = {message_id: index for index, message_id in enumerate(self._streamed)}
        self._packed: dict[int, tuple[bytes, ...]] = {}
        self._packed_us = -1
        self.handlers: Mapping[str, Handler] = {"REQUEST_DATA_STREAM": self._on_data_stream}

    @property
    def busy(self) -> Collection[Channel]:
        """All partners: each has streams."""
        return self._partners.channels

    def update(self, channel: Channel) -> None:
        """Send a partner all messages due at this tick."""
        now_us = self._now_us()
        if now_us != self._packed_us:
            self._packed_us = now_us
            self._packed.clear()
        packed = self._packed
        indexes: list[int] = []
        payloads: list[bytes] = []
        for message_id in self._table(channel).due(now_us):
            if message_id not in packed:
                packed[message_id] = self._pack(message_id)
            for payload in packed[message_id]:
                indexes.append(self._indexes[message_id])
                payloads.append(payload)
        if indexes:
            channel.stream(self._framer, indexes, payloads)

    def forget(self, channel: Channel) -> None:
        """Drop the rates of a partner that left."""
        self._tables.pop(channel, None)

    def send_now(self, channel: Channel, message_id: int) -> bool:
        """Send one message.

        Returns:
            False if the message is unknown or has no data yet.
        """
        if message_id not in self._producers:
            return False
        payloads = self._pack(message_id)
        for payload in payloads:
            channel.send(self._producers[message_id][0], payload)
        return len(payloads) > 0

    def is_known(self, message_id: int) -> bool:
        """Whether the message can be requested."""
        return message_id in self._producers

    def set_interval(self, channel: Channel, message_id: int, interval_us: float) -> bool:
        """Change one stream of one partner; False if the message is never streamed."""
        return self._table(channel).set_interval(message_id, interval_us)

    def send_interval(self, channel: Channel, message_id: int) -> bool:
        """Answer with MESSAGE_INTERVAL; False if there is no such message."""
        if message_id not in MESSAGE_NAMES:
            return False
        interval_us = self._table(channel).interval_us(message_id)
        if message_id not in self._streamed:
            interval_us = 0  # "not available"
        send(channel, "MESSAGE_INTERVAL", message_id=message_id, interval_us=interval_us)
        return True

    def broadcast(self, name: str) -> None:
        """Send one message to all partners, for a change that should reach them at once."""
        message_id = LAYOUTS[name].message_id
        for payload in self._pack(message_id):
            self._partners.broadcast(LAYOUTS[name], payload)

    def _on_data_stream(self, channel: Channel, message: Message) -> None:
        is_on = message.start_stop == 1
        self._table(channel).set_group(message.req_stream_id, message.req_message_rate, is_on=is_on)

    def _table(self, channel: Channel) -> StreamTable:
        table = self._tables.get(channel)
        if table is None:
            table = StreamTable(channel.profile, self._streamed, self._now_us())
            self._tables[channel] = table
        return table

    def _pack(self, message_id: int) -> tuple[bytes, ...]:
        try:
            payload = self._producers[message_id][1]()
        except (struct.error, ValueError, OverflowError):
            # A number that its field cannot hold (a diverged estimate) is not sent.
            return ()
        if payload is None:
            return ()
        return payload if isinstance(payload, tuple) else (payload,)
