"""Setpoint stream: the controller derives what a setpoint omits from the one before.

Companions send positions and velocities at some 10 to 50 Hz, seldom accelerations, never jerks. The
feed-forward of body rates needs all of them.
"""

from __future__ import annotations

import math

import numpy as np

from autonomy.jit import kernel

# A longer pause begins a new stream. The limits keep a jump of the setpoint from becoming a kick.
_MAX_STREAM_PERIOD_S = 0.25
_MAX_DERIVED_ACCELERATION_MPS2 = 8.0
_MAX_DERIVED_JERK_MPS3 = 60.0


@kernel
def accept_setpoint(c: np.record, s: np.record) -> None:
    """Accept a newly arrived setpoint; an identical one does not count as new.

    Missing derivatives follow from this setpoint and the one before: an acceleration that is NaN
    from the velocities, a jerk that is NaN or zero from the accelerations. A client that repeats
    its last message must not restart the extrapolation, so repetitions are ignored.
    """
    if _is_repeated(c, s):
        return
    elapsed = c.setpoint_age_s
    is_jerk_given = False
    for i in range(3):
        jerk = s.jerk_enu_mps3[i]
        is_jerk_given = is_jerk_given or (math.isfinite(jerk) and jerk != 0.0)
    for i in range(3):
        p, v = s.position_enu_m[i], s.velocity_enu_mps[i]
        a, j = s.acceleration_enu_mps2[i], s.jerk_enu_mps3[i]
        if math.isnan(a):
            a = _slope(c.last_velocity_enu_mps[i], v, elapsed, _MAX_DERIVED_ACCELERATION_MPS2)
        if not is_jerk_given:
            j = _slope(c.setpoint_acceleration_enu_mps2[i], a, elapsed, _MAX_DERIVED_JERK_MPS3)
        c.setpoint_acceleration_enu_mps2[i] = a if math.isfinite(a) else 0.0
        c.setpoint_jerk_enu_mps3[i] = j if math.isfinite(j) else 0.0
        c.last_position_enu_m[i] = p
        c.last_velocity_enu_mps[i] = v
        c.last_acceleration_enu_mps2[i] = s.acceleration_enu_mps2[i]
    c.setpoint_age_s = 0.0


@kernel
def _slope(before: float, now: float, elapsed_s: float, limit: float) -> float:
    """Derivative between two setpoints of a stream; 0 if they belong to different ones."""
    if not 0.0 < elapsed_s < _MAX_STREAM_PERIOD_S:
        return 0.0
    slope = (now - before) / elapsed_s
    return min(max(slope, -limit), limit) if math.isfinite(slope) else 0.0


@kernel
def _is_repeated(c: np.record, s: np.record) -> bool:
    for i in range(3):
        if (
            _differs(s.position_enu_m[i], c.last_position_enu_m[i])
            or _differs(s.velocity_enu_mps[i], c.last_velocity_enu_mps[i])
            or _differs(s.acceleration_enu_mps2[i], c.last_acceleration_enu_mps2[i])
        ):
            return False
    return True


@kernel
def _differs(a: float, b: float) -> bool:
    return a != b and not (math.isnan(a) and math.isnan(b))
