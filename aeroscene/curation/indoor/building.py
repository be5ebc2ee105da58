"""Raises a floor plan: shell, roof, slabs, rooms, walls with doors, rails and stairs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from aeroscene.curation.builder import Builder, Placed
from aeroscene.curation.draw import Draw
from aeroscene.curation.frame import QUARTER, Frame
from aeroscene.curation.indoor.plans import START_M, open_place
from aeroscene.curation.indoor.walls import PARTITION_M, insets, wall_spans
from aeroscene.curation.indoor.zones import (
    CELL_M,
    DOORS_M,
    Border,
    Side,
    Zone,
    barrier,
    choose_doors,
    find_borders,
)
from aeroscene.curation.shells import RoomSpace
from aeroscene.scene import AttributeValue
from aeroscene.shapes.facade import SLAB_M, SLAB_TOP_M, WALL_M
from aeroscene.shapes.shell import FINISH_M

ROOF_M = 0.25
PAD_RISE_M = 0.05
"""Height of the home pad."""
_BEARING_M = 0.1
"""How far an upper slab reaches into the outer walls."""
_APRON_M = 1.3
"""Air kept free before and behind a door."""
_HEADS_M = {DOORS_M[0]: 2.75, DOORS_M[1]: 2.25, DOORS_M[2]: 2.25}
"""Height of a door's head above the first cell border over the slab, by the door's width."""
_HATCH_M = (1.75, 0.75)
"""Width of an inner window and its sill above the first cell border over the slab."""
_RAIL_M = (0.1, 1.05)
"""Thickness and height of a gallery's railing."""
_STAIR_M = (5.5, 1.6)
"""Run and width of a flight of stairs."""
_GLAZED = frozenset(("meeting", "open_office", "cafe", "lounge", "library", "gym", "classroom"))
"""Kinds of rooms whose walls towards halls and corridors are of glass."""


@dataclass(frozen=True, kw_only=True)
class FloorPlan:
    """Everything that is decided before the first object is placed."""

    name: str
    """Category of the shell: building or warehouse."""
    size: tuple[float, float]
    """Outer lengths along x and y, multiples of half a metre."""
    height: float
    """Underside of the roof above the ground."""
    zones: tuple[Zone, ...]
    """The first is the hall in which a flight starts."""
    finishes: dict[str, str]
    """Floor finish of each kind of zone."""
    colour: str
    """Of the outer walls."""


@dataclass(slots=True)
class Building:
    """A building with a room for each zone of its plan."""

    plan: FloorPlan
    shell: Placed
    spaces: list[RoomSpace] = field(default_factory=list)
    """In the order of the plan's zones."""
    sides: list[tuple[str, ...]] = field(default_factory=list)
    """Of each room, the sides along which walls stand."""


def raise_building(builder: Builder, draw: Draw, frame: Frame, plan: FloorPlan) -> Building:
    """Place a floor plan's shell, slabs, rooms, walls and rails.

    Raises:
        PlanError: If a room of the plan has no door.
    """
    zones = plan.zones
    borders = find_borders(zones)
    widths = choose_doors(zones, borders)
    building = Building(plan, _raise_shell(builder, frame, plan))
    _lay_rooms(builder, building, insets(zones, borders))
    _lay_upper_slabs(builder, building, borders)
    building.sides += [_walled_sides(index, borders, zones) for index in range(len(zones))]
    spans = wall_spans(zones, borders)
    openings: list[tuple[Border, float, float, float]] = []
    for index, border in enumerate(borders):
        if index in spans:
            air = _raise_wall(builder, draw, building, border, spans[index], widths.get(index))
            openings += [(border, *air)] if air else []
    for border, at, width, low in openings:
        _keep_free(builder, building, border, at, width, low)
    for border in borders:
        if barrier(zones, border) == "rail":
            _guard_gallery(builder, draw, building, border)
    return building


def _raise_shell(builder: Builder, frame: Frame, plan: FloorPlan) -> Placed:
    x, y = plan.size
    storeys = len({zone.level for zone in plan.zones})
    attributes: dict[str, AttributeValue] = {
        "is_enterable": True,
        "form": "closed",
        "storeys": storeys,
        "colour": plan.colour,
    }
    shell = _sure(
        builder.place(plan.name, frame, 0, 0, (x, y, plan.height), base=0.0, attributes=attributes)
    )
    builder.place("roof", frame, 0, 0, (x, y, ROOF_M), base=shell.top, parent=shell)
    slab = (x - 2 * WALL_M, y - 2 * WALL_M, SLAB_TOP_M)
    builder.place("floor", frame, 0, 0, slab, base=0.0, parent=shell, domain="indoor")
    return shell


