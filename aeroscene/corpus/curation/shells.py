"""Furnished buildings: shell, slabs, rooms and partitions, so that windows stay open."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

from aeroscene.corpus.curation.builder import Builder, Placed
from aeroscene.corpus.curation.draw import Draw
from aeroscene.corpus.curation.frame import QUARTER, Frame
from aeroscene.scene import Vector3
from aeroscene.solids.shapes.facade import (
    LINTEL_M,
    SILL_M,
    SLAB_M,
    SLAB_TOP_M,
    WALL_M,
    FacadePlan,
    bay_borders,
    count_bays,
    opening_width,
)
from aeroscene.solids.shapes.shell import FINISH_M

PARTITION_M = 0.12
STOREY_M = 3.3
DOOR_M = 1.5
"""Width of a door in a partition."""
_BEARING_M = 0.1
"""How far an upper slab reaches into the walls that carry it."""
_APRON_M = 1.3
"""Depth of the air kept free on either side of an opening."""


@dataclass(frozen=True, slots=True)
class RoomSpace:
    """A room to furnish: x towards the building's front, y to its left."""

    placed: Placed

    @property
    def floor(self) -> float:
        """Height on which furniture stands."""
        return self.placed.base + FINISH_M


@dataclass(frozen=True, slots=True)
class Shell:
    """A building with its rooms."""

    building: Placed
    rooms: tuple[RoomSpace, ...]
    height: float


def raise_shell(
    builder: Builder,
    draw: Draw,
    frame: Frame,
    at: tuple[float, float],
    *,
    name: str,
    depth: float,
    length: float,
    storeys: int,
    base: float,
    turn: float,
    colour: str,
) -> Shell | None:
    """Place an enterable building with slabs, partitions and rooms, or None if it does not fit."""
    height = round(storeys * STOREY_M, 3)
    look = {"is_enterable": True, "storeys": storeys, "colour": colour}
    size = (depth, length, height)
    spot = frame.moved(*at, turn)
    shell = builder.place(name, spot, size, base=base, margin=0.6, look=look)
    if shell is None:
        return None
    rooms: list[RoomSpace] = []
    for storey in range(storeys):
        rooms += _fit_out_storey(builder, draw, shell, storey, storeys)
    _keep_openings_free(builder, shell, storeys)
    return Shell(shell, tuple(rooms), height)


def _fit_out_storey(
    builder: Builder, draw: Draw, shell: Placed, storey: int, storeys: int
) -> list[RoomSpace]:
    """Slab, partitions and rooms of one storey."""
    depth, length = shell.size[0] - 2 * WALL_M, shell.size[1] - 2 * WALL_M
    foot = shell.base + storey * STOREY_M
    _lay_slab(builder, shell, foot, is_upper=storey > 0)
    ceiling = STOREY_M if storey == storeys - 1 else STOREY_M + SLAB_TOP_M - SLAB_M
    floor, clear = foot + SLAB_TOP_M, ceiling - SLAB_TOP_M
    cuts = _partition_places(draw, shell.size[1])
    doors: list[float] = []
    for cut in cuts:
        offset = draw.between(-0.25, 0.25) * depth
        _part(builder, shell, cut, (PARTITION_M, depth, clear), floor, offset)
        doors.append(-offset)  # The partition's own y axis is the building's -x axis.
    rooms: list[RoomSpace] = []
    for index, (left, right) in enumerate(pairwise([-length / 2, *cuts, length / 2])):
        low = left + (PARTITION_M / 2 if index else 0.0)
        high = right - (PARTITION_M / 2 if index < len(cuts) else 0.0)
        spot = shell.frame.moved(0, (low + high) / 2)
        size = (depth, high - low, clear)
        look = {"finish": draw.one_of(("parquet", "floor_tiles", "carpet"))}
        placed = builder.place(
            "room", spot, size, base=floor, parent=shell, domain="indoor", look=look
        )
        if placed:
            rooms.append(RoomSpace(placed))
    for u, v in zip(doors, cuts, strict=True):
        builder.reserve(shell.frame.moved(u, v), (DOOR_M + 0.2, 2 * _APRON_M, 2.5), floor + 0.1)
    return rooms


def _lay_slab(builder: Builder, shell: Placed, foot: float, *, is_upper: bool) -> None:
    """A storey's floor; an upper one hangs lower and reaches into the walls."""
    under = SLAB_TOP_M - SLAB_M if is_upper else 0.0
    reach = 2 * _BEARING_M if is_upper else 0.0
    depth, length = shell.size[0] - 2 * WALL_M, shell.size[1] - 2 * WALL_M
    size = (depth + reach, length + reach, SLAB_TOP_M - under)
    builder.place("floor", shell.frame, size, base=foot + under, parent=shell, domain="indoor")


def _part(
    builder: Builder, shell: Placed, cut: float, size: Vector3, floor: float, door_offset_m: float
) -> None:
    """A partition with a door across the building."""
    spot = shell.frame.moved(0, cut, QUARTER)
    look = {"door_m": DOOR_M, "door_offset_m": door_offset_m, "colour": "white"}
    builder.place("wall", spot, size, base=floor, parent=shell, domain="indoor", look=look)


def _partition_places(draw: Draw, length: float) -> list[float]:
    """Borders between bays that part a storey into rooms of at least two bays each."""
    borders = bay_borders(length)
    n_bays = len(borders) + 1
    if n_bays < 4 or draw.chance(0.12):
        return []
    if n_bays >= 6:
        return [borders[1], borders[-2]] if draw.chance(0.5) else [borders[n_bays // 2 - 1]]
    return [borders[1 + draw.count(0, n_bays - 4)]]


def _keep_openings_free(builder: Builder, shell: Placed, storeys: int) -> None:
    """Reserve the air before and behind each window and door, so that a drone can pass."""
    depth, length, _ = shell.size
    door_bay = count_bays(length) // 2
    plan = FacadePlan(length, storeys, STOREY_M, door_bay, "open")
    for storey in range(storeys):
        foot = shell.base + storey * STOREY_M
        for bay in range(plan.n_bays):
            low, high = plan.opening(bay)
            for sign in (-1, 1):
                is_door = sign > 0 and storey == 0 and bay == door_bay
                sill = SLAB_TOP_M + 0.03 if is_door else SILL_M + 0.05
                size = (2 * _APRON_M, opening_width(length), LINTEL_M - sill)
                at = sign * (depth / 2 - WALL_M / 2)
                builder.reserve(shell.frame.moved(at, (low + high) / 2), size, foot + sill)
