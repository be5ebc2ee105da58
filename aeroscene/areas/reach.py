"""Whether a drone of a class can fly from the start to the air above a place."""

from __future__ import annotations

from aeroscene.areas.needs import NEEDS, PERCH_NEEDS, AreaNeeds
from aeroscene.scene import Vector3
from aeroscene.solids.freespace import NoFreeSpaceError, VoxelField, reachable

FIELD_CAP_M = 0.1 + max(needs.flight_radius_m for needs in (*NEEDS.values(), PERCH_NEEDS))
"""Distances beyond this do not matter to any flood."""


def is_reached(
    field: VoxelField, start_enu_m: Vector3, place_enu_m: Vector3, needs: AreaNeeds
) -> bool:
    """Whether a drone can get from the start into the clear column above a place."""
    cell = field.cell(place_enu_m)
    try:
        reached = reachable(field, start_enu_m, needs.flight_radius_m)
    except NoFreeSpaceError:
        return False
    return cell is not None and needs.is_entered(reached, cell, field.resolution_m)