def _sure(placed: Placed | None) -> Placed:
    if placed is None:
        raise ValueError("a floor plan overlaps itself, valid: zones side by side inside the walls")
    return placed


def _lay_rooms(builder: Builder, building: Building, margins: Sequence[dict[Side, float]]) -> None:
    """A room for each zone; air stays free in the middle of wide ones and above the start."""
    shell = building.shell
    for zone, margin in zip(building.plan.zones, margins, strict=True):
        x0, x1 = zone.x0 + margin["x0"], zone.x1 - margin["x1"]
        y0, y1 = zone.y0 + margin["y0"], zone.y1 - margin["y1"]
        finish = building.plan.finishes.get(zone.kind, "floor_tiles")
        placed = _sure(
            builder.place(
                "room",
                shell.frame,
                (x0 + x1) / 2,
                (y0 + y1) / 2,
                (x1 - x0, y1 - y0, zone.clear),
                base=zone.level,
                parent=shell,
                domain="indoor",
                attributes={"finish": finish, "use": zone.kind},
            )
        )
        building.spaces.append(RoomSpace(placed))
        if zone.open_m > 0:
            size = (zone.open_m, zone.open_m, zone.clear - 0.1)
            u, v = open_place(zone)
            builder.reserve(placed.frame, u, v, size, placed.base + FINISH_M + 0.01)
    hall = building.spaces[0]
    size = (START_M, START_M, hall.placed.size[2] - 0.1)
    builder.reserve(hall.placed.frame, 0, 0, size, hall.floor + PAD_RISE_M + 0.001)


def _walled_sides(index: int, borders: Sequence[Border], zones: Sequence[Zone]) -> tuple[str, ...]:
    """Sides of a zone, as furniture names them, that are no open border."""
    is_open = {
        border.side_of(index)
        for border in borders
        if index in border.zones
        and barrier(zones, border) != "wall"
        and border.base <= zones[index].level + 0.1
    }
    names: dict[Side, str] = {"x1": "front", "x0": "back", "y1": "left", "y0": "right"}
    return tuple(name for side, name in names.items() if side not in is_open)


def _lay_upper_slabs(builder: Builder, building: Building, borders: Sequence[Border]) -> None:
    """A slab under each gallery: it ends over the walls under rails and against higher walls."""
    shell, zones = building.shell, building.plan.zones
    inner_x, inner_y = (length / 2 - WALL_M for length in building.plan.size)
    for index, zone in enumerate(zones):
        if zone.level <= SLAB_TOP_M:
            continue
        reach: dict[Side, float] = {
            "x0": _BEARING_M if zone.x0 <= -inner_x + 1e-6 else 0.0,
            "x1": _BEARING_M if zone.x1 >= inner_x - 1e-6 else 0.0,
            "y0": _BEARING_M if zone.y0 <= -inner_y + 1e-6 else 0.0,
            "y1": _BEARING_M if zone.y1 >= inner_y - 1e-6 else 0.0,
        }
        for border in borders:
            if index in border.zones and _is_edge(zones, border):
                is_rail = barrier(zones, border) == "rail"
                reach[border.side_of(index)] = PARTITION_M / 2 if is_rail else -PARTITION_M / 2
        x0, x1 = zone.x0 - reach["x0"], zone.x1 + reach["x1"]
        y0, y1 = zone.y0 - reach["y0"], zone.y1 + reach["y1"]
        _sure(
            builder.place(
                "floor",
                shell.frame,
                (x0 + x1) / 2,
                (y0 + y1) / 2,
                (x1 - x0, y1 - y0, SLAB_M),
                base=zone.level - SLAB_M,
                parent=shell,
                domain="indoor",
            )
        )


def _is_edge(zones: Sequence[Zone], border: Border) -> bool:
    """Whether a border runs along the edge of an upper floor, beside a zone as high as both."""
    return min(zones[i].level for i in border.zones) < border.base - 0.1


