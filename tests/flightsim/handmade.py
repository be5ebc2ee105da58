"""Handmade small scenes, for tests that need to know every solid."""

import math
from dataclasses import replace

import numpy as np

from aeroscene.scene import Relief, Scene
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


def hills(spacing_m=1.0, half_m=40.0, height_m=4.0):
    """Waves of some metres, with level ground around the origin."""
    line = np.arange(-half_m, half_m + spacing_m / 2, spacing_m)
    x, y = line[None, :], line[:, None]
    away = np.clip((np.hypot(x, y) - 3.0) / 8.0, 0.0, 1.0)
    waves = np.sin(x / 7.0) * np.cos(y / 9.0) + 0.3 * np.sin(y / 4.0 + x / 11.0)
    return Relief((-half_m, -half_m), spacing_m, np.round(height_m * away * waves, 3))


def incline(east, north, height_m=0.0, half_m=40.0):
    """A plane with gradients towards east and north, and a height at the origin."""
    line = np.array([-half_m, 0.0, half_m])
    heights = height_m + east * line[None, :] + north * line[:, None]
    return Relief((-half_m, -half_m), half_m, heights)


def relief_scene(relief, start_xy=(0.0, 0.0), ceiling_m=60.0):
    """An empty scene with a relief, which starts on the ground."""
    x, y = start_xy
    low, high = empty_scene().extent_min_enu_m, empty_scene().extent_max_enu_m
    return replace(
        empty_scene(),
        scene_id="relief",
        extent_min_enu_m=(*low[:2], math.floor(relief.min_m) - 1.0),
        extent_max_enu_m=(*high[:2], ceiling_m),
        start_position_enu_m=(x, y, float(relief.height_m(x, y))),
        relief=relief,
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
