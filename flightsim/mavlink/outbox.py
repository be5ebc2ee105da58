"""Frames that wait to be sent to a partner, and how many of them share a datagram.

Each datagram costs a system call here and wakes the reader there, so frames share datagrams as far
as they fit. Streams may wait for a burst of several ticks. An answer never waits, because a client
stands still until it comes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from flightsim.mavlink.streaming import OVERHEAD_BYTES

Write = Callable[[Sequence[bytes]], None]
"""Sends frames, drops those that the transport cannot take, never blocks and never raises."""

# PX4 and ArduPilot send each message alone, and so some clients read no more at a time: libmavconn,
# which mavros is built on, 296 bytes (`MsgBuffer::MAX_SIZE`), gomavlib 512, mavlink-router 1,120.
SHORT_BYTES = 280
"""Largest datagram that every client reads whole: room for any one frame."""
LONG_BYTES, LONG_LOCAL_BYTES = 1400, 2000
"""Largest datagrams of bursts. Over a network they stay below the Ethernet MTU with IP and UDP
headers, on loopback below the 2,048 bytes that MAVSDK reads."""
MOST_WAITING = 16
"""Most datagrams that wait for the others of their burst."""


class Outbox:
    """Frames for a partner, from any component, in their order.

    Attributes:
        is_crowded: True if the transport lags behind: streams are held until it catches up.
        most_bytes: Size of the largest datagram.
        is_awaited: True if an answer is in the queue, and not only frames of streams.
    """

    __slots__ = (
        *("_frames", "_full", "_is_datagram", "_n_bytes", "_write"),
        *("is_awaited", "is_crowded", "most_bytes"),
    )

    def __init__(self, write: Write, *, is_datagram: bool) -> None:
        """Queue for a transport.

        Args:
            write: Sends frames.
            is_datagram: True if the transport keeps datagrams apart. Only those may wait for a
                burst.
        """
        self._write, self._is_datagram = write, is_datagram
        self.is_crowded = False
        self.most_bytes = SHORT_BYTES
        self.is_awaited = False
        self._full: list[list[bytes]] = []
        """Frames of each datagram that has no more room, the oldest first."""
        self._frames: list[bytes] = []
        """Frames of the last datagram, behind the full ones."""
        self._n_bytes = 0

    def put(self, frames: bytes) -> None:
        """Queue frames that share a datagram.

        Args:
            frames: One frame, or several one after the other that are no longer than `most_bytes`.
        """
        if self._is_datagram and self._n_bytes + len(frames) > self.most_bytes and self._frames:
            # No more wait: the oldest would come late, and the memory would grow.
            if len(self._full) + 1 == MOST_WAITING:
                self.flush()
            else:
                self._full.append(self._frames)
                self._frames, self._n_bytes = [], 0
        self._frames.append(frames)
        self._n_bytes += len(frames)

    def put_tick(self, frames: bytes) -> None:
        """Queue all frames of a tick for one datagram if they fit.

        Args:
            frames: Plain frames of MAVLink 2, not signed: their lengths are read from their
                headers.
        """
        most, n_bytes = self.most_bytes, self._n_bytes + len(frames)
        if n_bytes <= most:
            self._frames.append(frames)
            self._n_bytes = n_bytes
            return
        if not self._is_datagram or len(frames) <= most:
            self.put(frames)
            return
        # Cut between frames, as many as fit into each datagram.
        start = end = 0
        while start < len(frames):
            while end < len(frames) and (
                (after := end + OVERHEAD_BYTES + frames[end + 1]) - start <= most
            ):
                end = after
            self.put(frames[start:end])
            start = end

    def flush(self) -> None:
        """Send all queued frames, in their order."""
        if not self._frames:
            return
        full, last = self._full, self._frames
        # Emptied first, so that a write that fails does not send the same frames again.
        self._full, self._frames, self._n_bytes, self.is_awaited = [], [], 0, False
        for frames in full:
            self._write(frames)
        self._write(last)

    @property
    def can_wait(self) -> bool:
        """True if nobody waits for a queued frame and the transport keeps datagrams apart."""
        return self._is_datagram and not self.is_awaited
