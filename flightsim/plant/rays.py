"""Rays in MuJoCo's world, cast from compiled code."""

from __future__ import annotations

import numpy as np

from autonomy.jit import kernel
from flightsim.plant.mujoco_calls import call_mj_ray


@kernel
def cast_ray_m(e: np.record, s: np.record) -> float:
    """Distance to the first solid along a ray that is not of the vehicle; negative for none.

    Args:
        e: Engine of the plant.
        s: Record with `ray`, origin and direction ENU (6,), m, and `ray_geom`, which is written.
    """
    return call_mj_ray(
        e.ray_address,
        e.model_address,
        e.data_address,
        s.ray.ctypes.data,
        s.ray[3:].ctypes.data,
        e.vehicle_body,
        s.ray_geom.ctypes.data,
    )
