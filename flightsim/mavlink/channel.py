"""State of a conversation with one partner: received and outgoing bytes, and limits on both."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from flightsim.mavlink.dialect import Layout
from flightsim.mavlink.parsing import FrameParser, Message
from flightsim.mavlink.streams import Profile

Write = Callable[[Sequence[bytes]], None]
"""Sends frames, drops what the transport cannot take, never blocks and never raises."""

Clock = Callable[[], float]
"""Seconds for protocol timeouts: wall time behind a socket, simulated time in lockstep."""

# A ground station sends 1 to 100 messages per second, a mission upload one per round trip.
_REFILL_PER_TICK = 20
_BURST = 200
_STREAM_BACKLOG_BYTES = 16_384


class Channel:
    """One partner: a UDP address, a TCP connection or the in-process client.

    Every partner has its own sequence numbers, MAVLink version and budget.
    """

    def __init__(
        self, name: str, write: Write, *, profile: Profile, clock: Clock, is_datagram: bool
    ) -> None:
        self.name = name
        self.profile: Profile = profile
        self.clock = clock
        self.is_open = True
        self.system_id = 1
        self.component_id = 1
        """Component id in outgoing frames."""
        self.n_sent = 0
        self.n_refused_bytes = 0
        self._parser = FrameParser()
        self._write = write
        self._is_datagram = is_datagram
        self._sequence = 0
        self._budget = _BURST
        self._inbox: list[Message] = []
        self._frames: list[bytes] = []
        self._can_wait = True
        """Whether all queued frames are of streams."""

    @property
    def n_received(self) -> int:
        """Number of valid messages that came from this partner."""
        return self._parser.n_messages

    @property
    def is_heard(self) -> bool:
        """Whether a valid message ever came from this partner."""
        return self.n_received > 0

    @property
    def has_room(self) -> bool:
        """Whether the channel accepts more bytes; the excess of a stream stays in the kernel."""
        return self._parser.n_buffered < _STREAM_BACKLOG_BYTES

    def receive(self, data: bytes) -> None:
        """Accept bytes from the partner; datagrams beyond its budget are discarded unread."""
        if self._is_datagram and self._budget <= 0:
            self.n_refused_bytes += len(data)
            return
        self._parser.feed(data, is_datagram=self._is_datagram)
        if self._is_datagram:
            self._collect()

    def take_messages(self) -> list[Message]:
        """Messages since the last call, up to the partner's budget; call once per tick."""
        if not self._is_datagram:
            self._collect()
        self._budget = min(_BURST, self._budget + _REFILL_PER_TICK)
        messages = self._inbox
        if messages:
            self._inbox = []
        return messages

    def put_back(self, messages: Sequence[Message]) -> None:
        """Return messages that are to be taken later, before all that come after them."""
        self._inbox = [*messages, *self._inbox]

    def _collect(self) -> None:
        messages, self._budget = self._parser.take(self._budget)
        self._inbox += messages

    def send(self, layout: Layout, payload: bytes) -> None:
        """Queue a message, in the partner's version of MAVLink, for the next flush."""
        self._can_wait = False
        self.stream(layout, payload)

    def stream(self, layout: Layout, payload: bytes) -> None:
        """Queue a message like `send`, but one that may wait to share a datagram with others."""
        build = layout.frame_v1 if self._parser.is_version_1 else layout.frame_v2
        frame = build(payload, self._sequence, self.system_id, self.component_id)
        if frame:
            self._sequence = (self._sequence + 1) & 0xFF
            self._frames.append(frame)

    def flush(self, *, is_due: bool = True) -> None:
        """Send the queued frames; those of streams to a datagram's partner wait until one is due.

        Frames stay in their order, so that what cannot wait takes with it what is queued before.
        """
        if not self._frames or (self._is_datagram and self._can_wait and not is_due):
            return
        self.n_sent += len(self._frames)
        self._write(self._frames)
        self._frames = []
        self._can_wait = True
