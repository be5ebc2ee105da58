"""Whether a drone of a class can fly from the start to the air above a place."""

from __future__ import annotations

from aeroscene.areas.needs import NEEDS, PERCH_NEEDS, AreaNeeds
from aeroscene.scene import Vector3
from aeroscene.solids.freespace import Flood, NoFreeSpaceError, VoxelField, flood

FIELD_CAP_M = 0.1 + max(needs.flight_radius_m for needs in (*NEEDS.values(), PERCH_NEEDS))
"""Distances beyond this do not matter to any flood."""


class Reach:
    """Floods from one start, each made when it is first asked for."""

    def __init__(self, field: VoxelField, start_enu_m: Vector3) -> None:
        self._field = field
        self._start_enu_m = start_enu_m
        self._floods: dict[float, Flood | None] = {}

    def includes(self, place_enu_m: Vector3, needs: AreaNeeds) -> bool:
        """Whether the flood enters the clear column above a place."""
        reached = self._flood(needs.flight_radius_m)
        cell = self._field.cell(place_enu_m)
        if reached is None or cell is None:
            return False
        # The lowest ball above the surface, half a cell of rounding included.
        rise_m = max(needs.clearance_m, needs.flight_radius_m + 2 * self._field.resolution_m)
        return reached.reaches(cell, int(rise_m / self._field.resolution_m))

    def _flood(self, radius_m: float) -> Flood | None:
        if radius_m not in self._floods:
            try:
                self._floods[radius_m] = flood(self._field, self._start_enu_m, radius_m)
            except NoFreeSpaceError:
                self._floods[radius_m] = None
        return self._floods[radius_m]
