"""Streams, from the plant's record to frames, in one compiled call a tick for all partners.

Packing a message takes 4 to 6 us with pymavlink. A companion gets hundreds of messages in a
simulated second, and a campaign runs many times faster than real time, so the frequent ones are
filled, packed and framed by a kernel. Python packs the rest.
"""

from flightsim.mavlink.streaming.inputs import KernelInputs
from flightsim.mavlink.streaming.kernel import TICK_US, compile_streaming, mark_due
from flightsim.mavlink.streaming.packing import OVERHEAD_BYTES
from flightsim.mavlink.streaming.record import (
    FRAMED,
    KERNEL_MESSAGES,
    MOST_PARTS,
    ONE_BY_ONE,
    PARTNER_DTYPE,
    WAITS,
)
from flightsim.mavlink.streaming.streamer import Streamed, Streamer

__all__ = [
    "FRAMED",
    "KERNEL_MESSAGES",
    "MOST_PARTS",
    "ONE_BY_ONE",
    "OVERHEAD_BYTES",
    "PARTNER_DTYPE",
    "TICK_US",
    "WAITS",
    "KernelInputs",
    "Streamed",
    "Streamer",
    "compile_streaming",
    "mark_due",
]
