"""Roofs of houses that are rooms and walls alone, without a building about them."""

from __future__ import annotations

from collections.abc import Sequence

import shapely

from aeroscene.layouts.ground import cover
from aeroscene.learning.program.decoding.stacking import outline_in
from aeroscene.partition import BuildingPart
from aeroscene.partition.frames import Frame
from aeroscene.scene import OrientedBox

_TILE_M = 40.0
"""Longest tile, as in layouts that were mapped."""
_SEAM_M = 0.05
"""Gaps between walls that a roof goes over."""
_SAME_M = 1e-4


def roofs_over(
    parts: Sequence[BuildingPart], frame: Frame, thickness_m: float
) -> list[OrientedBox]:
    """Tiles that cover all rooms and walls from above, and lie on the highest of them."""
    outlines = [shapely.box(*outline_in(frame, part)) for part in parts]
    house = shapely.union_all(outlines).buffer(_SEAM_M, join_style="mitre")
    house = house.buffer(-_SEAM_M, join_style="mitre")
    # Tiles would be as wide as the widest of corners that are nearly at one height.
    house = shapely.set_precision(house, _SAME_M)
    base_m = max(part.box.p[2] + part.box.s[2] / 2 for part in parts)
    tiles = cover(house, _TILE_M)
    return [frame.inner(tile).box(0, base_m, base_m + thickness_m) for tile in tiles]
