"""Frames of all streams that are due at one tick, built in one compiled call.

`Layout.frame_v2` builds the same bytes one message at a time. A tick of a companion has seven
messages, and Python takes longer over their headers and checksums than a kernel over the tick.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from autonomy.jit import compile_ahead, kernel
from flightsim.mavlink.dialect import Layout

OVERHEAD_BYTES = 12
"""Header and checksum of a MAVLink 2 frame."""
_MARKER, _HEADER_BYTES = 0xFD, 10
_COMPILE_SECONDS = 2.0


@kernel
def build_frames(
    rows: np.ndarray,
    indexes: bytes,
    payloads: bytes,
    sequence: int,
    system_id: int,
    component_id: int,
    out: np.ndarray,
) -> int:
    """Write MAVLink 2 frames one after the other.

    Args:
        rows: Message id, bytes of the payload and seed of the checksum of each layout (n, 3).
        indexes: Row of each message.
        payloads: Their payloads, one after the other, with the zeros at their ends.
        sequence: Number of the first frame, 0 to 255.
        system_id: Sender.
        component_id: Sender's component.
        out: Bytes, written.

    Returns:
        Number of bytes written.
    """
    start, n = 0, 0
    for message in range(len(indexes)):
        row = indexes[message]
        message_id, size, seed = rows[row, 0], rows[row, 1], rows[row, 2]
        length = size
        while length > 1 and payloads[start + length - 1] == 0:
            length -= 1
        out[n], out[n + 1], out[n + 2], out[n + 3] = _MARKER, length, 0, 0
        out[n + 4], out[n + 5], out[n + 6] = (sequence + message) & 0xFF, system_id, component_id
        out[n + 7], out[n + 8] = message_id & 0xFF, message_id >> 8 & 0xFF
        out[n + 9] = message_id >> 16
        for i in range(length):
            out[n + _HEADER_BYTES + i] = payloads[start + i]
        end = n + _HEADER_BYTES + length
        crc = 0xFFFF
        for i in range(n + 1, end):
            crc = _crc_of_byte(crc, out[i])
        crc = _crc_of_byte(crc, seed)
        out[end], out[end + 1] = crc & 0xFF, crc >> 8
        start += size
        n = end + 2
    return n


@kernel
def _crc_of_byte(crc: int, byte: int) -> int:
    """CRC-16/MCRF4XX of one more byte."""
    low = (crc ^ byte) & 0xFF
    low = (low ^ low << 4) & 0xFF
    return crc >> 8 ^ low << 8 ^ low << 3 ^ low >> 4


class Framer:
    """Builds the frames of several messages at once.

    Attributes:
        layouts: Message types that it knows, up to 256; a message is named by its index here.
    """

    def __init__(self, layouts: Sequence[Layout]) -> None:
        self.layouts = tuple(layouts)
        rows = [(layout.message_id, layout.size, layout.crc_seed[0]) for layout in layouts]
        self._rows = np.array(rows, np.int64)
        self._out = np.zeros(sum(layout.size + OVERHEAD_BYTES for layout in layouts), np.uint8)
        self._bytes = self._out.data
        example = (self._rows, b"\0", b"\0", 0, 1, 1, self._out)
        compile_ahead(build_frames, example, "frames of MAVLink", _COMPILE_SECONDS)

    def frames_v2(
        self, indexes: bytes, payloads: bytes, sequence: int, system_id: int, component_id: int
    ) -> bytes:
        """MAVLink 2 frames of messages, numbered from `sequence` on.

        Args:
            indexes: Index of each message's layout, each at most once.
            payloads: Their payloads as packed, joined.
            sequence: Number of the first frame, 0 to 255.
            system_id: Sender.
            component_id: Sender's component.
        """
        n_bytes = build_frames(
            self._rows, indexes, payloads, sequence, system_id, component_id, self._out
        )
        return bytes(self._bytes[:n_bytes])
