"""Buildings: solid masses with painted windows, and shells that a drone can fly into."""

from __future__ import annotations

from aeroscene.shapes.facade import FacadePlan, count_bays, facade_parts, turned, window_panels
from aeroscene.shapes.look import Look
from aeroscene.shapes.materials import PAINT_COLOURS, WALL_COLOURS
from aeroscene.shapes.primitive import Part, block, centred, centred_block, hull

WALL_M = 0.25
GATE_M = (5.0, 4.0)
"""Width and height of a warehouse's gates."""
PARAPET_M = 0.2
ROOF_SLAB_M = 0.25


def building(look: Look) -> list[Part]:
    """An upright block: enterable shell or solid mass."""
    colour = look.choice("colour", (*WALL_COLOURS, "brick"))
    if look.flag("is_enterable"):
        return _shell(look, "brick" if colour == "brick" else f"plaster_{colour}")
    return _mass(look, colour)


def _mass(look: Look, colour: str) -> list[Part]:
    x, y, z = look.size_m
    wall = "brick" if colour == "brick" else f"plaster_{colour}"
    facade = "facade_rose" if colour == "brick" else f"facade_{colour}"
    core = block(centred(x - 0.08), centred(y - 0.08), (0.0, z), wall)
    door_y = 0.0 if look.variant % 2 else -y / 4
    door = centred_block(
        (x / 2 - 0.01, door_y, 1.15), (0.02, 1.4, 2.3), "dark_wood", collides=False
    )
    return [core, *window_panels(x, y, z, facade), door]


