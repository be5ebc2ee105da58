"""Furnished buildings: shell, slabs, rooms and partitions, so that windows stay open."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass

from aeroscene.corpus.curation.builder import Builder, Placed
from aeroscene.corpus.curation.draw import Draw
from aeroscene.corpus.curation.frame import Frame
from aeroscene.corpus.curation.indoor.partitions import raise_walls
from aeroscene.corpus.curation.indoor.room_placement import lay_room
from aeroscene.corpus.curation.indoor.themes import FINISHES
from aeroscene.corpus.curation.indoor.walls import insets
from aeroscene.corpus.curation.indoor.zones import choose_doors, find_borders
from aeroscene.corpus.curation.room_space import RoomSpace
from aeroscene.corpus.curation.storeys import plan_storey
from aeroscene.solids.shapes.facade import (
    LINTEL_M,
    SILL_M,
    SLAB_M,
    SLAB_TOP_M,
    WALL_M,
    FacadePlan,
    count_bays,
    opening_width,
)

STOREY_M = 3.3
_BEARING_M = 0.1
"""Depth by which an upper slab extends into the walls that carry it."""
_APRON_M = 1.3
"""Depth of the air kept free on either side of an opening."""


__all__ = ["STOREY_M", "RoomSpace", "Shell", "raise_shell"]


@dataclass(frozen=True, slots=True)
class Shell:
    """A building, its rooms and its height."""

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
    kinds: Sequence[str],
) -> Shell | None:
    """Place an enterable building with slabs, partitions and rooms.

    Args:
        builder: Builder of the scene.
        draw: Randomness.
        frame: Frame of the parcel.
        at: Middle of the building in that frame, m.
        name: Category of the shell.
        depth: Extent along the building's x, m.
        length: Extent along its y, the front, m.
        storeys: Number of storeys.
        base: Height of the ground, m.
        turn: Heading of the building in the frame, rad.
        colour: Colour of the walls.
        kinds: Kinds of its rooms, in turn.

    Returns:
        The building and its rooms, or None if it does not fit.
    """
    height = round(storeys * STOREY_M, 3)
    look = {"is_enterable": True, "storeys": storeys, "colour": colour}
    size = (depth, length, height)
    spot = frame.moved(*at, turn)
    shell = builder.place(name, spot, size, base=base, margin=0.6, look=look)
    if shell is None:
        return None
    rooms: list[RoomSpace] = []
    # The queue goes on from storey to storey, so that all kinds occur before one repeats.
    waiting = deque(kinds)
    for storey in range(storeys):
        rooms += _fit_out_storey(builder, draw, shell, storey, storeys, waiting)
    _keep_openings_free(builder, shell, storeys)
    return Shell(shell, tuple(rooms), height)


def _fit_out_storey(
    builder: Builder, draw: Draw, shell: Placed, storey: int, storeys: int, kinds: deque[str]
) -> list[RoomSpace]:
    """Lay slab, rooms and the walls between them, with a door to each room."""
    foot = shell.base + storey * STOREY_M
    _lay_slab(builder, shell, foot, is_upper=storey > 0)
    # A storey ends at the underside of the next slab; the last one ends at the roof.
    ceiling = STOREY_M if storey == storeys - 1 else STOREY_M + SLAB_TOP_M - SLAB_M
    level, clear = round(foot + SLAB_TOP_M, 4), round(ceiling - SLAB_TOP_M, 4)
    zones = plan_storey(draw, shell.size[:2], kinds, level, clear)
    borders = find_borders(zones)
    rooms: list[RoomSpace | None] = []
    for zone, margin in zip(zones, insets(zones, borders), strict=True):
        # Rooms may lack space for their zone; walls and doors are those of the zones.
        finish = draw.one_of(FINISHES.get(zone.kind, ("floor_tiles",)))
        rooms.append(lay_room(builder, shell, zone, margin, finish))
    raise_walls(builder, draw, shell, zones, borders, choose_doors(zones, borders))
    return [room for room in rooms if room]


def _lay_slab(builder: Builder, shell: Placed, foot: float, *, is_upper: bool) -> None:
    """Lay a storey's floor; an upper one hangs lower and extends into the walls."""
    under = SLAB_TOP_M - SLAB_M if is_upper else 0.0
    reach = 2 * _BEARING_M if is_upper else 0.0
    depth, length = shell.size[0] - 2 * WALL_M, shell.size[1] - 2 * WALL_M
    size = (depth + reach, length + reach, SLAB_TOP_M - under)
    builder.place("floor", shell.frame, size, base=foot + under, parent=shell, domain="indoor")


def _keep_openings_free(builder: Builder, shell: Placed, storeys: int) -> None:
    """Reserve the air before and behind each window and door, so that a drone can pass."""
    depth, length, _ = shell.size
    door_bay = count_bays(length) // 2
    plan = FacadePlan(length, storeys, STOREY_M, door_bay, "open")
    for storey in range(storeys):
        foot = shell.base + storey * STOREY_M
        for bay in range(plan.n_bays):
            low, high = plan.opening(bay)
            # In front and behind: openings of both long sides lie opposite each other.
            for sign in (-1, 1):
                is_door = sign > 0 and storey == 0 and bay == door_bay
                # A little above the sill, so that furniture below the window does not count.
                sill = SLAB_TOP_M + 0.03 if is_door else SILL_M + 0.05
                size = (2 * _APRON_M, opening_width(length), LINTEL_M - sill)
                at = sign * (depth / 2 - WALL_M / 2)
                builder.reserve(shell.frame.moved(at, (low + high) / 2), size, foot + sill)
