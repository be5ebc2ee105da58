"""Failures of sensors and motors: how a broken part behaves instead of working.

A failed sensor goes on measuring. Only at the end does `said` replace each measured number by the
failed one. The sensor thus consumes the same random numbers as a healthy one, so a failure leaves
all other errors of the flight as they were, and two flights differ by the failure alone.

Parts of a sensor fail alone: the IMU has an accelerometer and a gyroscope, all others have one
part.
"""

from __future__ import annotations

import math
from enum import IntEnum, unique

import numpy as np

from autonomy.jit import kernel

N_PARTS = 2
"""Size of the per-part fields of a record: the IMU has two parts, all other sensors use one."""
N_CHANNELS = 6
"""Size of the per-number fields of a record; no sensor has more numbers in a sample."""
N_KEPT = 32
"""Length of the ring in which a delayed sensor keeps past samples."""
LATE_S = 0.5
"""Delay of a delayed sensor; shorter if that is more samples than the ring holds."""
MOST_ALIKE = 5
"""Number of identical samples in a row after which a driver declares a sensor stuck. Noise makes
such a row all but impossible in a healthy sensor."""
SLOW_FACTOR = 10
"""A slow sensor sends one of this many samples."""


@unique
class Failure(IntEnum):
    """Kinds of failure, by the numbers of MAVLink's FAILURE_TYPE."""

    NONE = 0
    OFF = 1
    """Sends nothing any more."""
    STUCK = 2
    """Repeats its last sample."""
    GARBAGE = 3
    """Sends random numbers."""
    WRONG = 4
    """Adds a constant to each number."""
    SLOW = 5
    """A sensor sends one sample of ten; a motor turns at 85% of its command."""
    DELAYED = 6
    """Sends each sample half a second late."""
    INTERMITTENT = 7
    """Sends nothing in every other second."""


# Kernels read plain integers, which compile to constants; keep them equal to `Failure`.
_NONE, _OFF, _STUCK, _GARBAGE = 0, 1, 2, 3
_WRONG, _SLOW, _DELAYED, _INTERMITTENT = 4, 5, 6, 7

FAILURE_FIELDS = (
    ("failure", "i8", N_PARTS),  # a `Failure` for each part
    ("failing_since", "i8", N_PARTS),  # tick at which the failure began
    ("n_late", "i8"),  # delay of DELAYED, in samples
    ("wrong", "f8", N_CHANNELS),  # constant that WRONG adds to each number
    ("garbage", "f8", N_CHANNELS),  # standard deviation of GARBAGE
    ("kept", "f8", (N_KEPT, N_CHANNELS)),  # ring of samples since the failure began
    ("last_number", "f8", N_PARTS),  # first number of the sample that the driver read last
    ("n_alike", "i8", N_PARTS),  # number of samples in a row that repeat the one before
)
"""Fields of every sensor's record."""


@kernel
def is_heard(r: np.record, part: int, tick: int) -> bool:
    """Return true if a part of a sensor, which measures at this tick, also sends its sample.

    A slow part sends every so many samples, an intermittent one those of every other second.

    Args:
        r: Record of the sensor.
        part: Index of the part, such as the accelerometer of an IMU.
        tick: Number of the control tick.
    """
    kind = r.failure[part]
    if kind == _OFF:
        return False
    if kind == _SLOW:
        return tick // r.period_ticks % SLOW_FACTOR == 0
    if kind == _INTERMITTENT:
        # rate times period are the control ticks of one second.
        return tick // (r.rate_hz * r.period_ticks) % 2 == 0
    return True


@kernel
def said(
    r: np.record, part: int, tick: int, channel: int, value: float, normals: np.ndarray
) -> float:
    """Return the number that a sensor sends for a number that it measured at this tick.

    Without a failure that is the measured number itself. Sensors call it once for each number of
    each sample, also while they fail, because delayed and intermittent sensors need the samples in
    between.

    Args:
        r: Record of the sensor; its ring of samples changes.
        part: Part that measures the number, below `N_PARTS`.
        tick: Present tick.
        channel: Place of the number in the sample, below `N_CHANNELS`.
        value: Measured number, in any unit.
        normals: Standard normals of the sample. Garbage reuses them, so that it draws none of its
            own.
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
        # Before `n_late` samples have passed, the sensor repeats the first one after the failure.
        r.kept[n_since % N_KEPT, channel] = value
        return r.kept[max(n_since - r.n_late, 0) % N_KEPT, channel]
    # A silent part repeats its old number, because the other part of the sensor may still send.
    if n_since == 0 or (kind != _STUCK and is_heard(r, part, tick)):
        r.kept[0, channel] = value
    return r.kept[0, channel]


@kernel
def is_stuck(r: np.record, part: int, number: float) -> bool:
    """Return true if the driver of a sensor discards this sample because it repeats itself.

    The driver compares only the first number of each sample. It ignores numbers that are not
    finite: a rangefinder rightly repeats infinity while nothing is in reach.

    Args:
        r: Record of the sensor; its count of equal samples changes.
        part: Part that measured the number.
        number: First number of the sample.
    """
    is_alike = number == r.last_number[part] and math.isfinite(number)
    r.n_alike[part] = r.n_alike[part] + 1 if is_alike else 0
    r.last_number[part] = number
    return r.n_alike[part] >= MOST_ALIKE