def _shell(look: Look, wall: str) -> list[Part]:
    """Four walls of bays and storeys; the front (+x) has the door, the flanks have panes."""
    x, y, z = look.size_m
    storeys = max(1, round(look.number("storeys", max(1, round(z / 3.2)))))
    rise = z / storeys
    front = FacadePlan(y, storeys, rise, count_bays(y) // 2, "open")
    back = FacadePlan(y, storeys, rise, None, "open")
    flank = FacadePlan(x - 2 * WALL_M, storeys, rise, None, "glass")
    parts = facade_parts(front, (x / 2 - WALL_M, x / 2), wall)
    parts += facade_parts(back, (-x / 2, -x / 2 + WALL_M), wall)
    parts += turned(facade_parts(flank, (y / 2 - WALL_M, y / 2), wall))
    parts += turned(facade_parts(flank, (-y / 2, -y / 2 + WALL_M), wall))
    return parts


def tower(look: Look) -> list[Part]:
    """A tall slim block with a set-back crown."""
    x, y, z = look.size_m
    colour = look.choice("colour", WALL_COLOURS)
    shaft = z - 1.5
    parts = [block(centred(x - 0.08), centred(y - 0.08), (0.0, shaft), f"plaster_{colour}")]
    parts += window_panels(x, y, shaft, f"facade_{colour}")
    parts.append(block(centred(0.6 * x), centred(0.6 * y), (shaft, z), "dark_concrete"))
    parts.append(
        centred_block((x / 2 - 0.01, 0, 1.3), (0.02, 2.4, 2.6), "dark_glass", collides=False)
    )
    return parts


def warehouse(look: Look) -> list[Part]:
    """A hall of sheet metal; enterable through a gate at each end."""
    x, y, z = look.size_m
    roof = block(centred(x), centred(y), (z - 0.3, z), "roofing")
    stripe = "paint_" + look.choice("colour", PAINT_COLOURS)
    if not look.flag("is_enterable"):
        core = block(centred(x - 0.04), centred(y - 0.04), (0, z - 0.3), "corrugated")
        gate = centred_block((x / 2 - 0.01, 0, 2.0), (0.02, 4.0, 4.0), "dark_metal", collides=False)
        return [core, roof, gate]
    gate_y, gate_z = min(GATE_M[0], y - 2), min(GATE_M[1], z - 1.2)
    parts = [roof]
    for sign in (-1, 1):
        side = (sign * (y / 2 - WALL_M), sign * y / 2)
        parts.append(block(centred(x), (min(side), max(side)), (0, z - 0.3), "corrugated"))
        end = (
            min(sign * (x / 2 - WALL_M), sign * x / 2),
            max(sign * (x / 2 - WALL_M), sign * x / 2),
        )
        inner = y / 2 - WALL_M
        parts.append(block(end, (-inner, -gate_y / 2), (0, z - 0.3), "corrugated"))
        parts.append(block(end, (gate_y / 2, inner), (0, z - 0.3), "corrugated"))
        parts.append(block(end, centred(gate_y), (gate_z, z - 0.3), stripe))
    return parts


def garage(look: Look) -> list[Part]:
    """A flat-roofed box with a roller door, or a shed of boards."""
    if look.choice("form", ("garage", "shed")) == "shed":
        return _shed(look)
    x, y, z = look.size_m
    core = block((-x / 2, x / 2 - 0.03), centred(y), (0, z - 0.2), "plaster_white")
    roof = block(centred(x), centred(y), (z - 0.2, z), "roofing")
    door = block((x / 2 - 0.03, x / 2), centred(0.75 * y), (0, 0.8 * z), "metal", collides=False)
    return [core, roof, door]


def _shed(look: Look) -> list[Part]:
    """Board walls under a flat felt roof."""
    x, y, z = look.size_m
    core = block(centred(x - 0.2), centred(y - 0.2), (0, z - 0.12), "wood")
    roof = block(centred(x), centred(y), (z - 0.12, z), "roofing")
    door = block(
        (x / 2 - 0.1, x / 2 - 0.07),
        centred(0.9),
        (0, min(1.9, z - 0.2)),
        "dark_wood",
        collides=False,
    )
    return [core, roof, door]


def kiosk(look: Look) -> list[Part]:
    """A stall with a counter hatch under a projecting roof."""
    x, y, z = look.size_m
    paint = "paint_" + look.choice("colour", PAINT_COLOURS)
    body = (-x / 2 + 0.1, x / 2 - 0.6)
    return [
        block(body, centred(y - 0.3), (0, z - 0.2), paint),
        block(centred(x), centred(y), (z - 0.2, z), "plastic_white"),
        block((body[1], body[1] + 0.35), centred(y - 0.6), (0.95, 1.05), "wood"),
        block(
            (body[1], body[1] + 0.02), centred(y - 0.6), (1.05, 2.0), "dark_glass", collides=False
        ),
    ]


def container(look: Look) -> list[Part]:
    """A shipping container with its doors at the front."""
    x, y, z = look.size_m
    paint = "paint_" + look.choice("colour", PAINT_COLOURS)
    parts = [block((-x / 2, x / 2 - 0.03), centred(y), (0, z), paint)]
    for side in (-1, 1):
        leaf = (0.04, y / 2 - 0.04) if side > 0 else (-y / 2 + 0.04, -0.04)
        parts.append(block((x / 2 - 0.03, x / 2), leaf, (0.08, z - 0.08), paint, collides=False))
        bar = side * y / 4
        parts.append(
            block(
                (x / 2 - 0.03, x / 2),
                (bar - 0.03, bar + 0.03),
                (0.1, z - 0.1),
                "metal",
                collides=False,
            )
        )
    return parts


def roof(look: Look) -> list[Part]:
    """A flat roof with a parapet, a gable or a hip, on top of a building."""
    x, y, z = look.size_m
    form = look.choice("form", ("flat", "gable", "hip")) if z > 1.2 else "flat"
    if form == "flat":
        return _flat_roof(x, y, z)
    tiles = look.choice("tiles", ("roof_red", "roof_slate"))
    ridge = x / 2 if form == "gable" else x / 2 - min(x, y) * 0.35
    eaves = 0.15
    vertices = [
        (sx * x / 2, sy * y / 2, h) for sx in (-1, 1) for sy in (-1, 1) for h in (0.0, eaves)
    ]
    vertices += [(-ridge, 0.0, z), (ridge, 0.0, z)]
    return [hull(vertices, tiles)]


def _flat_roof(x: float, y: float, z: float) -> list[Part]:
    slab = min(ROOF_SLAB_M, z)
    parts = [block(centred(x), centred(y), (0, slab), "roofing")]
    if z > slab + 0.05:
        inner = y - 2 * PARAPET_M
        for sign in (-1, 1):
            ends = sorted((sign * (x / 2 - PARAPET_M), sign * x / 2))
            sides = sorted((sign * (y / 2 - PARAPET_M), sign * y / 2))
            parts.append(block((ends[0], ends[1]), centred(inner), (slab, z), "concrete"))
            parts.append(block(centred(x), (sides[0], sides[1]), (slab, z), "concrete"))
    return parts


def floor(look: Look) -> list[Part]:
    """The slab of one storey."""
    x, y, z = look.size_m
    return [block(centred(x), centred(y), (0, z), "concrete")]


FINISH_M = 0.02
"""Thickness of a room's floor finish; furniture stands on it."""


def room(look: Look) -> list[Part]:
    """A room is the space between walls; what is solid of it is the floor's finish."""
    x, y, _ = look.size_m
    finish = look.choice("finish", ("parquet", "floor_tiles", "carpet"))
    return [block(centred(x), centred(y), (0, FINISH_M), finish)]


def wall(look: Look) -> list[Part]:
    """A partition or free-standing wall along y; `door_m` wide open at `door_offset_m`."""
    x, y, z = look.size_m
    material = "plaster_" + look.choice("colour", WALL_COLOURS)
    door = look.number("door_m", 0.0)
    if door <= 0 or door >= y:
        return [block(centred(x), centred(y), (0, z), material)]
    middle = look.number("door_offset_m", 0.0)
    low, high = max(-y / 2, middle - door / 2), min(y / 2, middle + door / 2)
    head = min(z, look.number("door_height_m", 2.4))
    pieces = [((-y / 2, low), (0, z)), ((high, y / 2), (0, z)), ((low, high), (head, z))]
    return [
        block(centred(x), span, rise, material)
        for span, rise in pieces
        if span[1] - span[0] > 0.01 and rise[1] - rise[0] > 0.01
    ]
