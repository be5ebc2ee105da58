"""H.264 in RTP: one NAL unit in a packet, or the fragments of one (RFC 3550, RFC 6184).

A UDP packet of a whole frame would not fit into an Ethernet frame, and a lost piece of it would
lose all. RFC 6184 therefore cuts a large NAL unit into fragments (FU-A), each with a header from
which a receiver puts it together again.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator, Sequence

CLOCK_HZ = 90_000
PAYLOAD_TYPE = 96
"""First of the dynamic payload types."""
MAX_PAYLOAD_BYTES = 1400
"""Greatest payload, which leaves room for all headers in an Ethernet frame of 1,500 bytes."""
_VERSION_2 = 0x80  # first byte: version 2, no padding, no extension
_MARKER = 0x80  # bit of the second byte, set on a frame's last packet
_FU_A = 28  # type of a fragment, RFC 6184 section 5.8
_START, _END = 0x80, 0x40  # bits of a fragment's header


class Packetiser:
    """Numberer of the packets of one stream."""

    def __init__(self, source: int) -> None:
        """Start a stream.

        Args:
            source: Synchronisation source, 32 bits, by which a receiver tells streams apart.
        """
        self._source = source
        self._sequence = 0

    def packets(self, units: Sequence[bytes], timestamp: int) -> Iterator[bytes]:
        """Yield the packets of one frame; the last has the marker bit.

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
    """Yield the unit itself if it fits into a packet, else its fragments.

    Args:
        unit: A NAL unit, without start code.
    """
    if len(unit) <= MAX_PAYLOAD_BYTES:
        yield unit
        return
    # The unit's own first byte is not sent: importance goes here, type to the next byte.
    indicator = unit[0] & 0xE0 | _FU_A
    kind = unit[0] & 0x1F
    step = MAX_PAYLOAD_BYTES - 2
    for start in range(1, len(unit), step):
        first = _START if start == 1 else 0
        last = _END if start + step >= len(unit) else 0
        yield bytes((indicator, first | last | kind)) + unit[start : start + step]
