"""Reachability: a drone of a class can fly from the start to the air above a place.

Free space is divided into cells, and cells with enough distance from every solid are flooded from
the start. A flood answers the question for all places at once; a path search would answer it for
one.
"""

from __future__ import annotations

from collections.abc import Sequence

from aeroscene.areas.needs import NEEDS, PERCH_NEEDS, AreaNeeds
from aeroscene.scene import Scene, Vector3
from aeroscene.solids.freespace import NoFreeSpaceError, VoxelField, build_distance_field, reachable
from aeroscene.solids.shapes import Primitive
from aeroscene.solids.wide_field import is_wide

FIELD_CAP_M = 0.1 + max(needs.flight_radius_m for needs in (*NEEDS.values(), PERCH_NEEDS))
"""Greatest distance in the field; no flood needs a greater one."""


_CELL_M = 0.25
"""Edge of the cells in which free space is flooded. It is twice as long in large scenes, whose
narrow passages then count as closed."""


def access_field(scene: Scene, primitives: Sequence[Primitive]) -> VoxelField:
    """Build the distance field of a scene, for floods of its free space."""
    cell_m = 2 * _CELL_M if is_wide(scene, _CELL_M) else _CELL_M
    return build_distance_field(scene, cell_m, primitives, FIELD_CAP_M)


def is_reached(
    field: VoxelField, start_enu_m: Vector3, place_enu_m: Vector3, needs: AreaNeeds
) -> bool:
    """True if a drone can fly from the start into the clear column above a place.

    Args:
        field: Distance field of the scene.
        start_enu_m: Start of the flight. If it is not free, nothing is reached.
        place_enu_m: The place.
        needs: Requirements of the drone.
    """
    cell = field.cell(place_enu_m)
    try:
        reached = reachable(field, start_enu_m, needs.flight_radius_m)
    except NoFreeSpaceError:
        return False
    return cell is not None and needs.is_entered(reached, cell, field.resolution_m)
