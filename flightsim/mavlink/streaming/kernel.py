"""One call a tick: the due messages of each partner are filled from the plant's record and framed.

Messages that Python packs are asked for first: the call then returns how many are wanted, and is
made again once they are there. A kernel cannot call back into Python.
"""

from __future__ import annotations

import numpy as np

from autonomy.jit import compile_ahead, kernel
from flightsim.mavlink.streaming.motion import fill_course, fill_pose, look
from flightsim.mavlink.streaming.navigation import fill_navigation
from flightsim.mavlink.streaming.packing import OVERHEAD_BYTES, pack, write_frame
from flightsim.mavlink.streaming.readings import fill_imu, fill_readings
from flightsim.mavlink.streaming.record import (
    COURSE,
    FRAMED,
    IMU,
    MESSAGE_DTYPE,
    PARTNER_DTYPE,
    POSE,
    READINGS,
    STREAMER_DTYPE,
    VALUES_DTYPE,
    VIEW_DTYPE,
    WAITS,
)
from flightsim.plant.mujoco_calls import bytes_at, doubles, long_integers, rows
from flightsim.plant.record import PLANT_DTYPE

TICK_US = 20_000
"""Period of the server, and so the shortest interval of a stream."""

_NOT_DUE_US = 1 << 62  # later than any simulated time
_N_VALUES = VALUES_DTYPE.itemsize // 8
_COMPILE_SECONDS = 8.0


@kernel
def stream(streamers: np.ndarray, now_us: int, asked: int) -> int:
    """Frame the due messages for all partners, or pack one message for nobody in particular.

    Args:
        streamers: `STREAMER_DTYPE` (1,), changed with all that it points to.
        now_us: Simulated time.
        asked: Index of the one message, which is packed; -1 to frame due messages.

    Returns:
        Number of messages that Python must pack before this is called again; their indexes are at
        `wanted_address`. 0 if all is done; nothing is due again before `next_us` then.
    """
    s = streamers[0]
    messages = rows(s.messages_address, s.n_messages, MESSAGE_DTYPE)
    if asked >= 0:
        # Forgotten before and after: state may change within a tick, when a client asks.
        s.filled_us = -1
        _pack_filled(s, messages[asked], now_us)
        s.filled_us = messages[asked].packed_us = -1  # more may happen before the tick's end
        return 0
    addresses = long_integers(s.partners_address, s.n_partners)
    n_wanted = 0
    s.next_us = _NOT_DUE_US
    for k in range(len(addresses)):
        partner = rows(addresses[k], 1, PARTNER_DTYPE)
        partner[0].n_frames = partner[0].n_bytes = 0
        if partner[0].service_mode == WAITS:
            s.next_us = now_us  # it may take overdue messages at any tick
            continue
        s.next_us = min(s.next_us, mark_due(partner, s.n_messages, now_us))
        n_wanted = _want(s, messages, partner[0], now_us, n_wanted)
    if n_wanted > 0:
        return n_wanted
    for k in range(len(addresses)):
        partner = rows(addresses[k], 1, PARTNER_DTYPE)
        if partner[0].service_mode == FRAMED:
            _frame(s, messages, partner[0])
    return 0


@kernel
def mark_due(partners: np.ndarray, n_messages: int, now_us: int) -> int:
    """Mark the due messages of a partner at a tick, and advance its calendar.

    Args:
        partners: `PARTNER_DTYPE` (1,), changed.
        n_messages: Number of types of messages.
        now_us: Simulated time.

    Returns:
        Time at which a message is due again.
    """
    p = partners[0]
    next_us = long_integers(p.next_address, n_messages)
    interval_us = long_integers(p.interval_address, n_messages)
    is_due = bytes_at(p.due_address, n_messages)
    p.now_us = now_us
    earliest_us = _NOT_DUE_US
    for i in range(n_messages):
        if interval_us[i] < 0:
            continue
        if next_us[i] <= now_us:
            is_due[i] = 1
            next_us[i] += interval_us[i]
            if next_us[i] <= now_us:  # one message makes up for all ticks that were left out
                next_us[i] = now_us + TICK_US
        earliest_us = min(earliest_us, next_us[i])
    return earliest_us


