"""Buildings to fly into: shells with openings, and the slabs, walls and rooms inside them.

A shell has no roof and no floors of its own. They are objects of the scene, so that a building may
have any number of storeys and rooms, each of them a node of the hierarchy.
"""

from __future__ import annotations

from dataclasses import dataclass

from aeroscene.scene.box import MIN_SIZE_M
from aeroscene.solids.shapes.facade import (
    WALL_M,
    FacadePlan,
    count_bays,
    facade_parts,
    ribbon_parts,
    turned,
)
from aeroscene.solids.shapes.look import Look
from aeroscene.solids.shapes.materials import PAINT_COLOURS, WALL_COLOURS
from aeroscene.solids.shapes.primitive import Interval, Part, block, centred, centred_block

GATE_M = (5.0, 4.0)
"""Width and height of a warehouse's gates."""
FINISH_M = 0.02
"""Thickness of a room's floor finish; furniture stands on it."""
FINISHES = (
    "parquet",
    "floor_tiles",
    "carpet",
    "concrete",
    "paving",
    "red_paving",
    "pale_wood",
    "rubber",
)
"""Floors of rooms; a room that names none gets one of the first three."""
GLASS_TOP_M = 2.6
"""Upper end of the pane in a wall of glass."""


def shell(look: Look, wall: str) -> list[Part]:
    """Four walls of bays and storeys; the front (+x) has the door, the flanks have panes.

    The form "closed" has bands of windows instead, which nothing can fly through. Reads the
    attributes `form` and `storeys`.

    Args:
        look: Size and attributes of the building.
        wall: Name of the walls' material.
    """
    x, y, z = look.size_m
    if look.attributes.get("form") == "closed":
        return _closed_shell(look, wall)
    storeys = look.storeys(max(1, round(z / 3.2)))
    rise = z / storeys
    front = FacadePlan(y, storeys, rise, count_bays(y) // 2, "open")
    back = FacadePlan(y, storeys, rise, None, "open")
    # The flanks stand between front and back, which keep the corners.
    flank = FacadePlan(x - 2 * WALL_M, storeys, rise, None, "glass")
    parts = facade_parts(front, (x / 2 - WALL_M, x / 2), wall)
    parts += facade_parts(back, (-x / 2, -x / 2 + WALL_M), wall)
    parts += turned(facade_parts(flank, (y / 2 - WALL_M, y / 2), wall))
    parts += turned(facade_parts(flank, (-y / 2, -y / 2 + WALL_M), wall))
    return parts


def _closed_shell(look: Look, wall: str) -> list[Part]:
    """Four walls with a row of windows for each storey; a warehouse has them high up."""
    x, y, z = look.size_m
    storeys = look.storeys(1)
    if wall == "corrugated":
        rows = [(z - 2.0, z - 0.8)]
    else:
        rise = z / storeys
        rows = [(level * rise + 1.1, (level + 1) * rise - 0.6) for level in range(storeys)]
    parts: list[Part] = []
    for sign in (-1, 1):
        ends = sorted((sign * (x / 2 - WALL_M), sign * x / 2))
        sides = sorted((sign * (y / 2 - WALL_M), sign * y / 2))
        parts += ribbon_parts(y, z, rows, (ends[0], ends[1]), wall)
        parts += turned(ribbon_parts(x - 2 * WALL_M, z, rows, (sides[0], sides[1]), wall))
    return parts


def enterable_warehouse(look: Look) -> list[Part]:
    """A hall of sheet metal with a gate at each end, or closed with windows under the eaves.

    Reads the attributes `form` and `colour`.
    """
    x, y, z = look.size_m
    if look.attributes.get("form") == "closed":
        return _closed_shell(look, "corrugated")
    roof = block(x, y, (z - 0.3, z), "roofing")
    stripe = "paint_" + look.choice("colour", PAINT_COLOURS)
    # A small hall has a smaller gate, with wall beside it and above it.
    gate_y, gate_z = min(GATE_M[0], y - 2), min(GATE_M[1], z - 1.2)
    parts = [roof]
    for sign in (-1, 1):
        side = (sign * (y / 2 - WALL_M), sign * y / 2)
        parts.append(block(x, (min(side), max(side)), (0, z - 0.3), "corrugated"))
        end = (
            min(sign * (x / 2 - WALL_M), sign * x / 2),
            max(sign * (x / 2 - WALL_M), sign * x / 2),
        )
        inner = y / 2 - WALL_M
        parts.append(block(end, (-inner, -gate_y / 2), (0, z - 0.3), "corrugated"))
        parts.append(block(end, (gate_y / 2, inner), (0, z - 0.3), "corrugated"))
        parts.append(block(end, gate_y, (gate_z, z - 0.3), stripe))
    return parts


def floor(look: Look) -> list[Part]:
    """The slab of one storey: raw or polished concrete, or stone.

    Reads the attribute `finish`.
    """
    x, y, z = look.size_m
    material = look.choice("finish", ("concrete", "dark_concrete", "stone"))
    return [block(x, y, (0, z), material)]


def room(look: Look) -> list[Part]:
    """The space between walls: the floor's finish, and lights under its ceiling.

    Reads the attributes `finish` and `use` (a `court` has lines).
    """
    x, y, z = look.size_m
    # Finishes such as rubber are for rooms that ask for them.
    options = FINISHES if "finish" in look.attributes else FINISHES[:3]
    parts = [block(x, y, (0, FINISH_M), look.choice("finish", options))]
    if look.attributes.get("use") == "court":
        parts += _court_lines(x - 3.0, y - 3.0)
    return parts + _lights(x, y, z)


def _court_lines(x: float, y: float) -> list[Part]:
    """Lines around a playing field and across its middle."""
    paint, wide = (FINISH_M, FINISH_M + 0.004), 0.08
    spans = [
        ((-x / 2, -x / 2 + wide), centred(y)),
        ((x / 2 - wide, x / 2), centred(y)),
        (centred(x), (-y / 2, -y / 2 + wide)),
        (centred(x), (y / 2 - wide, y / 2)),
        (centred(wide), centred(y)) if x >= y else (centred(x), centred(wide)),
    ]
    return [block(*span, paint, "marking_white", collides=False) for span in spans]


def _lights(x: float, y: float, z: float) -> list[Part]:
    """Luminous panels in rows: one for each 7 m begun of the room's sides, at most 3 by 3."""
    columns, rows = (min(3, max(1, round(side / 7.0))) for side in (x, y))
    long, wide = (1.5, 0.5) if x >= y else (0.5, 1.5)
    return [
        centred_block(
            ((i + 0.5) * x / columns - x / 2, (j + 0.5) * y / rows - y / 2, z - 0.03),
            (min(long, 0.5 * x), min(wide, 0.5 * y), 0.04),
            "light_warm",
            collides=False,
        )
        for i in range(columns)
        for j in range(rows)
    ]


@dataclass(frozen=True, slots=True)
class _Opening:
    """A hole in a wall, in the wall's plane."""

    low: float
    high: float
    sill: float
    head: float


def wall(look: Look) -> list[Part]:
    """A wall along y, of plaster or glass, with at most one door and one window.

    Openings come from attributes in m: `door_m` wide at `door_offset_m` along y, `door_height_m`
    high; `window_m`, `window_offset_m`, `window_sill_m`, `window_height_m` (its head) likewise.
    `form` is `glass` for a glass wall, and `colour` that of plaster. The remainder of the wall is
    built however narrow it is, down to the least size of a box.
    """
    x, y, z = look.size_m
    material = "plaster_" + look.choice("colour", WALL_COLOURS)
    openings = _openings(look)
    edges = [-y / 2, *(edge for hole in openings for edge in (hole.low, hole.high)), y / 2]
    is_glass = look.attributes.get("form") == "glass"
    parts: list[Part] = []
    for low, high in zip(edges[::2], edges[1::2], strict=True):
        parts += _glazing((low, high), x, z, material) if is_glass else []
        parts += [] if is_glass else [block(x, (low, high), (0, z), material)]
    for hole in openings:
        span = (hole.low, hole.high)
        parts.append(block(x, span, (0, hole.sill), material))
        parts.append(block(x, span, (hole.head, z), material))
        parts += _frame(hole, x)
    return [part for part in parts if min(part.size_m) >= MIN_SIZE_M]


def _openings(look: Look) -> list[_Opening]:
    """Door and window, from low to high along y; openings that do not fit are left out."""
    _, y, z = look.size_m
    found: list[_Opening] = []
    for name, default_head in (("door", 2.4), ("window", 2.2)):
        width = look.number(f"{name}_m", 0.0)
        middle = look.number(f"{name}_offset_m", 0.0)
        sill = look.number("window_sill_m", 0.9) if name == "window" else 0.0
        head = min(z, look.number(f"{name}_height_m", default_head))
        hole = _Opening(middle - width / 2, middle + width / 2, sill, head)
        # The door comes first, so a window that overlaps it is left out, not the door.
        is_apart = all(hole.low > other.high or hole.high < other.low for other in found)
        if width > 0 and hole.low > -y / 2 and hole.high < y / 2 and is_apart and head > sill:
            found.append(hole)
    return sorted(found, key=lambda hole: hole.low)


def _glazing(span: Interval, thick: float, z: float, material: str) -> list[Part]:
    """A pane between a plinth and a band, with a post at each end."""
    top = min(z, GLASS_TOP_M)
    posts = [(span[0], span[0] + 0.06), (span[1] - 0.06, span[1])]
    return [
        block(0.04, span, (0.1, top), "glass"),
        block(thick, span, (0.0, 0.1), "dark_metal"),
        block(thick, span, (top, z), material),
        # Posts overlap the pane, hence they touch nothing.
        *(block(0.08, post, (0.1, top), "dark_metal", collides=False) for post in posts),
    ]


def _frame(hole: _Opening, thick: float) -> list[Part]:
    """A dark lining around an opening, drawn on the wall."""
    skin = centred(thick + 0.02)
    jambs = ((hole.low - 0.05, hole.low), (hole.high, hole.high + 0.05))
    return [
        *(block(skin, jamb, (hole.sill, hole.head), "dark_wood", collides=False) for jamb in jambs),
        block(
            skin,
            (hole.low - 0.05, hole.high + 0.05),
            (hole.head, hole.head + 0.05),
            "dark_wood",
            collides=False,
        ),
    ]
