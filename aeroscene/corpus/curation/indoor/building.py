"""Construction of a floor plan: shell, roof, slabs, rooms, walls with doors, rails and stairs."""

from __future__ import annotations

from collections.abc import Sequence

from aeroscene.corpus.curation.builder import Builder, Placed
from aeroscene.corpus.curation.draw import Draw
from aeroscene.corpus.curation.frame import Frame
from aeroscene.corpus.curation.indoor.floor_plan import Building, FloorPlan, sure
from aeroscene.corpus.curation.indoor.galleries import guard_gallery, lay_upper_slabs
from aeroscene.corpus.curation.indoor.partitions import raise_walls
from aeroscene.corpus.curation.indoor.plans import START_M, open_place
from aeroscene.corpus.curation.indoor.room_placement import lay_room
from aeroscene.corpus.curation.indoor.walls import insets
from aeroscene.corpus.curation.indoor.zones import (
    Border,
    Side,
    Zone,
    barrier,
    choose_doors,
    find_borders,
)
from aeroscene.solids.shapes.facade import SLAB_TOP_M, WALL_M
from aeroscene.solids.shapes.shell import FINISH_M

ROOF_M = 0.25
PAD_RISE_M = 0.05
"""Height of the home pad."""


def raise_building(builder: Builder, draw: Draw, frame: Frame, plan: FloorPlan) -> Building:
    """Place a floor plan's shell, slabs, rooms, walls and rails.

    Args:
        builder: Builder of the scene.
        draw: Places of doors and stairs, choice of windows.
        frame: Middle and heading of the building.
        plan: Size, zones and finishes.

    Returns:
        The building, with one room for each zone.

    Raises:
        PlanError: If a room of the plan has no door.
        OverlapError: If the plan's zones overlap.
    """
    zones = plan.zones
    borders = find_borders(zones)
    doors = choose_doors(zones, borders)
    building = Building(plan, _raise_shell(builder, frame, plan))
    _lay_rooms(builder, building, insets(zones, borders))
    building.sides += [_walled_sides(index, borders, zones) for index in range(len(zones))]
    # Rails and stairs come last, at the end: they stand in rooms, and have to leave the air free
    # that walls keep before their doors.
    lay_upper_slabs(builder, building, borders)
    raise_walls(builder, draw, building.shell, zones, borders, doors)
    for border in borders:
        if barrier(zones, border) == "rail":
            guard_gallery(builder, draw, building, border)
    return building


def _raise_shell(builder: Builder, frame: Frame, plan: FloorPlan) -> Placed:
    x, y = plan.size
    storeys = len({zone.level for zone in plan.zones})
    look = {"is_enterable": True, "form": "closed", "storeys": storeys, "colour": plan.colour}
    shell = sure(builder.place(plan.name, frame, (x, y, plan.height), look=look))
    builder.place("roof", frame, (x, y, ROOF_M), parent=shell)
    slab = (x - 2 * WALL_M, y - 2 * WALL_M, SLAB_TOP_M)
    builder.place("floor", frame, slab, base=0.0, parent=shell, domain="indoor")
    return shell


def _lay_rooms(builder: Builder, building: Building, margins: Sequence[dict[Side, float]]) -> None:
    """A room for each zone; air stays free in the middle of wide zones and above the start."""
    shell = building.shell
    for zone, margin in zip(building.plan.zones, margins, strict=True):
        finish = building.plan.finishes.get(zone.kind, "floor_tiles")
        space = sure(lay_room(builder, shell, zone, margin, finish))
        building.spaces.append(space)
        if zone.open_m > 0:
            size = (zone.open_m, zone.open_m, zone.clear - 0.1)
            u, v = open_place(zone)
            spot = space.placed.frame.moved(u, v)
            builder.reserve(spot, size, zone.level + FINISH_M + 0.01)
    # A millimetre above the pad, which is placed later and must not touch the reserved air.
    hall = building.spaces[0]
    size = (START_M, START_M, hall.placed.size[2] - 0.1)
    builder.reserve(hall.placed.frame, size, hall.floor + PAD_RISE_M + 0.001)


def _walled_sides(index: int, borders: Sequence[Border], zones: Sequence[Zone]) -> tuple[str, ...]:
    """Sides of a zone, as furniture names them, along which a wall stands."""
    is_open = {
        border.side_of(index)
        for border in borders
        if index in border.zones
        and barrier(zones, border) != "wall"
        # Borders that begin above the floor belong to a gallery and leave this side walled.
        and border.base <= zones[index].level + 0.1
    }
    names: dict[Side, str] = {"x1": "front", "x0": "back", "y1": "left", "y0": "right"}
    return tuple(name for side, name in names.items() if side not in is_open)