@kernel
def _want(s: np.record, messages: np.ndarray, p: np.record, now_us: int, n_wanted: int) -> int:
    """Pack due messages of a partner; collect those that Python must pack, return their number."""
    is_due = bytes_at(p.due_address, len(messages))
    wanted = long_integers(s.wanted_address, len(messages))
    for i in range(len(messages)):
        # Packed in this tick already, for another partner.
        if is_due[i] == 0 or messages[i].packed_us == now_us:
            continue
        if messages[i].first_value >= 0:
            _pack_filled(s, messages[i], now_us)
            continue
        is_new = True
        for k in range(n_wanted):
            is_new = is_new and wanted[k] != i
        if is_new:
            wanted[n_wanted] = i
            n_wanted += 1
    return n_wanted


@kernel
def _pack_filled(s: np.record, message: np.record, now_us: int) -> None:
    """Pack one of `KERNEL_MESSAGES`; the first of a tick fills all of its group."""
    if s.filled_us != now_us:
        s.filled_us, s.filled = now_us, 0
        look(_view(s), _plant(s), now_us)
    if s.filled >> message.group & 1 == 0:
        s.filled |= 1 << message.group
        _fill(s, message.group)
    values = doubles(s.values_address, _N_VALUES)
    types = bytes_at(s.types_address, _N_VALUES)
    first, end = message.first_value, message.first_value + message.n_values
    payload = bytes_at(s.payloads_address + message.payload_start, message.size)
    message.n_parts = 0
    # The value before the fields is `is_known`; a message without data has no part.
    if values[first - 1] != 0.0 and pack(values[first:end], types[first:end], payload):
        message.n_parts = 1
    message.packed_us = now_us


@kernel
def _fill(s: np.record, group: int) -> None:
    """Fill the messages of a group."""
    values, plant, view = rows(s.values_address, 1, VALUES_DTYPE)[0], _plant(s), _view(s)
    if group == POSE:
        fill_pose(values, plant, view)
    elif group == IMU:
        fill_imu(values.HIGHRES_IMU, plant, view)
    elif group == COURSE:
        fill_course(values, plant, view)
    elif group == READINGS:
        fill_readings(values, plant, view)
    else:
        fill_navigation(values, plant, view)


@kernel
def _plant(s: np.record) -> np.record:
    return rows(s.plant_address, 1, PLANT_DTYPE)[0]


@kernel
def _view(s: np.record) -> np.record:
    return rows(s.view_address, 1, VIEW_DTYPE)[0]


@kernel
def _frame(s: np.record, messages: np.ndarray, p: np.record) -> None:
    """Frame the due messages of a partner, one after the other."""
    is_due = bytes_at(p.due_address, len(messages))
    for i in range(len(messages)):
        if is_due[i] == 0:
            continue
        is_due[i] = 0
        m = messages[i]
        for part in range(m.n_parts):
            start = s.payloads_address + m.payload_start + part * m.size
            p.n_bytes += write_frame(
                bytes_at(start, m.size),
                m.message_id,
                m.crc_seed,
                # `write_frame` keeps the lowest eight bits.
                p.sequence + p.n_frames,
                p.system_id,
                p.component_id,
                bytes_at(p.frames_address + p.n_bytes, m.size + OVERHEAD_BYTES),
            )
            p.n_frames += 1


def compile_streaming() -> None:
    """Compile the kernel now, or load it from the cache; a line is printed if it takes long."""
    example = (np.zeros(1, STREAMER_DTYPE), 0, 0)
    compile_ahead(stream, example, "telemetry kernel", _COMPILE_SECONDS)
