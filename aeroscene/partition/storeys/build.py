"""Rooms and walls of a building's storeys, from their partitions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from aeroscene.partition.cells import merged
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
    openings: dict[str, float] = field(default_factory=dict, hash=False)
    """Attributes of a wall, m: `door_m`, `door_offset_m` and so on."""


def build_storeys(storeys: Sequence[StoreyPartition]) -> list[BuildingPart]:
    """Rooms of each storey in pre-order, then all walls.

    Args:
        storeys: Those of one building, from the lowest up, in one frame.

    Raises:
        PartitionError: If doors are wider than the line they are in.
    """
    planned = [plan_walls(storey) for storey in storeys]
    rooms = [part for each in zip(storeys, planned, strict=True) for part in _rooms(*each)]
    walls = fitted([wall for walls in planned for wall in walls])
    return rooms + [_wall_part(wall, storeys[0].frame) for wall in walls]


def _rooms(storey: StoreyPartition, walls: Sequence[Wall]) -> list[BuildingPart]:
    """The rooms, as far as the faces of their walls where these take from them."""
    found: list[BuildingPart] = []
    for cell in merged(storey_cells(storey)):
        bounds = storey.frame.bounds_of(cell.frame)
        if storey.is_inset:
            bounds = _inset(bounds, walls)
        box = storey.frame.inner(bounds).box(cell.leaf.quarter, cell.base_m, cell.top_m)
        found.append(BuildingPart(category="room", kind=cell.leaf.kind, box=box))
    return found


def _inset(bounds: Bounds, walls: Sequence[Wall]) -> Bounds:
    """A room without half of the walls on its sides, along a whole side where one is on part."""
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
    # A wall is long along its own y axis: the frame's y, or minus its x.
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
    return BuildingPart(category="wall", kind=wall.form, box=box, openings=openings)
