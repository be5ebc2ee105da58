"""Headings: parts of a building are made square to it, and so are objects that nearly are.

Sampled headings are slightly off. A slanted wall cannot meet its neighbours, so parts of a building
are always squared. Other coarse objects are squared only if they overlap and are slightly off.
"""

from __future__ import annotations

import math

import numpy as np

from aeroscene.feasibility.layout import Layout
from aeroscene.scene.catalogue import BUILDING_PARTS, BUILDINGS

_SLIGHT_RAD = math.radians(9.0)
"""Angle up to which a coarse object in conflict is turned square to its base."""
_LEAST_RAD = 1e-4
_QUARTER = math.pi / 2
_TOUCH_M = 0.001


def square_up(layout: Layout) -> None:
    """Turn coarse objects that are nearly square to their base, if it matters."""
    overlaps = layout.overlaps(_TOUCH_M)
    in_conflict = set(np.unique(overlaps.pairs).tolist())
    site_rad = _site_heading_rad(layout)
    for row, obj in enumerate(layout.objects):
        if not obj.is_coarse:
            continue
        parent, host = layout.parent_of(row), int(layout.host[row])
        # A part is made square to what carries it, and all else to most of the site.
        to_rad = site_rad if host < 0 else float(layout.boxes.yaw_rad[host])
        off_rad = math.remainder(float(layout.boxes.yaw_rad[row]) - to_rad, _QUARTER)
        # Parts of a building always, whatever the angle; all others only if slightly off and in
        # conflict.
        if parent is not None and parent.category in BUILDINGS:
            is_due = obj.category in BUILDING_PARTS
        else:
            is_due = row in in_conflict and abs(off_rad) < _SLIGHT_RAD
        if is_due and abs(off_rad) > _LEAST_RAD:
            layout.turn(row, -off_rad)


def _site_heading_rad(layout: Layout) -> float:
    """Heading, up to quarter turns, that most of the ground plan shares by area."""
    boxes = layout.boxes
    roots = np.flatnonzero((layout.host < 0) & layout.is_present)
    if not len(roots):
        return 0.0
    area = boxes.half_m[roots, :2].prod(axis=1)
    yaw = boxes.yaw_rad[roots]
    off = np.abs(np.remainder(yaw[:, None] - yaw[None, :] + _QUARTER / 2, _QUARTER) - _QUARTER / 2)
    return float(yaw[(area * (off < math.radians(2.0))).sum(axis=1).argmax()])
