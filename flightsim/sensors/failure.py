"""Failures of sensors and motors: what a part does instead of working.

A sensor that fails goes on measuring; what it says instead of a sample is decided here, value by
value, so that every other random draw of a flight stays as it was. A part of a sensor fails alone:
the IMU has an accelerometer and a gyroscope, all others are one part.
"""

from __future__ import annotations

import math
from enum import IntEnum, unique

import numpy as np

from autonomy.jit import kernel

N_PARTS = 2
"""Parts of a sensor that can fail alone; most sensors have one."""
N_CHANNELS = 6
"""Most numbers in a sample."""
N_KEPT = 32
"""Samples that a delayed sensor keeps."""
LATE_S = 0.5
"""Delay of a sensor that is late, unless it keeps too few samples for that."""
MOST_ALIKE = 5
"""Samples that repeat each other, noise and all, before a driver takes a sensor for stuck."""
SLOW_FACTOR = 10
"""Sensors that are slow send one sample of so many."""


@unique
class Failure(IntEnum):
    """Kinds of failure, by the numbers of MAVLink's FAILURE_TYPE."""

    NONE = 0
    OFF = 1
    """It says nothing any more."""
    STUCK = 2
    """It repeats what it said last."""
    GARBAGE = 3
    """It says anything."""
    WRONG = 4
    """It is off by a constant."""
    SLOW = 5
    """A sensor sends one sample of ten; a motor turns at 85% of its command."""
    DELAYED = 6
    """It says what it measured half a second ago."""
    INTERMITTENT = 7
    """It says nothing in every other second."""


_NONE, _OFF, _STUCK, _GARBAGE = 0, 1, 2, 3
_WRONG, _SLOW, _DELAYED, _INTERMITTENT = 4, 5, 6, 7

FAILURE_FIELDS = (
    ("failure", "i8", N_PARTS),  # by part, of `Failure`
    ("failing_since", "i8", N_PARTS),  # tick
    ("n_late", "i8"),  # samples by which it is late where it is delayed
    ("wrong", "f8", N_CHANNELS),  # what is added to each number where it is wrong
    ("garbage", "f8", N_CHANNELS),  # standard deviation where it is garbage
    ("kept", "f8", (N_KEPT, N_CHANNELS)),  # samples since it fails
    ("last_number", "f8", N_PARTS),  # that its driver has read
    ("n_alike", "i8", N_PARTS),  # samples that repeat the one before
)
"""Fields of every sensor's record."""


@kernel
def is_heard(r: np.record, part: int, tick: int) -> bool:
    """Whether a part of a sensor says anything new at this tick, at which it measures."""
    kind = r.failure[part]
    if kind == _OFF:
        return False
    if kind == _SLOW:
        return tick // r.period_ticks % SLOW_FACTOR == 0
    if kind == _INTERMITTENT:
        return tick // (r.rate_hz * r.period_ticks) % 2 == 0
    return True


@kernel
def said(
    r: np.record, part: int, tick: int, channel: int, value: float, normals: np.ndarray
) -> float:
    """What a sensor says instead of a number that it has measured at this tick.

    Args:
        r: The sensor.
        part: The part that measures the number.
        tick: Present tick.
        channel: Place of the number in the sample, below `N_CHANNELS`.
        value: The number.
        normals: Standard normals of the sample.
    """
    kind = r.failure[part]
    if kind == _NONE:
        return value
    if kind == _WRONG:
        return value + r.wrong[channel]
    if kind == _GARBAGE:
        return r.garbage[channel] * normals[channel % len(normals)]
    n_since = (tick - r.failing_since[part]) // r.period_ticks
    if kind == _DELAYED:
        r.kept[n_since % N_KEPT, channel] = value
        return r.kept[max(n_since - r.n_late, 0) % N_KEPT, channel]
    # A part that is not heard is held, for another one may speak.
    if n_since == 0 or (kind != _STUCK and is_heard(r, part, tick)):
        r.kept[0, channel] = value
    return r.kept[0, channel]


@kernel
def is_stuck(r: np.record, part: int, number: float) -> bool:
    """Whether the driver of a sensor discards a sample by its first number, for it repeats itself.

    Beyond its reach a rangefinder repeats itself rightly, with a number that is not finite.
    """
    is_alike = number == r.last_number[part] and math.isfinite(number)
    r.n_alike[part] = r.n_alike[part] + 1 if is_alike else 0
    r.last_number[part] = number
    return r.n_alike[part] >= MOST_ALIKE
