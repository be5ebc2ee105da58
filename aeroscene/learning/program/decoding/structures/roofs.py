"""Roofs of houses that consist of rooms and walls alone, without a building around them."""

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
"""Longest tile, as in mapped layouts."""
_SEAM_M = 0.05
"""Gaps between walls up to twice this width are closed, so that the roof covers them."""
_SAME_M = 1e-4
_CEILING_M = 0.4
"""Heights of rooms and walls that differ by less belong to one storey under one roof."""


def with_one_ceiling(parts: Sequence[BuildingPart]) -> list[BuildingPart]:
    """Return rooms and walls that all end at the height at which most of them end.

    Those that end much higher or lower keep their height.
    """
    tops_m = Counter(round(_top_m(part.box), 2) for part in parts)
    # Of two heights that are equally frequent, the higher one counts.
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
    """Return the area of all rooms and walls, in a frame that they are aligned with."""
    outlines = [shapely.box(*outline_in(frame, part)) for part in parts]
    house = shapely.union_all(outlines).buffer(_SEAM_M, join_style="mitre")
    # Out and in again: narrow gaps close, and the outline stays.
    house = house.buffer(-_SEAM_M, join_style="mitre")
    # Corners that differ by rounding would each begin a tile of their own, as
    # narrow as the difference.
    return shapely.set_precision(house, _SAME_M)


def roofs_over(
    parts: Sequence[BuildingPart], frame: Frame, thickness_m: float
) -> list[OrientedBox]:
    """Return tiles that cover all rooms and walls from above and lie on the highest of them."""
    base_m = max(_top_m(part.box) for part in parts)
    tiles = cover(ground_plan(parts, frame), _TILE_M)
    return [frame.inner(tile).box(0, base_m, base_m + thickness_m) for tile in tiles]
