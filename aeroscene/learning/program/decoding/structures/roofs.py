"""Roofs of houses that are rooms and walls alone, without a building about them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import replace

import shapely
from shapely.geometry.base import BaseGeometry

from aeroscene.layouts.ground import cover
from aeroscene.learning.program.decoding.structures.storeys import outline_in
from aeroscene.partition import BuildingPart
from aeroscene.partition.frames import Frame
from aeroscene.scene import OrientedBox

_TILE_M = 40.0
"""Longest tile, as in layouts that were mapped."""
_SEAM_M = 0.05
"""Gaps between walls that are none: a roof goes over them."""
_SAME_M = 1e-4
_CEILING_M = 0.4
"""Heights of rooms and walls that differ by less are of one storey under one roof."""


def with_one_ceiling(parts: Sequence[BuildingPart]) -> list[BuildingPart]:
    """Rooms and walls, those that end near the height at which most end all ending there."""
    tops_m = Counter(round(_top_m(part.box), 2) for part in parts)
    ceiling_m = max(tops_m, key=lambda top_m: (tops_m[top_m], top_m), default=0.0)
    return [
        replace(part, box=_up_to(part.box, ceiling_m))
        if 0.0 < abs(_top_m(part.box) - ceiling_m) < _CEILING_M
        else part
        for part in parts
    ]


def _top_m(box: OrientedBox) -> float:
    return box.p[2] + box.s[2] / 2


def _up_to(box: OrientedBox, top_m: float) -> OrientedBox:
    base_m = box.p[2] - box.s[2] / 2
    middle, sides = (*box.p[:2], (base_m + top_m) / 2), (*box.s[:2], top_m - base_m)
    return replace(box, p=middle, s=sides)


def ground_plan(parts: Iterable[BuildingPart], frame: Frame) -> BaseGeometry:
    """All that rooms and walls stand on, in a frame that they are aligned with."""
    outlines = [shapely.box(*outline_in(frame, part)) for part in parts]
    house = shapely.union_all(outlines).buffer(_SEAM_M, join_style="mitre")
    house = house.buffer(-_SEAM_M, join_style="mitre")
    # Tiles would be as wide as the widest of corners that are nearly at one height.
    return shapely.set_precision(house, _SAME_M)


def roofs_over(
    parts: Sequence[BuildingPart], frame: Frame, thickness_m: float
) -> list[OrientedBox]:
    """Tiles that cover all rooms and walls from above, and lie on the highest of them."""
    base_m = max(_top_m(part.box) for part in parts)
    tiles = cover(ground_plan(parts, frame), _TILE_M)
    return [frame.inner(tile).box(0, base_m, base_m + thickness_m) for tile in tiles]
