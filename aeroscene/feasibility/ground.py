"""Ground of roots: the lawn or terrace below each building, container or hill without a parent.

Roots move with their ground and stand at its height, although no field of the schema names it.
"""

from __future__ import annotations

import numpy as np

from aeroscene.feasibility.layout import Layout
from aeroscene.feasibility.roles import BEARING
from aeroscene.scene.catalogue import BRIDGES, COVERS, TERRAIN

_HOSTED = 0.5
"""Least share of a root's outline on the ground that carries it."""
_REACH_M = 1.0
"""Distance above or below some ground from which a root does not stand on it."""
_STEEPNESS = 0.4
"""Share of the outline that outweighs a metre of difference in height."""


def find_ground(layout: Layout) -> None:
    """Give each root that stands on other ground this ground as its host."""
    boxes, grounds, is_house = layout.boxes, layout.rows(BEARING), layout.is_house
    for i, obj in enumerate(layout.objects):
        is_none = boxes.parent[i] >= 0 or obj.category in COVERS | BRIDGES
        if is_none or is_house[i]:
            continue
        layout.host[i] = _best_ground(layout, i, grounds)
    layout.relink()


def _best_ground(layout: Layout, row: int, grounds: list[int]) -> int:
    """The ground below most of a root, at about its height; -1 for the bare earth."""
    boxes, best, found = layout.boxes, 0.0, -1
    is_terrain = layout.objects[row].category in TERRAIN
    for ground in grounds:
        # Neither ground that the root itself carries, nor a hill below a hill.
        if row in layout.chain(ground) or (is_terrain and _is_hill(layout, ground)):
            continue
        share = covered(layout, row, ground)
        off_m = abs(float(boxes.base_m[row] - boxes.top_m[ground]))
        # Within a hill a root may begin anywhere below the top.
        if _is_hill(layout, ground):
            off_m = max(0.0, float(boxes.base_m[row] - boxes.top_m[ground]))
        score = share - _STEEPNESS * off_m
        if share >= _HOSTED and off_m < _REACH_M and score > best:
            best, found = score, ground
    return found


def _is_hill(layout: Layout, row: int) -> bool:
    return layout.objects[row].category in TERRAIN


def covered(layout: Layout, row: int, ground: int) -> float:
    """Share of an outline that lies over ground, from a grid of 49 points.

    Args:
        layout: Layout.
        row: Object whose outline it is.
        ground: Row of the ground.

    Returns:
        Share, 0 to 1.
    """
    boxes = layout.boxes
    # Off the outline's border, where neighbours touch.
    steps = np.linspace(-0.9, 0.9, 7)
    u, v = np.meshgrid(steps, steps)
    local = np.stack([u.ravel(), v.ravel()], axis=1) * boxes.half_m[row, :2]
    points = boxes.centre_m[row, :2] + local @ boxes.frame(row)
    inside = np.abs((points - boxes.centre_m[ground, :2]) @ boxes.frame(ground).T)
    return float((inside <= boxes.half_m[ground, :2]).all(axis=1).mean())
