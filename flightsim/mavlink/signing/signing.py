"""Signing of frames: https://mavlink.io/en/guide/message_signing.html.

A signature is the link's number, a timestamp that only ever rises, and six bytes of a SHA-256 over
the key and everything before. A recorded frame cannot be sent again, and a sender without the key
can send nothing but reports of radios.
"""

from __future__ import annotations

import hashlib
import hmac
import logging
import time
from collections.abc import Callable

from flightsim.mavlink.dialect import LAYOUTS, MARKER_V2, SIGNED_FLAG

_LOG = logging.getLogger(__name__)

SIGNATURE_BYTES = 13
_HASH_BYTES = 6
_TICKS_PER_S = 100_000
"""Ticks of timestamps: they count ten microseconds since 1 January 2015."""
_EPOCH_S = 1_420_070_400
_MOST_BEHIND = 60 * _TICKS_PER_S
"""Greatest age of the first frame of a stream, a minute."""
_MOST_AHEAD = 86_400 * _TICKS_PER_S
"""Greatest lead of a frame over our clock, a day. A clock farther ahead is wrong, and would make
the frames of all others old."""
_MOST_STREAMS = 64  # senders that are remembered; no client can make this grow
_RADIO_STATUS = LAYOUTS["RADIO_STATUS"].message_id

Stream = tuple[int, int, int]
"""Link, system and component of a sender."""


class Signing:
    """The vehicle's key, and the latest timestamp of each sender that has signed with it.

    One object serves all links, so that a frame recorded on one is not accepted on another.

    Attributes:
        key: Key of 32 bytes; None while nothing is signed and no signature is required.
        n_refused: Number of frames that were refused.
    """

    def __init__(self, key: bytes | None = None, clock: Callable[[], float] = time.time) -> None:
        """Sign with a key, or not until one is set.

        Args:
            key: Key of 32 bytes; None for none.
            clock: Seconds since 1970.
        """
        self.key = key
        self.n_refused = 0
        self._clock = clock
        self._timestamp = 0
        self._latest: dict[Stream, int] = {}
        self._n_links = 0
        self._told: set[str] = set()

    def new_link_id(self) -> int:
        """Return a number for one more link, 0 to 255."""
        self._n_links += 1
        return self._n_links - 1 & 0xFF

    def sign(self, frame: bytes, link_id: int) -> bytes:
        """Append the signature to a MAVLink 2 frame whose flags announce it.

        Args:
            frame: The frame, with its checksum.
            link_id: Number of the link that it leaves by.

        Returns:
            The frame with 13 bytes more.
        """
        assert self.key is not None
        # It rises even if the clock stands still or goes back.
        self._timestamp = max(self._timestamp + 1, self._now())
        signed = frame + bytes((link_id,)) + self._timestamp.to_bytes(6, "little")
        return signed + _hash(self.key, signed)

    def admits(self, frame: bytes | bytearray) -> bool:
        """Return true if an undamaged frame may be believed; the same frame never may be again."""
        if self.key is None:
            return True
        fault = self.fault(frame)
        if fault is not None:
            self.n_refused += 1
            if fault not in self._told:
                self._told.add(fault)
                _LOG.warning("a message %s is refused: signing is on", fault)
            return False
        if _is_signed(frame):
            stream, timestamp = _stamp(frame)
            self._latest[stream] = timestamp
            # Our own timestamps must not fall behind those of partners with a faster clock.
            self._timestamp = max(self._timestamp, timestamp)
        return True

    def fault(self, frame: bytes | bytearray) -> str | None:
        """Return why a frame is not believed, in words that follow "a message", or None."""
        key = self.key
        if key is None:
            return None
        if not _is_signed(frame):
            # Radios cannot sign, and their reports change nothing.
            return None if _message_id(frame) == _RADIO_STATUS else "without a signature"
        signed = bytes(frame[:-_HASH_BYTES])
        # In constant time, so that the comparison reveals nothing about the right bytes.
        if not hmac.compare_digest(_hash(key, signed), bytes(frame[-_HASH_BYTES:])):
            return "with a forged signature"
        stream, timestamp = _stamp(frame)
        latest = self._latest.get(stream)
        if latest is not None and timestamp <= latest:
            return "that was sent before"
        if latest is None and timestamp < max(self._timestamp, self._now()) - _MOST_BEHIND:
            return "more than a minute old"
        if timestamp > self._now() + _MOST_AHEAD:
            return "more than a day ahead of the clock"
        # Only new senders are refused: the known ones go on.
        if latest is None and len(self._latest) >= _MOST_STREAMS:
            return f"of one sender more than {_MOST_STREAMS}"
        return None

    def _now(self) -> int:
        return int((self._clock() - _EPOCH_S) * _TICKS_PER_S)


def _is_signed(frame: bytes | bytearray) -> bool:
    return frame[0] == MARKER_V2 and bool(frame[2] & SIGNED_FLAG)


def _message_id(frame: bytes | bytearray) -> int:
    return int.from_bytes(frame[7:10], "little") if frame[0] == MARKER_V2 else frame[5]


def _stamp(frame: bytes | bytearray) -> tuple[Stream, int]:
    """Return stream and timestamp of a signed frame."""
    link_id, timestamp = frame[-SIGNATURE_BYTES], frame[1 - SIGNATURE_BYTES : -_HASH_BYTES]
    return (link_id, frame[5], frame[6]), int.from_bytes(timestamp, "little")


def _hash(key: bytes, signed: bytes) -> bytes:
    return hashlib.sha256(key + signed).digest()[:_HASH_BYTES]
