"""Messages of navigation: satellites, the estimator's health, air and time.

`flightsim.sensors.gnss_reading` and `flightsim.plant.readings` are the same for Python.
"""

from __future__ import annotations

import math

import numpy as np

from autonomy.jit import kernel
from flightsim.environment.date import EPOCH_US
from flightsim.mavlink.dialect import dialect as mav
from flightsim.mavlink.streaming.motion import FULL_TURN_CENTIDEG, place_of, within
from flightsim.plant.readings import DEAD_RECKONING_S, MAX_HORIZONTAL_SIGMA_M
from flightsim.sensors.failure import Failure

_OFF = int(Failure.OFF)
_NO_FIX, _RTK_FLOAT = mav.GPS_FIX_TYPE_NO_FIX, mav.GPS_FIX_TYPE_RTK_FLOAT
_MOST_SATELLITES = 254.0
_UNKNOWN_U16 = 65535.0
_ATTITUDE = mav.ESTIMATOR_ATTITUDE
_UNAIDED = mav.ESTIMATOR_CONST_POS_MODE
"""Flag: no external measurements of the position are in use."""
_POSITION = 0b11_0111_1110
"""Flags: velocities, positions relative and absolute, height above ground, and their predictions.
"""


@kernel
def fill_navigation(m: np.record, p: np.record, v: np.record) -> None:
    """Fill the messages of satellites, of the estimator, of the air and of the time.

    Args:
        m: `VALUES_DTYPE`, changed.
        p: `PLANT_DTYPE`.
        v: `VIEW_DTYPE` of the same tick.
    """
    _fill_fix(m.GPS_RAW_INT, p.gnss, p.engine.tick_us, v)
    _fill_estimator(m.ESTIMATOR_STATUS, p.filter, v)
    _fill_air(m.WIND_COV, m.VIBRATION, p.filter.wind_enu_mps, v)
    _fill_time(m.SYSTEM_TIME, v)


@kernel
def _fill_fix(m: np.record, r: np.record, tick_us: int, v: np.record) -> None:
    m.is_known = 1.0
    is_on = r.is_enabled == 1 and r.failure[0] != _OFF
    # After a gap of the sky the receiver needs some ticks until it has a fix again.
    is_fixed = is_on and r.under_sky_ticks >= r.reacquire_ticks and r.tick >= 0
    m.time_usec = max(0, r.tick) * tick_us
    latitude_deg, longitude_deg, altitude_m = place_of(v, r.position_enu_m)
    m.lat, m.lon = np.rint(latitude_deg * 1e7), np.rint(longitude_deg * 1e7)
    m.alt = m.alt_ellipsoid = np.rint(altitude_m * 1e3)
    east_mps, north_mps = r.velocity_enu_mps[0], r.velocity_enu_mps[1]
    m.vel = _uint16(100.0 * math.hypot(north_mps, east_mps))
    course_deg = math.degrees(math.atan2(east_mps, north_mps)) % 360.0
    m.cog = np.rint(course_deg * 100.0) % FULL_TURN_CENTIDEG
    # 65535 is "unknown"; without a fix nothing is claimed.
    m.eph = m.epv = _UNKNOWN_U16
    m.h_acc = m.v_acc = m.satellites_visible = 0.0
    m.fix_type = _NO_FIX
    if is_fixed:
        eph_m, epv_m = _accuracy_m(r, 0), _accuracy_m(r, 1)
        m.eph, m.epv = _uint16(100.0 * eph_m), _uint16(100.0 * epv_m)
        m.h_acc, m.v_acc = np.rint(1e3 * eph_m), np.rint(1e3 * epv_m)
        m.satellites_visible = min(_MOST_SATELLITES, r.n_heard)
        m.fix_type = _RTK_FLOAT if r.is_float else r.fix_type


@kernel
def _accuracy_m(r: np.record, k: int) -> float:
    """Return the accuracy that the receiver claims, horizontally (0) or vertically (1), m."""
    ambiguous_m = r.is_float * r.float_sigma_m
    white_m = math.hypot(r.reported_accuracy_m[k], ambiguous_m) * r.dilution[2 * k]
    return math.hypot(math.hypot(white_m, r.multipath_now_sigma_m[2 * k]), r.settling_sigma_m)


@kernel
def _fill_estimator(m: np.record, f: np.record, v: np.record) -> None:
    m.is_known = 1.0
    m.time_usec = v.time_us
    m.vel_ratio, m.pos_horiz_ratio = f.ratio_gnss_velocity, f.ratio_gnss_position
    m.pos_vert_ratio, m.mag_ratio = f.ratio_baro, f.ratio_heading
    m["flags"] = 0.0  # numpy's records have an attribute of that name
    m.pos_horiz_accuracy = m.pos_vert_accuracy = math.inf
    if f.is_aligned == 1:
        # Root of both horizontal variances.
        m.pos_horiz_accuracy = math.sqrt(f.covariance[0, 0] + f.covariance[1, 1])
        m.pos_vert_accuracy = math.sqrt(f.covariance[2, 2])
        m["flags"] = _ATTITUDE
        if m.pos_horiz_accuracy < MAX_HORIZONTAL_SIGMA_M:
            m["flags"] = _ATTITUDE | _POSITION
        # Dead reckoning: nothing has measured the position for this long.
        if (f.tick - f.last_position_tick) * f.dt_s > DEAD_RECKONING_S:
            m["flags"] += _UNAIDED


@kernel
def _fill_air(
    wind: np.record, vibration: np.record, wind_enu_mps: np.ndarray, v: np.record
) -> None:
    wind.is_known = vibration.is_known = 1.0
    wind.time_usec = vibration.time_usec = v.time_us
    wind.wind_x, wind.wind_y = wind_enu_mps[1], wind_enu_mps[0]
    wind.wind_alt = v.altitude_est_m


@kernel
def _fill_time(m: np.record, v: np.record) -> None:
    m.is_known = 1.0
    m.time_unix_usec = EPOCH_US + v.time_us
    m.time_boot_ms = v.time_boot_ms


@kernel
def _uint16(value: float) -> float:
    """Return a number in 16 bits, of which the greatest means unknown."""
    if not math.isfinite(value):
        return _UNKNOWN_U16
    return within(np.rint(value), 0.0, _UNKNOWN_U16 - 1.0)