def _raise_wall(
    builder: Builder,
    draw: Draw,
    building: Building,
    border: Border,
    span: tuple[float, float],
    door_m: float | None,
) -> tuple[float, float, float] | None:
    """One wall between two zones with its door or an inner window: its middle, width and foot."""
    middle, length = (span[0] + span[1]) / 2, span[1] - span[0]
    if length < PARTITION_M:
        return None
    zones = [building.plan.zones[i] for i in border.zones]
    attributes: dict[str, AttributeValue] = {"colour": "white"}
    rooms = [zone for zone in zones if zone.role == "room"]
    if len(rooms) == 1 and rooms[0].kind in _GLAZED:
        attributes["form"] = "glass"
    # The wall's own y axis is the building's y, or minus its x.
    sign = 1.0 if border.along == "y" else -1.0
    # Beside the edge of an upper floor it stands on the wall below, not on the slab.
    base = border.base - SLAB_M if _is_edge(building.plan.zones, border) else border.base
    rise = _first_cell(border.base) - base
    air: tuple[float, float, float] | None = None
    if door_m is not None:
        at = _door_place(draw, border, door_m)
        attributes |= {
            "door_m": door_m,
            "door_offset_m": round(sign * (at - middle), 4),
            "door_height_m": round(rise + _HEADS_M[door_m], 4),
        }
        air = (at, door_m, border.base + 0.1)
    elif len(rooms) == 1 and border.length > 3.5 and draw.chance(0.5):
        at = _door_place(draw, border, _HATCH_M[0])
        attributes |= {
            "window_m": _HATCH_M[0],
            "window_offset_m": round(sign * (at - middle), 4),
            "window_sill_m": round(rise + _HATCH_M[1], 4),
            "window_height_m": round(rise + _HEADS_M[1.75], 4),
        }
        air = (at, _HATCH_M[0], base + rise + _HATCH_M[1])
    u, v = (border.at, middle) if border.along == "y" else (middle, border.at)
    _sure(
        builder.place(
            "wall",
            building.shell.frame,
            u,
            v,
            (PARTITION_M, length, border.top - base),
            base=base,
            turn=0.0 if border.along == "y" else QUARTER,
            parent=building.shell,
            domain="indoor",
            attributes=attributes,
        )
    )
    return air


def _first_cell(height: float) -> float:
    """The first border between cells at or above a height."""
    return -((-height) // CELL_M) * CELL_M


def _door_place(draw: Draw, border: Border, width: float) -> float:
    """Middle of an opening whose jambs lie on borders between cells."""
    reach = (border.length - width) / 2 - 0.45
    middle = (border.low + border.high) / 2 + draw.between(-0.7, 0.7) * max(0.0, reach)
    return _first_cell(middle - width / 2 - CELL_M / 2) + width / 2


def _keep_free(
    builder: Builder, building: Building, border: Border, at: float, width: float, low: float
) -> None:
    """Reserve the air before and behind an opening."""
    size = (2 * _APRON_M, width + 0.2) if border.along == "y" else (width + 0.2, 2 * _APRON_M)
    u, v = (border.at, at) if border.along == "y" else (at, border.at)
    height = _first_cell(border.base) + _HEADS_M[1.75] - low
    builder.reserve(building.shell.frame, u, v, (*size, height), low)


def _guard_gallery(builder: Builder, draw: Draw, building: Building, border: Border) -> None:
    """Rails along a gallery's edge, with a flight of stairs down where there is space for one."""
    zones = building.plan.zones
    upper, lower = sorted(border.zones, key=lambda i: -zones[i].level)
    gap = _climb(builder, draw, building, border, upper, lower)
    spans = [(border.low, border.high)]
    if gap is not None:
        half = _STAIR_M[1] / 2 + 0.1
        spans = [(border.low, gap - half), (gap + half, border.high)]
    inward = -1.0 if border.side_of(upper) in {"x1", "y1"} else 1.0
    line = border.at + inward * 0.1
    floor_space = building.spaces[upper]
    for low, high in spans:
        length, middle = high - low - 0.24, (low + high) / 2
        if length < 1.0:
            continue
        u, v = (line, middle) if border.along == "y" else (middle, line)
        builder.place(
            "fence",
            building.shell.frame,
            u,
            v,
            (_RAIL_M[0], length, _RAIL_M[1]),
            base=floor_space.floor,
            turn=0.0 if border.along == "y" else QUARTER,
            parent=floor_space.placed,
            attributes={"form": "rails"},
        )


def _climb(
    builder: Builder, draw: Draw, building: Building, border: Border, upper: int, lower: int
) -> float | None:
    """Stairs from the lower zone to the edge of the upper one; where along the edge, or None."""
    run, width = _STAIR_M
    floor_space = building.spaces[lower]
    rise = round(building.plan.zones[upper].level - floor_space.floor, 3)
    outward = 1.0 if border.side_of(upper) in {"x1", "y1"} else -1.0
    across = border.at + outward * (PARTITION_M / 2 + run / 2)
    reach = border.length / 2 - width / 2 - 0.4
    if reach <= 0:
        return None
    for _ in range(8):
        at = (border.low + border.high) / 2 + draw.between(-1.0, 1.0) * reach
        u, v = (across, at) if border.along == "y" else (at, across)
        turn = (0.0 if outward < 0 else 2 * QUARTER) if border.along == "y" else -outward * QUARTER
        placed = builder.place(
            "stairs",
            building.shell.frame,
            u,
            v,
            (run, width, rise),
            base=floor_space.floor,
            turn=turn,
            parent=floor_space.placed,
            within=floor_space.placed,
        )
        if placed:
            return at
    return None
