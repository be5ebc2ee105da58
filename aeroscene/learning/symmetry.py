"""Symmetries of the square, which vary training scenes.

A site has no preferred compass direction, so each training scene may be seen turned by quarter
turns, and indoors mirrored as well. One scene then teaches up to eight.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from aeroscene.landform import level
from aeroscene.scene import OrientedBox, Scene, SceneDomain

_N_SYMMETRIES = 8


def draw_symmetry(domain: SceneDomain, rng: np.random.Generator) -> tuple[int, bool]:
    """Draw one of the eight symmetries, or one of four outdoors.

    Returns:
        The number of quarter turns, 0 to 3, and True if the scene is mirrored along y after them.
    """
    turns, is_mirrored = divmod(int(rng.integers(_N_SYMMETRIES)), 2)
    return turns, bool(is_mirrored) and may_be_mirrored(domain)


def may_be_mirrored(domain: SceneDomain) -> bool:
    """True if the mirror image of such a scene is plausible too.

    Outdoors it is not, because vehicles keep to the right.
    """
    return domain == "indoor"


def mirrored(scene: Scene) -> Scene:
    """Mirror a scene along y, on flat ground and without its interaction areas.

    The areas are left out because they are derived from geometry; derive them anew if you need
    them.
    """
    scene = level(scene)
    (x0, y0, z0), (x1, y1, z1) = scene.extent_min_enu_m, scene.extent_max_enu_m
    x, y, z = scene.start_position_enu_m
    return replace(
        scene,
        objects=tuple(replace(obj, bbox=_mirrored_box(obj.bbox)) for obj in scene.objects),
        interaction_areas=(),
        extent_min_enu_m=(x0, -y1, z0),
        extent_max_enu_m=(x1, -y0, z1),
        start_position_enu_m=(x, -y, z),
        start_yaw_rad=-scene.start_yaw_rad,
    )


def _mirrored_box(box: OrientedBox) -> OrientedBox:
    """Mirror a box along y; its body axis x goes with it."""
    x_m, y_m, z_m = box.p
    w, x, y, z = box.q
    # A mirror image reverses rotation about x and z and keeps it about y.
    return replace(box, p=(x_m, -y_m, z_m), q=(w, -x, y, -z))
