"""The yard around a house that consists of rooms and walls alone.

The border of the yard and the walls of the house are numbers of two partitions, each drawn by
itself. The yard is therefore laid anew around the finished walls.
"""

from __future__ import annotations

from collections.abc import Sequence

import shapely

from aeroscene.layouts.ground import cover
from aeroscene.learning.program.decoding.structures.buildings import DecodedBuilding
from aeroscene.learning.program.decoding.structures.roofs import ground_plan
from aeroscene.partition.frames import Bounds, frame_of, hull_of, nearest_quarter
from aeroscene.scene import OrientedBox

_TILE_M = 60.0
"""Longest tile, as in mapped layouts."""
_SAME_M = 1e-4
_ALIGNED_RAD = 1e-3
_WHOLE = 0.85
"""Share of a yard's rectangle that covers and house fill together; with less, gaps are meant."""


def laid_about(
    house: DecodedBuilding, covers: Sequence[OrientedBox]
) -> list[tuple[OrientedBox, int]] | None:
    """Return tiles of a yard around a house, each with the number of the cover that it replaces.

    Args:
        house: The house.
        covers: Boxes of the yard's covers.

    Returns:
        None if the covers are no yard of one level in line with the house.
    """
    frame = house.frame
    bases_m = {round(box.p[2] - box.s[2] / 2, 4) for box in covers}
    offs_rad = (nearest_quarter(box.yaw_rad - frame.yaw_rad)[1] for box in covers)
    if len(bases_m) != 1 or any(abs(off_rad) > _ALIGNED_RAD for off_rad in offs_rad):
        return None
    outlines = [frame.bounds_of(frame_of(box)) for box in covers]
    walled = ground_plan((part for part, _ in house.parts), frame)
    yard = shapely.box(*hull_of(outlines))
    drawn = shapely.union_all([*(shapely.box(*each) for each in outlines), walled])
    if not yard.contains(walled) or drawn.area < _WHOLE * yard.area:
        return None
    (base_m,) = bases_m
    top_m = base_m + covers[0].s[2]
    return [
        (frame.inner(tile).box(0, base_m, top_m), _most_under(tile, outlines))
        for tile in cover(shapely.set_precision(yard.difference(walled), _SAME_M), _TILE_M)
    ]


def _most_under(tile: Bounds, outlines: Sequence[Bounds]) -> int:
    area = shapely.box(*tile)
    shared = [area.intersection(shapely.box(*each)).area for each in outlines]
    return max(range(len(shared)), key=shared.__getitem__)
