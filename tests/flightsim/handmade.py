"""Handmade small scenes, for tests that need to know every solid."""

import math

import numpy as np

from aeroscene.scene import Scene
from aeroscene.solids.shapes import Primitive

RAY_GROUPS = np.array([1, 0, 0, 0, 1, 0], dtype=np.uint8)
"""`geomgroup` of `mj_ray`: the solid world and what moves in it, without the vehicle."""


def empty_scene(start=(0.0, 0.0, 0.0), yaw_rad=0.0):
    return Scene(
        scene_id="handmade",
        domain="outdoor",
        seed=0,
        extent_min_enu_m=(-40.0, -40.0, 0.0),
        extent_max_enu_m=(40.0, 40.0, 30.0),
        start_position_enu_m=start,
        start_yaw_rad=yaw_rad,
        latitude_deg=47.4,
        longitude_deg=8.5,
        altitude_m=488.0,
        objects=(),
    )


def solid(kind, position_enu_m, size_m, *, material="concrete", object_id=7, quat=None, **more):
    return Primitive(
        kind=kind,
        position_enu_m=position_enu_m,
        quat_wxyz=quat or (1.0, 0.0, 0.0, 0.0),
        size_m=size_m,
        material=material,
        object_id=object_id,
        collides=more.pop("collides", True),
        **more,
    )


def slope(angle_deg, *, material="concrete"):
    """A large slab whose top passes through (0, 0, 5), tilted about x."""
    a = math.radians(angle_deg)
    return solid(
        "box",
        (0.0, math.sin(a), 5.0 - math.cos(a)),
        (20.0, 20.0, 2.0),
        material=material,
        quat=(math.cos(a / 2), math.sin(a / 2), 0.0, 0.0),
    )
