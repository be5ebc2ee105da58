"""Telemetry service: streams, intervals and single messages on request.

Several partners with different rates share the work: each message is packed once in a tick for all
of them. The most frequent messages are packed by a compiled kernel (`flightsim.mavlink.streaming`),
the others by Python producers.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Mapping, Sequence

from flightsim.mavlink.channel import Channel
from flightsim.mavlink.dialect import LAYOUTS, MESSAGE_NAMES
from flightsim.mavlink.faults import Faults
from flightsim.mavlink.parsing import Message
from flightsim.mavlink.service import Handler, Partners, send
from flightsim.mavlink.streaming import (
    KERNEL_MESSAGES,
    ONE_BY_ONE,
    KernelInputs,
    Streamed,
    Streamer,
)
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
        self,
        producers: Mapping[str, Producer],
        partners: Partners,
        now_us: Callable[[], int],
        faults: Faults,
        inputs: KernelInputs | None = None,
    ) -> None:
        """Prepare to send messages.

        Args:
            producers: Packing function of each message, by its name.
            partners: Partners that the streams go to.
            now_us: Simulated time.
            faults: Guards the packing of each message.
            inputs: The vehicle, for messages that the kernel packs; None sends those of `producers`
                alone.
        """
        names = (*producers, *(KERNEL_MESSAGES if inputs else ()))
        self._ids = frozenset(LAYOUTS[name].message_id for name in names)
        self._producers = {LAYOUTS[name].message_id: made for name, made in producers.items()}
        self._layouts = [LAYOUTS[name] for name in names if name not in _ON_REQUEST_ONLY]
        self._streamed = [layout.message_id for layout in self._layouts]
        self._indexes = {message_id: index for index, message_id in enumerate(self._streamed)}
        self._partners, self._now_us, self._faults = partners, now_us, faults
        self._streamer = Streamer(self._layouts, inputs)
        self._tables: dict[Channel, tuple[StreamTable, Streamed]] = {}
        self._served: Sequence[Channel] | None = None
        self._in_turn: Sequence[tuple[Channel, Streamed]] = ()
        self._next_us = 0
        """Time at which a message is due again, while neither rates nor partners change."""
        self.handlers: Mapping[str, Handler] = {"REQUEST_DATA_STREAM": self._on_data_stream}

    def update(self) -> None:
        """Send all partners the messages that are due at this tick."""
        channels = self._partners.channels
        if not channels:
            return
        # By identity: `MavlinkServer` makes a new list when partners come or go.
        if channels is not self._served:
            self._meet(channels)
        now_us = self._now_us()
        if now_us < self._next_us:  # in 46% of the ticks of a ground station alone
            for _, streamed in self._in_turn:
                streamed.let_pass(now_us)
            return
        for channel, streamed in self._in_turn:
            streamed.serve(channel.service_mode, channel.sequence)
        self._next_us = self._streamer.stream(now_us, self._pack_streamed)
        for channel, streamed in self._in_turn:
            frames = streamed.frames
            if frames:
                channel.stream(frames, streamed.n_frames)
            # Partners of MAVLink 1 or with signatures need frames of their own.
            elif streamed.service_mode == ONE_BY_ONE:
                self._send_one_by_one(channel, streamed)

    def forget(self, channel: Channel) -> None:
        """Drop the rates of a partner that left."""
        self._tables.pop(channel, None)
        self._served = None

    def send_now(self, channel: Channel, message_id: int) -> bool:
        """Send one message.

        Args:
            channel: The receiver.
            message_id: The message.

        Returns:
            False if the message is unknown or has no data yet.
        """
        if message_id not in self._ids:
            return False
        payloads = self._pack(message_id)
        for payload in payloads:
            channel.send(LAYOUTS[MESSAGE_NAMES[message_id]], payload)
        return len(payloads) > 0

    def is_known(self, message_id: int) -> bool:
        """Return true if the message can be requested."""
        return message_id in self._ids

    def set_interval(self, channel: Channel, message_id: int, interval_us: float) -> bool:
        """Change the interval of one stream of one partner.

        Args:
            channel: Link to the partner.
            message_id: Message to stream.
            interval_us: Time between two of them; as in MAVLink 0 is the default and -1 none.

        Returns:
            False if the message is never streamed.
        """
        # The calendar has changed: look at all partners in the next tick.
        self._next_us = 0
        return self._table(channel)[0].set_interval(message_id, interval_us)

    def send_interval(self, channel: Channel, message_id: int) -> bool:
        """Answer a partner's question for an interval with MESSAGE_INTERVAL.

        Args:
            channel: Link to the partner.
            message_id: Message asked about.

        Returns:
            False if there is no such message; nothing is sent then.
        """
        if message_id not in MESSAGE_NAMES:
            return False
        interval_us = self._table(channel)[0].interval_us(message_id)
        if message_id not in self._indexes:
            interval_us = 0  # "not available"
        send(channel, "MESSAGE_INTERVAL", message_id=message_id, interval_us=interval_us)
        return True

    def broadcast(self, name: str) -> None:
        """Send one message to all partners, for a change that should reach them at once."""
        for payload in self._pack(LAYOUTS[name].message_id):
            self._partners.broadcast(LAYOUTS[name], payload)

    def _on_data_stream(self, channel: Channel, message: Message) -> None:
        self._next_us = 0
        is_on, table = message.start_stop == 1, self._table(channel)[0]
        table.set_group(message.req_stream_id, message.req_message_rate, is_on=is_on)

    def _meet(self, channels: Sequence[Channel]) -> None:
        """Serve these partners from now on."""
        self._served, self._next_us = channels, 0
        self._in_turn = [(channel, self._table(channel)[1]) for channel in channels]
        self._streamer.serve([streamed for _, streamed in self._in_turn])

    def _table(self, channel: Channel) -> tuple[StreamTable, Streamed]:
        known = self._tables.get(channel)
        if known is None:
            table = StreamTable(channel.profile, self._streamed, self._now_us())
            ids = (channel.system_id, channel.component_id)
            streamed = self._streamer.new_partner(table.partner, table.is_due, *ids)
            known = self._tables[channel] = (table, streamed)
        return known

    def _send_one_by_one(self, channel: Channel, streamed: Streamed) -> None:
        """Send due messages to a partner of MAVLink 1, or to one whose frames are signed."""
        for index in streamed.take_due():
            for payload in self._streamer.payloads(index):
                channel.stream_one(self._layouts[index], payload)

    def _pack_streamed(self, index: int) -> tuple[bytes, ...]:
        with self._faults:
            return self._packed(self._streamed[index])
        return ()

    def _pack(self, message_id: int) -> tuple[bytes, ...]:
        if message_id not in self._producers:
            return self._streamer.fill(self._indexes[message_id], self._now_us())
        return self._packed(message_id)

    def _packed(self, message_id: int) -> tuple[bytes, ...]:
        try:
            payload = self._producers[message_id]()
        except (struct.error, ValueError, OverflowError):
            # A number that its field cannot hold, as of a diverged estimate, is not sent.
            return ()
        if payload is None:
            return ()
        return payload if isinstance(payload, tuple) else (payload,)
