"""Rooms and walls of a building's storeys, built from their partitions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from aeroscene.partition.cells import merged_from
from aeroscene.partition.frames import Bounds, Frame
from aeroscene.partition.storeys.storey import StoreyPartition, storey_cells
from aeroscene.partition.storeys.walls import Wall, fitted, plan_walls
from aeroscene.scene import OrientedBox

_MEET_M = 1e-4


@dataclass(frozen=True, slots=True, kw_only=True)
class BuildingPart:
    """A room or a wall to place."""

    category: str
    kind: str
    """Word of the room's leaf, or of the wall's form."""
    box: OrientedBox
    storey: int
    """Number of its storey."""
    place: int
    """Number of a room's leaf in the storey, the first of several; or of a wall's border."""
    openings: dict[str, float] = field(default_factory=dict, hash=False)
    """Attributes of a wall, m: `door_m`, `door_offset_m` and so on."""


def build_storeys(storeys: Sequence[StoreyPartition]) -> list[BuildingPart]:
    """Return the rooms of each storey in pre-order, then all walls.

    Args:
        storeys: Storeys of one building, from the lowest up, in one frame.

    Raises:
        PartitionError: If doors are wider than their line.
    """
    planned = [plan_walls(storey, number) for number, storey in enumerate(storeys)]
    rooms = [
        part
        for number, (storey, walls) in enumerate(zip(storeys, planned, strict=True))
        for part in _rooms(storey, walls, number)
    ]
    # Walls of all storeys together, because a high wall may meet those of the storey above.
    walls = fitted([wall for walls in planned for wall in walls])
    return rooms + [_wall_part(wall, storeys[0].frame) for wall in walls]


def _rooms(storey: StoreyPartition, walls: Sequence[Wall], number: int) -> list[BuildingPart]:
    """Return the rooms; with inset walls they end at the walls' faces."""
    found: list[BuildingPart] = []
    for leaf, cell in merged_from(storey_cells(storey)):
        bounds = storey.frame.bounds_of(cell.frame)
        if storey.is_inset:
            bounds = _inset(bounds, walls)
        box = storey.frame.inner(bounds).box(cell.leaf.quarter, cell.base_m, cell.top_m)
        found.append(
            BuildingPart(category="room", kind=cell.leaf.kind, box=box, storey=number, place=leaf)
        )
    return found


def _inset(bounds: Bounds, walls: Sequence[Wall]) -> Bounds:
    """Shrink a room by half of the walls on its sides, along a whole side even for a short wall."""
    sides = list(bounds)
    for wall in walls:
        at, line = (1 if wall.axis == "x" else 0), wall.line
        if min(bounds[3 - at], line.high) - max(bounds[1 - at], line.low) < _MEET_M:
            continue
        for side, inwards in ((at, 1), (at + 2, -1)):
            if abs(line.at - bounds[side]) < _MEET_M:
                sides[side] = bounds[side] + inwards * wall.thickness_m / 2
    return (sides[0], sides[1], sides[2], sides[3])


def _wall_part(wall: Wall, frame: Frame) -> BuildingPart:
    # A wall is long along its own y axis: along the frame's y, or along minus its x. Offsets along
    # x therefore change their sign.
    quarter, sign = (0, 1.0) if wall.axis == "y" else (1, -1.0)
    middle = (wall.low + wall.high) / 2
    openings: dict[str, float] = {}
    for opening in wall.openings:
        name, segment = opening.segment.kind, opening.segment
        openings[f"{name}_m"] = opening.high - opening.low
        openings[f"{name}_offset_m"] = sign * ((opening.low + opening.high) / 2 - middle)
        openings[f"{name}_height_m"] = segment.head_m
        if name == "window":
            openings["window_sill_m"] = segment.sill_m
    box = frame.inner(wall.bounds).box(quarter, wall.base_m, wall.top_m)
    return BuildingPart(
        category="wall",
        kind=wall.form,
        box=box,
        storey=wall.storey,
        place=wall.border,
        openings=openings,
    )
