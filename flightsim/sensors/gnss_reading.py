"""Output of a GNSS receiver: its latest fix, and the accuracy that it claims."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from autonomy.types import Vector3
from flightsim.sensors.failure import Failure
from flightsim.sensors.sensor import numbers

_FLOAT_TYPE = 5
"""RTK float in MAVLink's GPS_FIX_TYPE."""


class GnssReading(NamedTuple):
    """Latest fix; `time_us` is the time for which it is valid, 0 before the first."""

    time_us: int
    position_enu_m: Vector3
    velocity_enu_mps: Vector3
    fix_type: int
    """MAVLink's GPS_FIX_TYPE; 0 or 1 before the first fix or without signal."""
    eph_m: float
    """Claimed standard deviation of each horizontal axis; infinite without a fix."""
    epv_m: float
    """Claimed standard deviation of the altitude; infinite without a fix."""
    n_satellites: int
    """Satellites used; 0 without a fix."""


_numbers = numbers(
    *("tick", "position_enu_m", "velocity_enu_mps", "fix_type"),
    *("reported_accuracy_m", "settling_sigma_m", "dilution", "multipath_now_sigma_m"),
    *("is_float", "float_sigma_m", "n_heard"),
    *("is_enabled", "failure", "under_sky_ticks", "reacquire_ticks"),
)


def read_gnss(r: np.void, tick_us: int) -> GnssReading:
    """Return the reading of a receiver's record; `tick_us` is the length of a control tick.

    The claimed accuracy grows with dilution, multipath and a float solution, as in a real receiver.
    """
    tick, position, velocity, fix_type, accuracy, settling, *rest = _numbers(r)
    dilution, multipath, is_float, float_sigma, n_heard, *heard = rest
    is_enabled, failure, under_sky_ticks, reacquire_ticks = heard
    ambiguous = is_float * float_sigma
    # Dilution and multipath are per axis (east, north, up): 2 * k picks east and up.
    eph_m, epv_m = (
        math.hypot(math.hypot(accuracy[k], ambiguous) * dilution[2 * k], multipath[2 * k], settling)
        for k in (0, 1)
    )
    is_on = is_enabled == 1 and failure[0] != Failure.OFF
    is_fixed = is_on and under_sky_ticks >= reacquire_ticks and tick >= 0
    return GnssReading(
        time_us=max(0, tick) * tick_us,
        position_enu_m=position,
        velocity_enu_mps=velocity,
        fix_type=(_FLOAT_TYPE if is_float else fix_type) if is_fixed else 1,
        eph_m=eph_m if is_fixed else math.inf,
        epv_m=epv_m if is_fixed else math.inf,
        n_satellites=n_heard if is_fixed else 0,
    )
