"""From values to payloads to MAVLink 2 frames, compiled.

`Layout.pack` and `Layout.frame_v2` make the same bytes one message at a time.
"""

from __future__ import annotations

import math

import numpy as np

from autonomy.jit import kernel
from flightsim.mavlink.dialect import number_range

HEADER_BYTES, CHECKSUM_BYTES = 10, 2
OVERHEAD_BYTES = HEADER_BYTES + CHECKSUM_BYTES
"""Bytes of header and checksum of a MAVLink 2 frame."""
TYPES = "fbBhHiIqQ"
"""Types on the wire, as letters of a struct format; only the first is no integer."""
_SIZES = np.array([np.dtype(letter).itemsize for letter in TYPES], np.int64)
_LEAST = np.array([number_range(letter)[0] for letter in TYPES], np.float64)
_MOST = np.array([number_range(letter)[1] for letter in TYPES], np.float64)
_MARKER = 0xFD
_POLYNOMIAL = 0x8408  # of CRC-16/MCRF4XX, with its bits reversed


def _crc_tables() -> tuple[np.ndarray, ...]:
    """Return the effect of a byte on the checksum as the last one, the one before it, and so on."""
    last = np.arange(256, dtype=np.int32)  # int32: half the size of Python's integers in the cache
    for _ in range(8):
        last = np.where(last & 1, last >> 1 ^ _POLYNOMIAL, last >> 1).astype(np.int32)
    tables = [last]
    for _ in range(3):
        tables.append(tables[-1] >> 8 ^ last[tables[-1] & 0xFF])
    return tuple(tables)


_LAST, _SECOND_LAST, _THIRD_LAST, _FOURTH_LAST = _crc_tables()


@kernel
def pack(values: np.ndarray, types: np.ndarray, payload: np.ndarray) -> bool:
    """Pack the values of a message.

    Args:
        values: In wire order (n,).
        types: Index in `TYPES` of each (n,).
        payload: Its bytes, changed.

    Returns:
        False if a number does not fit its field, such as those of a diverged estimate.
    """
    start = 0
    for i in range(len(values)):
        value, kind = values[i], types[i]
        if kind == 0:
            single = np.float32(value)
            # Infinity has a place in a float, a number beyond its range has none.
            if math.isinf(single) and not math.isinf(value):
                return False
            bits = np.int64(single.view(np.uint32))
        # NaN compares false and is refused too.
        elif _LEAST[kind] <= value <= _MOST[kind]:
            bits = np.int64(value)
        else:
            return False
        for k in range(_SIZES[kind]):
            payload[start + k] = bits >> 8 * k & 0xFF
        start += _SIZES[kind]
    return True


@kernel
def write_frame(
    payload: np.ndarray,
    message_id: int,
    crc_seed: int,
    sequence: int,
    system_id: int,
    component_id: int,
    out: np.ndarray,
) -> int:
    """Write a MAVLink 2 frame, without the zeros at the payload's end as the protocol allows.

    Args:
        payload: Payload as packed.
        message_id: Type of the message.
        crc_seed: Seed of its checksum.
        sequence: Number of the frame; the lowest eight bits are sent.
        system_id: System id of the sender.
        component_id: Component id of the sender.
        out: Bytes, changed.

    Returns:
        Number of bytes written.
    """
    length = len(payload)
    while length > 1 and payload[length - 1] == 0:
        length -= 1
    out[0], out[1], out[2], out[3] = _MARKER, length, 0, 0
    out[4], out[5], out[6] = sequence & 0xFF, system_id, component_id
    out[7], out[8], out[9] = message_id & 0xFF, message_id >> 8 & 0xFF, message_id >> 16
    for i in range(length):
        out[HEADER_BYTES + i] = payload[i]
    end = HEADER_BYTES + length
    out[end] = crc_seed  # counted as the last byte; the checksum then takes its place
    crc = _crc_of(0xFFFF, out[1 : end + 1])
    out[end], out[end + 1] = crc & 0xFF, crc >> 8
    return end + CHECKSUM_BYTES


@kernel
def _crc_of(crc: int, data: np.ndarray) -> int:
    """Return the CRC-16/MCRF4XX of more bytes.

    Four bytes at a time: byte by byte, each step would wait for the one before it.
    """
    n = len(data)
    whole = n - n % 4
    for i in range(0, whole, 4):
        crc = (
            int(_FOURTH_LAST[(crc ^ data[i]) & 0xFF])
            ^ int(_THIRD_LAST[(crc >> 8 ^ data[i + 1]) & 0xFF])
            ^ int(_SECOND_LAST[data[i + 2]])
            ^ int(_LAST[data[i + 3]])
        )
    for i in range(whole, n):
        crc = crc >> 8 ^ int(_LAST[(crc ^ data[i]) & 0xFF])
    return crc
