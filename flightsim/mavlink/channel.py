"""State of a conversation with one partner: received and outgoing bytes, and limits on both.

Every partner has its own sequence numbers, MAVLink version and budget of messages. A partner that
sends too much therefore loses its own messages and delays nobody else. Over TCP the excess stays in
the kernel's buffer, which slows the sender down; datagrams beyond the budget are discarded.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from flightsim.mavlink.dialect import LAYOUTS, MARKER_V2, SIGNED_FLAG, Layout
from flightsim.mavlink.outbox import LONG_BYTES, LONG_LOCAL_BYTES, SHORT_BYTES, Outbox, Write
from flightsim.mavlink.parsing import FrameParser, Message
from flightsim.mavlink.signing import Signing
from flightsim.mavlink.streaming import FRAMED, ONE_BY_ONE, WAITS
from flightsim.mavlink.streams import Profile

Clock = Callable[[], float]
"""Clock of protocol timeouts in s: wall time behind a socket, simulated time in lockstep."""

# A ground station sends 1 to 100 messages per second, a mission upload one per round trip.
_REFILL_PER_TICK = 20  # messages that a partner may send on average: 1,000 in a simulated second
_BURST = 200
# A stream is read no further while so much of it waits to be parsed.
_STREAM_BACKLOG_BYTES = 16_384


class Channel:
    """One partner: a UDP address, a TCP connection, a serial line or the in-process client."""

    def __init__(
        self,
        name: str,
        write: Write,
        *,
        profile: Profile,
        clock: Clock,
        is_datagram: bool,
        is_local: bool = True,
        signing: Signing | None = None,
        link_id: int = 0,
    ) -> None:
        """Begin a conversation.

        Args:
            name: Name of the partner in messages to people.
            write: Sends frames to it.
            profile: Default stream rates.
            clock: Clock of protocol timeouts.
            is_datagram: True if no frame continues in the bytes that come next.
            is_local: True if only this machine sees the messages.
            signing: Signs and checks signatures, once it has a key; None never does.
            link_id: Number of the link in signatures.
        """
        self.name = name
        self.profile: Profile = profile
        self.clock = clock
        self.is_open = True
        self.is_local = is_local
        self.system_id = 1
        self.component_id = 1
        """Component id in outgoing frames."""
        self.n_refused_bytes = 0
        self._parser = FrameParser(signing)
        self._signing = signing
        self._link_id = link_id
        self._write = write
        self._is_datagram = is_datagram
        self._reads_little = False
        self.sequence = 0
        """Number of the next frame, 0 to 255."""
        self._budget = _BURST
        self._inbox: list[Message] = []
        self._outbox = Outbox(write, is_datagram=is_datagram)
        self._others: dict[int, Channel] = {}

    @property
    def n_received(self) -> int:
        """Number of valid messages that came from this partner."""
        return self._parser.n_messages

    @property
    def is_heard(self) -> bool:
        """True if a valid message ever came from this partner."""
        return self.n_received > 0

    @property
    def speaks_version_2(self) -> bool:
        """True if the last valid message was one of MAVLink 2."""
        return self.is_heard and not self._parser.is_version_1

    @property
    def knows_components(self) -> bool:
        """True if the partner tells components apart: it speaks MAVLink 2, and is one itself.

        Others, such as scripts with pymavlink's defaults, take any heartbeat for the autopilot's.
        """
        return self.speaks_version_2 and self._parser.component_id != 0

    def as_component(self, component_id: int) -> Channel:
        """Return the same partner for another component, which numbers its own frames.

        Frames that are sent there leave when this channel is flushed.
        """
        if component_id == self.component_id:
            return self
        other = self._others.get(component_id)
        if other is None:
            other = Channel(
                self.name,
                self._write,
                profile=self.profile,
                clock=self.clock,
                is_datagram=self._is_datagram,
                is_local=self.is_local,
                signing=self._signing,
                link_id=self._link_id,
            )
            other.system_id, other.component_id = self.system_id, component_id
            # One partner has one byte stream in each direction, whichever component speaks.
            other._parser, other._outbox = self._parser, self._outbox
            self._others[component_id] = other
        return other

    @property
    def is_crowded(self) -> bool:
        """True if the transport lags behind: streams are held until it catches up."""
        return self._outbox.is_crowded

    @is_crowded.setter
    def is_crowded(self, is_crowded: bool) -> None:
        self._outbox.is_crowded = is_crowded

    @property
    def service_mode(self) -> int:
        """How streams serve the partner now: waiting, frame by frame, or framed by the kernel."""
        if self._outbox.is_crowded:
            return WAITS
        signing = self._signing
        is_signed = signing is not None and signing.key is not None
        return ONE_BY_ONE if is_signed or self._parser.is_version_1 else FRAMED

    @property
    def has_room(self) -> bool:
        """True if more bytes are accepted; a stream's excess stays in the system's buffer."""
        return self._parser.n_buffered < _STREAM_BACKLOG_BYTES

    def lengthen_datagrams(self) -> None:
        """Let many frames share a datagram, as bursts need, unless the partner reads little."""
        if not self._reads_little:
            self._outbox.most_bytes = LONG_LOCAL_BYTES if self.is_local else LONG_BYTES

    def keep_datagrams_short(self) -> None:
        """Send short datagrams from now on, for a partner that reads little of each."""
        if not self._reads_little:
            self.flush()
            self._reads_little, self._outbox.most_bytes = True, SHORT_BYTES

    def receive(self, data: bytes) -> None:
        """Accept bytes from the partner.

        A partner has a budget of messages. Datagrams beyond it are discarded unread; a stream is
        read on later instead, since its bytes hang together.

        Args:
            data: One datagram, or the next piece of a stream.
        """
        # Unread: parsing would already cost what the budget is there to limit.
        if self._is_datagram and self._budget <= 0:
            self.n_refused_bytes += len(data)
            return
        self._parser.feed(data, is_datagram=self._is_datagram)
        if self._is_datagram:
            self._collect()

    def take_messages(self) -> list[Message]:
        """Return the messages since the last call, up to the budget; call it once per tick."""
        if not self._is_datagram:
            self._collect()
        if self._budget < _BURST:
            self._budget = min(_BURST, self._budget + _REFILL_PER_TICK)
        messages = self._inbox
        if messages:
            self._inbox = []
        return messages

    def put_back(self, messages: Sequence[Message]) -> None:
        """Return messages to the inbox, before all that come after them, to be taken later.

        A client that keeps the time in lockstep sends commands for later ticks, which must wait for
        them.

        Args:
            messages: Messages that were taken, in their order.
        """
        self._inbox = [*messages, *self._inbox]

    def _collect(self) -> None:
        messages, self._budget = self._parser.take(self._budget)
        self._inbox += messages

    def send(self, layout: Layout, payload: bytes) -> None:
        """Queue a message for the next flush, which does not wait for others.

        Args:
            layout: Layout of the message.
            payload: Its content, packed; the partner's version of MAVLink decides on the frame.
        """
        self.stream_one(layout, payload)
        self._outbox.is_awaited = True

    def stream(self, frames: bytes, n_frames: int) -> None:
        """Queue frames that may wait to share a datagram with others.

        Args:
            frames: Plain frames one after the other, numbered from `sequence` on.
            n_frames: Number of them.
        """
        self.sequence = (self.sequence + n_frames) & 0xFF
        self._outbox.put_tick(frames)

    @property
    def _signs(self) -> bool:
        return self._signing is not None and self._signing.key is not None

    def stream_one(self, layout: Layout, payload: bytes) -> None:
        """Queue a message like `send`, but one that may wait to share a datagram with others.

        Args:
            layout: Layout of the message; one that MAVLink 1 cannot carry is dropped for such a
                partner.
            payload: Its content, packed.
        """
        # The one frame of a signed or MAVLink 1 partner is built here; the kernel builds plain
        # ones.
        numbers = (self.sequence, self.system_id, self.component_id)
        if self._signs:
            frame = self._signed(layout, payload, numbers)
        else:
            build = layout.frame_v1 if self._parser.is_version_1 else layout.frame_v2
            frame = build(payload, *numbers)
        # Empty for a message that MAVLink 1 cannot carry: its number is not used up.
        if frame:
            self.sequence = (self.sequence + 1) & 0xFF
            self._outbox.put(frame)

    def forward(self, message: Message) -> None:
        """Queue a message of another system, unchanged if the partner can read it so.

        Only its checksum and framing may change: sender and sequence stay, so that the receiver
        still sees losses on the way.
        """
        frame = bytes(message.get_msgbuf())
        is_version_2 = frame[0] == MARKER_V2
        payload = frame[10 : 10 + frame[1]] if is_version_2 else frame[6 : 6 + frame[1]]
        layout = LAYOUTS[message.get_type()]
        numbers = (message.get_seq(), message.get_srcSystem(), message.get_srcComponent())
        if self._signs:
            # A signed frame keeps its signature: the sender's key may be the partner's as well.
            if not (is_version_2 and frame[2] & SIGNED_FLAG):
                frame = self._signed(layout, payload, numbers)
        elif is_version_2 and self._parser.is_version_1:
            frame = layout.frame_v1(payload, *numbers)
        if frame:
            self._outbox.put(frame)
            self._outbox.is_awaited = True

    def _signed(self, layout: Layout, payload: bytes, numbers: tuple[int, int, int]) -> bytes:
        assert self._signing is not None
        return self._signing.sign(layout.frame_v2(payload, *numbers, SIGNED_FLAG), self._link_id)

    def flush(self) -> None:
        """Send the queued frames, in their order."""
        self._outbox.flush()

    @property
    def can_wait(self) -> bool:
        """True if the queue may wait for its burst: only datagrams of streams may.

        A byte stream cannot: its next bytes go on where the last ones ended.
        """
        return self._outbox.can_wait
