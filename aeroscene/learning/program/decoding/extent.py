"""The flight volume of a decoded scene: over all that the ground covers, or a building."""

from __future__ import annotations

import math
from collections.abc import Sequence

from aeroscene.corpus.curation.curate import HEADROOM_M
from aeroscene.learning.program.program import Program
from aeroscene.relations.plane import Place, Rectangle, turned_reach_m
from aeroscene.scene import SceneObject, Vector3

_OPEN_SKY_M = 22.0
"""Least height of the flight volume under open sky."""
_INDOOR_M = 30.0
"""Sides of a site without ground, until something stands there."""


def site_of(program: Program) -> Rectangle:
    """The flight volume from above as far as the ground says, about the origin."""
    for place, kind in enumerate(program.kinds):
        if kind.node == "site":
            c = program.channels[place, 1:8].tolist()
            half_m = math.exp(min(c[4], 6.0)) / 2, math.exp(min(c[5], 6.0)) / 2
            return Rectangle(Place(0.0, 0.0, 0.0), turned_reach_m(half_m, math.atan2(c[3], c[2])))
    return Rectangle(Place(0.0, 0.0, 0.0), (_INDOOR_M / 2, _INDOOR_M / 2))


def extent_of(
    site: Rectangle, objects: Sequence[SceneObject], domain: str
) -> tuple[Vector3, Vector3]:
    """Corners of the flight volume: up to the roof indoors, some way above everything outdoors."""
    top_m = max((obj.bbox.p[2] + obj.bbox.s[2] / 2 for obj in objects), default=0.0)
    half_x_m, half_y_m = site.half_m
    if domain == "indoor":
        corners = [obj.bbox.corners() for obj in objects if obj.parent_id is None]
        half_x_m = max((abs(c[:, 0]).max() for c in corners), default=half_x_m)
        half_y_m = max((abs(c[:, 1]).max() for c in corners), default=half_y_m)
    else:
        top_m = max(_OPEN_SKY_M, math.ceil(top_m + HEADROOM_M))
    x_m, y_m = round(float(half_x_m), 2), round(float(half_y_m), 2)
    return (-x_m, -y_m, 0.0), (x_m, y_m, round(max(top_m, 1.0), 3))
