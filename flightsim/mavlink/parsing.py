"""MAVLink 1 and 2 frame parser: skips garbage and bounds the work per call.

It decides on whole candidate frames and counts each one against the caller's budget, so that
garbage cannot cost more than messages do.
"""

from __future__ import annotations

import re
from typing import Any

from flightsim.mavlink.dialect import MARKER_V2, SIGNED_FLAG, dialect
from flightsim.mavlink.signing.signing import SIGNATURE_BYTES, Signing

Message = Any
"""Decoded message: pymavlink's object with fields as attributes."""

_MARKERS = re.compile(rb"[\xfd\xfe]")
_BUFFER_LIMIT_BYTES = 65536  # most bytes kept of a stream: many times the longest frame
_HEADER_V1_BYTES, _HEADER_V2_BYTES, _CHECKSUM_BYTES = 6, 10, 2

# One decoder for all partners: it is used for single whole frames, and keeps nothing between them.
_decoder = dialect.MAVLink(None)


class FrameParser:
    """Splits the bytes of one partner into messages.

    A marker without a valid frame costs one step of the caller's budget and the search continues at
    the next byte, so a damaged frame never hides the one after it. Unknown message ids are ignored,
    and so are frames that `signing` does not admit, if it is given.
    """

    def __init__(self, signing: Signing | None = None) -> None:
        self._signing = signing
        self._buffer = bytearray()
        self._position = 0
        self._is_complete = False
        self.n_messages = 0
        self.n_bad = 0
        self.is_version_1 = False
        """True if the last valid frame was a MAVLink 1 frame."""
        self.component_id = 0
        """Component that sent the last valid frame; 0 if it has no number."""

    def feed(self, data: bytes, *, is_datagram: bool = False) -> None:
        """Add received bytes.

        Args:
            data: The bytes; of a stream, bytes beyond 64 KiB of backlog are lost.
            is_datagram: True if they are a whole datagram: no frame continues into another one.
        """
        self._is_complete = is_datagram
        if is_datagram or self._position == len(self._buffer):
            self._buffer = bytearray(data)
            self._position = 0
            return
        del self._buffer[: self._position]
        self._position = 0
        self._buffer += data[: max(0, _BUFFER_LIMIT_BYTES - len(self._buffer))]

    @property
    def n_buffered(self) -> int:
        """Number of unparsed bytes."""
        return len(self._buffer) - self._position

    def take(self, budget: int) -> tuple[list[Message], int]:
        """Decode complete frames, trying at most `budget` candidates.

        Returns:
            The messages and the remaining budget.
        """
        messages: list[Message] = []
        while budget > 0:
            frame = self._next_frame()
            # The end of a datagram cannot be the start of a frame: search on behind that marker.
            if frame is None and not (self._is_complete and self.n_buffered):
                break
            budget -= 1
            message = None if frame is None else _decode(frame)
            if frame is None or message is None:
                self.n_bad += 1
                # One byte on, not one frame: a true frame may begin within the damaged one.
                self._position += 1
                continue
            self._position += len(frame)
            # Not admitted, but well-formed: skipped as a whole.
            if self._signing is not None and not self._signing.admits(frame):
                continue
            self.n_messages += 1
            self.is_version_1 = frame[0] != MARKER_V2
            self.component_id = message.get_srcComponent()
            messages.append(message)
        return messages, budget

    def _next_frame(self) -> bytearray | None:
        """Return the bytes of the next candidate frame, at `_position`; None until more arrive."""
        found = _MARKERS.search(self._buffer, self._position)
        if found is None:
            self._position = len(self._buffer)
            return None
        start = self._position = found.start()
        n_buffered = len(self._buffer) - start
        if n_buffered < _HEADER_V1_BYTES + _CHECKSUM_BYTES:
            return None
        length = self._buffer[start + 1] + _CHECKSUM_BYTES
        if self._buffer[start] == MARKER_V2:
            length += _HEADER_V2_BYTES
            length += SIGNATURE_BYTES if self._buffer[start + 2] & SIGNED_FLAG else 0
        else:
            length += _HEADER_V1_BYTES
        return self._buffer[start : start + length] if n_buffered >= length else None


def starts_with_message(datagram: bytes, signing: Signing) -> bool:
    """Return true if the first candidate frame in a datagram is a message with a valid signature.

    Args:
        datagram: Bytes from an unknown address. One candidate is tried, so that garbage is cheap.
        signing: Judges the signature.
    """
    parser = FrameParser()
    parser.feed(datagram, is_datagram=True)
    messages, _ = parser.take(1)
    return bool(messages) and signing.fault(messages[0].get_msgbuf()) is None


def _decode(frame: bytearray) -> Message | None:
    """Return the message of a candidate frame; None if it is damaged or unknown."""
    # Flags that we do not know may change the layout: MAVLink demands to drop such frames.
    if frame[0] == MARKER_V2 and frame[2] & ~SIGNED_FLAG:
        return None
    try:
        message = _decoder.decode(frame)
    except dialect.MAVError:
        return None
    return None if isinstance(message, dialect.MAVLink_unknown) else message
