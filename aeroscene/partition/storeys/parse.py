"""Reading of storeys' partitions off the boxes of rooms and walls.

Rooms of a building end at the faces of their walls, so they do not touch. Each room is first
widened to the middles of its walls, and the widened rooms divide the storey. Layouts with walls
outside all rooms keep their rooms as they are; their outer walls stand beyond the lines.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from statistics import median

from aeroscene.partition.cells import cells_of
from aeroscene.partition.fit import Piece, fit, number_merges
from aeroscene.partition.frames import Bounds, Frame, frame_of, hull_of, nearest_quarter
from aeroscene.partition.storeys.borders import StandingWall, read_border, stands_on
from aeroscene.partition.storeys.storey import (
    NOBODY,
    StoreyPartition,
    find_lines,
)
from aeroscene.partition.tree import Leaf, PartitionError
from aeroscene.scene import Scene, SceneObject
from aeroscene.scene.catalogue import ROOMS, WALLS

# Headings that differ by less are aligned, and undersides of rooms belong to one storey.
_ALIGNED_RAD = 2e-3
_SAME_LEVEL_M = 0.3
_FACE_M = 0.008
"""A room's side that is this near to a wall's face ends at it."""
# Walls that reach further than this beyond all rooms stand outside.
_OUTSIDE_M = 0.012

Word = Callable[[SceneObject], str]


def room_word(obj: SceneObject) -> str:
    """Return the kind of a room's leaf: its use, if the scene states it."""
    attributes = obj.attributes
    return str(attributes.get("use", attributes.get("room_type", "room")))


@dataclass(frozen=True, slots=True, kw_only=True)
class ParsedBuilding:
    """The storeys of a building, and the objects of the scene that they stand for."""

    host_id: int | None
    """Id of the shell; None for rooms without one."""
    storeys: tuple[StoreyPartition, ...]
    """Storeys from the lowest up."""
    object_ids: frozenset[int]
    """Ids of rooms, and of walls on their borders."""
    free_wall_ids: frozenset[int]
    """Walls of the building that stand on no border."""


@dataclass(frozen=True, slots=True)
class _Room:
    obj: SceneObject
    bounds: Bounds
    base_m: float
    top_m: float


def building_partitions(scene: Scene, word: Word = room_word) -> list[ParsedBuilding]:
    """Read the partitions of all buildings that have rooms.

    Boxes, categories and parents are read, and nothing else. Rooms with the same number in the
    attribute `room` are one room: mapped layouts cut rooms that are no rectangles into tiles.

    Args:
        scene: Any scene.
        word: Kind of the leaf that a room becomes.

    Raises:
        PartitionError: If a room is turned against its building or overlaps another.
    """
    hosts = dict.fromkeys(obj.parent_id for obj in scene.objects if obj.category in ROOMS)
    return [storey_partitions(scene, host, word) for host in hosts]


def storey_partitions(scene: Scene, host_id: int | None, word: Word = room_word) -> ParsedBuilding:
    """Read the partitions of the storeys of one building, see `building_partitions`.

    Args:
        scene: Any scene.
        host_id: Id of the building; None for rooms without one.
        word: Kind of the leaf that a room becomes.
    """
    others = scene.children_by_id[host_id]
    rooms = [obj for obj in others if obj.category in ROOMS]
    head = rooms[0] if host_id is None else scene.object_by_id[host_id]
    plane = Frame(0.0, 0.0, head.bbox.yaw_rad, 0.0, 0.0)
    walls = [_standing(obj, plane) for obj in others if obj.category in WALLS]
    placed = [_room(obj, plane) for obj in rooms]
    walls = [
        wall for wall in walls if wall and (host_id is not None or wall.obj.domain == "indoor")
    ]
    hull = hull_of(room.bounds for room in placed)
    is_inset = not any(_reaches_out(wall.bounds, hull) for wall in walls)
    zones = [_zone(room, walls) if is_inset else room.bounds for room in placed]
    frame = plane.inner(hull_of(zones))
    corner = plane.local(*frame.point(0.0, 0.0))
    walls = [wall.moved(-corner[0], -corner[1]) for wall in walls]
    levels: list[float] = []
    for base in sorted(room.base_m for room in placed):
        if not levels or base - levels[-1] > _SAME_LEVEL_M:
            levels.append(base)
    used: set[int] = set()
    storeys: list[StoreyPartition] = []
    for level in levels:
        pieces = [
            _piece(room, zone, corner, frame, word)
            for room, zone in zip(placed, zones, strict=True)
            if abs(room.base_m - level) <= _SAME_LEVEL_M
        ]
        # A wall belongs to the storey with the nearest level.
        near = [w for w in walls if min(levels, key=lambda at: abs(at - w.base_m)) == level]
        storey, found = _storey(pieces, frame, level, near, is_inset=is_inset)
        storeys.append(storey)
        used |= found
    return ParsedBuilding(
        host_id=host_id,
        storeys=tuple(storeys),
        object_ids=frozenset(used | {obj.id for obj in rooms}),
        free_wall_ids=frozenset(wall.obj.id for wall in walls if wall.obj.id not in used),
    )


