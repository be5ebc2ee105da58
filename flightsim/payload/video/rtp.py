"""H.264 in RTP: one NAL unit in a packet, or the fragments of one (RFC 3550, RFC 6184)."""

from __future__ import annotations

import struct
from collections.abc import Iterator, Sequence

CLOCK_HZ = 90_000
PAYLOAD_TYPE = 96
"""First of the dynamic payload types."""
MAX_PAYLOAD_BYTES = 1400
"""Payload that leaves room for all headers in an Ethernet frame."""
_VERSION_2 = 0x80
_MARKER = 0x80
_FU_A = 28
_START, _END = 0x80, 0x40


class Packetiser:
    """Numbers the packets of one stream."""

    def __init__(self, source: int) -> None:
        """Start a stream.

        Args:
            source: Synchronisation source, 32 bits, by which a receiver tells streams apart.
        """
        self._source = source
        self._sequence = 0

    def packets(self, units: Sequence[bytes], timestamp: int) -> Iterator[bytes]:
        """Packets of one frame; the last has the marker bit.

        Args:
            units: NAL units of the frame, without start codes.
            timestamp: Time of the frame in 1/90,000 s.
        """
        payloads = [payload for unit in units for payload in payloads_of(unit)]
        for i, payload in enumerate(payloads, start=1):
            marker = _MARKER if i == len(payloads) else 0
            header = struct.pack(
                ">BBHII",
                _VERSION_2,
                marker | PAYLOAD_TYPE,
                self._sequence,
                timestamp & 0xFFFFFFFF,
                self._source,
            )
            self._sequence = (self._sequence + 1) & 0xFFFF
            yield header + payload


def payloads_of(unit: bytes) -> Iterator[bytes]:
    """The unit itself if it fits into a packet, else its fragments (RFC 6184, section 5.8)."""
    if len(unit) <= MAX_PAYLOAD_BYTES:
        yield unit
        return
    indicator = unit[0] & 0xE0 | _FU_A
    kind = unit[0] & 0x1F
    step = MAX_PAYLOAD_BYTES - 2
    for start in range(1, len(unit), step):
        first = _START if start == 1 else 0
        last = _END if start + step >= len(unit) else 0
        yield bytes((indicator, first | last | kind)) + unit[start : start + step]
