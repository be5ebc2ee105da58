"""Terrain filter: height of the surface below, separate from the altitude.

A rangefinder sees roofs and containers, so its reading must not move the altitude. A scalar Kalman
filter tracks the surface instead: the surface may rise by `terrain_slope` per metre flown. A
lasting jump (a roof's edge) restarts it at the new height; the altitude is not affected.
"""

from __future__ import annotations

import math

import numpy as np

from autonomy.jit import kernel

_MAX_REJECTIONS = 3  # on end, before a jump counts as lasting
_MIN_COSINE = 0.5  # of the tilt: beyond 60 degrees the ray looks aside


@kernel
def fuse_range(f: np.record, range_m: float, interval_s: float) -> None:
    """Fuse a distance along body -z, measured `interval_s` after the previous one.

    An infinite or NaN distance only lets the uncertainty grow.
    """
    q = f.quat_wxyz
    cosine = 1.0 - 2.0 * (q[1] * q[1] + q[2] * q[2])
    vx, vy = f.velocity_enu_mps[0], f.velocity_enu_mps[1]
    step = f.terrain_slope * math.sqrt(vx * vx + vy * vy) * interval_s
    f.terrain_variance_m2 += step * step + 1e-6
    if not math.isfinite(range_m) or cosine < _MIN_COSINE:
        return
    height = f.position_enu_m[2] - range_m * cosine
    # Attitude errors of a degree move the foot of a long ray.
    variance = f.range_variance_m2 + 4e-4 * range_m * range_m * (1.0 - cosine * cosine)
    innovation = height - f.terrain_height_m
    s = f.terrain_variance_m2 + variance
    is_known = math.isfinite(f.terrain_height_m)
    if is_known and innovation * innovation > f.gate_sigma * f.gate_sigma * s:
        f.terrain_rejections += 1
        if f.terrain_rejections < _MAX_REJECTIONS:
            return
        is_known = False
    f.terrain_rejections = 0
    if is_known:
        f.terrain_height_m += f.terrain_variance_m2 / s * innovation
        f.terrain_variance_m2 *= variance / s
    else:
        f.terrain_height_m = height
        f.terrain_variance_m2 = variance