def _room(obj: SceneObject, plane: Frame) -> _Room:
    if abs(nearest_quarter(obj.bbox.yaw_rad - plane.yaw_rad)[1]) > _ALIGNED_RAD:
        raise PartitionError(f"room {obj.id} is turned against its building; valid: aligned")
    half = obj.bbox.s[2] / 2
    return _Room(
        obj, plane.bounds_of(frame_of(obj.bbox)), obj.bbox.p[2] - half, obj.bbox.p[2] + half
    )


def _standing(obj: SceneObject, plane: Frame) -> StandingWall | None:
    quarter, rest = nearest_quarter(obj.bbox.yaw_rad - plane.yaw_rad)
    if abs(rest) > _ALIGNED_RAD:
        return None
    return StandingWall(obj, plane.bounds_of(frame_of(obj.bbox)), quarter)


def _reaches_out(bounds: Bounds, hull: Bounds) -> bool:
    """True if a wall stands outside all rooms, which then end at lines, not at faces of walls."""
    low = min(bounds[i] - hull[i] for i in (0, 1))
    high = max(bounds[i] - hull[i] for i in (2, 3))
    return low < -_OUTSIDE_M or high > _OUTSIDE_M


def _zone(room: _Room, walls: Sequence[StandingWall]) -> Bounds:
    """Return a room widened to the middles of the walls around it."""
    sides = list(room.bounds)
    for wall in walls:
        # Walls of other storeys do not count; neither do those that touch
        # the room at a corner only.
        if wall.base_m > room.top_m - 0.1 or wall.top_m < room.base_m + 0.1:
            continue
        across = 1 if wall.axis == "x" else 0
        low, high = wall.bounds[1 - across], wall.bounds[3 - across]
        if min(high, room.bounds[3 - across]) - max(low, room.bounds[1 - across]) < 0.05:
            continue
        for side, face in ((across, across + 2), (across + 2, across)):
            if abs(wall.bounds[face] - room.bounds[side]) < _FACE_M:
                sides[side] = wall.middle
    return (sides[0], sides[1], sides[2], sides[3])


def _piece(
    room: _Room, zone: Bounds, corner: tuple[float, float], frame: Frame, word: Word
) -> Piece:
    quarter, _ = nearest_quarter(room.obj.bbox.yaw_rad - frame.yaw_rad)
    number = room.obj.attributes.get("room")
    key = number + 1 if isinstance(number, int) else room.obj.id + 1
    x, y = corner
    bounds = (zone[0] - x, zone[1] - y, zone[2] - x, zone[3] - y)
    return Piece(bounds, Leaf(word(room.obj), room.top_m - room.base_m, quarter), key)


def _storey(
    pieces: Sequence[Piece],
    frame: Frame,
    level: float,
    walls: Sequence[StandingWall],
    *,
    is_inset: bool,
) -> tuple[StoreyPartition, set[int]]:
    tree = number_merges(fit(pieces, hull=(0.0, 0.0, frame.length_m, frame.width_m)))
    cells = list(cells_of(tree, frame, level))
    lines = find_lines(cells, frame, has_outside=not is_inset)
    on_line = [[w for w in walls if stands_on(w, line, is_inset=is_inset)] for line in lines]
    inner: list[float] = []
    outer: list[float] = []
    drops: list[float] = []
    for line, standing in zip(lines, on_line, strict=True):
        is_edge = NOBODY in line.rooms
        for wall in standing:
            (outer if is_edge and not is_inset else inner).append(wall.thickness_m)
            if is_edge and is_inset:
                drops.append(level - wall.base_m)
    storey = StoreyPartition(
        frame=frame,
        level_m=level,
        tree=tree,
        borders=tuple(read_border(n, each) for n, each in zip(lines, on_line, strict=True)),
        # Thicknesses without any wall are the usual ones.
        wall_m=median(inner) if inner else 0.12,
        outer_m=0.0 if is_inset else (median(outer) if outer else 0.15),
        drop_m=median(drops) if drops else 0.0,
        is_inset=is_inset,
    )
    return storey, {wall.obj.id for standing in on_line for wall in standing}
