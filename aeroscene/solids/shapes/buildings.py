"""Solid buildings; the front is +x. Buildings that a drone can fly into are in `shell`.

A mass keeps its full outline at its upper edge, because the roof lies there. Below that, walls may
stand back: the rest of the depth becomes ledges and balconies, deep enough for a drone to perch on.
"""

from __future__ import annotations

from math import radians, tan

from aeroscene.solids.shapes.facade import window_panels
from aeroscene.solids.shapes.forms import FORMS
from aeroscene.solids.shapes.look import Look
from aeroscene.solids.shapes.materials import FACADE_BAY_M, PAINT_COLOURS, WALL_COLOURS
from aeroscene.solids.shapes.primitive import Interval, Part, block, centred, cylinder
from aeroscene.solids.shapes.shell import enterable_warehouse, shell
from aeroscene.solids.shapes.solids import about, inwards, paint, prism, shifted

_STOREY_M = FACADE_BAY_M[1]
_LEDGE_M = 0.9
"""Depth of ledges; a Hummingbird's rotors extend to 0.4 m."""
_BALCONY_M = 1.3
# Bounds the parts: balconies at most, and storeys from which every other one has a ledge.
_MOST_BALCONIES = 5
_ATTIC_M = 0.45
_TWO_STOREYS_M = 5.8
_WAREHOUSE_PITCH_RAD = radians(7.0)


def building(look: Look) -> list[Part]:
    """An upright block: a shell to enter, or a mass: plain, with balconies, ledges or an arcade.

    Reads the attributes `colour`, `is_enterable` and `form`.
    """
    colour = look.choice("colour", (*WALL_COLOURS, "brick"))
    if look.flag("is_enterable"):
        return shell(look, _wall(colour))
    x, y, z = look.size_m
    # Ledges and balconies need two storeys, and a mass behind them that still looks like a
    # building.
    is_tall = z > _TWO_STOREYS_M and min(x, y) > 5.0
    form = look.choice("form", FORMS["building"] if is_tall else ("plain",))
    if form == "balconies" and is_tall:
        return _balconies(look, colour)
    if form == "ledges" and is_tall:
        return _ledges(look, colour)
    if form == "podium" and is_tall:
        return _podium(look, colour)
    return _plain(look, colour)


def _wall(colour: str) -> str:
    return "brick" if colour == "brick" else f"plaster_{colour}"


def _mass(x: Interval, y: Interval, z: Interval, colour: str) -> list[Part]:
    """A block with painted windows on its four sides."""
    core = block(x, y, z, _wall(colour))
    # The panels stand 4 cm before the wall on each side, so that faces do not flicker in pictures.
    length, width = x[1] - x[0] + 0.08, y[1] - y[0] + 0.08
    panels = window_panels(length, width, z[1] - z[0], f"facade_{colour}")
    middle = ((x[0] + x[1]) / 2, (y[0] + y[1]) / 2)
    return [core, *(shifted(panel, *middle, z[0]) for panel in panels)]


def _door(front: float, at_y: float, z: float, wide: float = 1.4) -> Part:
    return paint(
        (front - 0.02, front + 0.02), about(at_y, wide), (0, min(2.3, 0.8 * z)), "dark_wood"
    )


def _plain(look: Look, colour: str) -> list[Part]:
    """One mass with a projecting attic and a porch roof over the door."""
    x, y, z = look.size_m
    # The door is in the middle or to one side, by the object's number.
    front, door_y = x / 2 - 0.12, 0.0 if look.variant % 2 else -y / 4
    attic = min(_ATTIC_M, 0.1 * z)
    parts = _mass(centred(x - 0.24), centred(y - 0.24), (0, z - attic), colour)
    parts.append(block(x, y, (z - attic, z), "concrete"))
    return [*parts, _door(front, door_y, z)]


def _balconies(look: Look, colour: str) -> list[Part]:
    """Slabs with panes of glass along the front, one for each storey."""
    x, y, z = look.size_m
    front = x / 2 - _BALCONY_M
    parts = _mass((-x / 2 + 0.05, front), centred(y - 0.1), (0, z - _ATTIC_M), colour)
    parts.append(block(x, y, (z - _ATTIC_M, z), "concrete"))
    # The lowest balcony is on the first floor, and its door needs 2.2 m below the attic.
    storeys = min(_MOST_BALCONIES, int((z - _ATTIC_M - 2.2) // _STOREY_M))
    wide = centred(0.7 * y)
    for storey in range(1, storeys + 1):
        low = storey * _STOREY_M
        parts.append(block((front, x / 2), wide, (low - 0.16, low), "concrete"))
        parts.append(block(inwards(1, x / 2, 0.06), wide, (low, low + 0.9), "glass"))
    return [*parts, _door(front, 0.0, z, 2.0)]


def _ledges(look: Look, colour: str) -> list[Part]:
    """Bands of concrete around every or every other storey."""
    x, y, z = look.size_m
    parts = _mass(centred(x - 2 * _LEDGE_M), centred(y - 2 * _LEDGE_M), (0, z - _ATTIC_M), colour)
    parts.append(block(x, y, (z - _ATTIC_M, z), "concrete"))
    storeys = max(1, int((z - 2.0) // _STOREY_M))
    step = 1 if storeys <= _MOST_BALCONIES else 2
    parts += [
        block(x, y, (i * _STOREY_M - 0.14, i * _STOREY_M + 0.06), "concrete")
        for i in range(1, storeys + 1, step)
    ]
    return [*parts, _door(x / 2 - _LEDGE_M, 0.0, z, 2.0)]


def _podium(look: Look, colour: str) -> list[Part]:
    """Shops behind an arcade of columns; the storeys above reach out over it."""
    x, y, z = look.size_m
    low, front = 3.6, x / 2 - 2.2
    parts = _mass(centred(x - 0.1), centred(y - 0.1), (low, z), colour)
    parts.append(block((-x / 2 + 0.05, front), y - 0.1, (0, low), "stone"))
    parts.append(paint((front, front + 0.03), 0.86 * y, (0.25, 2.9), "dark_glass"))
    awning = "paint_" + look.choice("awning", PAINT_COLOURS)
    parts.append(block((front, front + 0.7), 0.86 * y, (3.0, 3.25), awning))
    count = max(2, min(5, round(y / 4)))
    parts += [
        cylinder((x / 2 - 0.3, (i / (count - 1) - 0.5) * (y - 0.6), low / 2), 0.36, low, "concrete")
        for i in range(count)
    ]
    return parts


def house(look: Look) -> list[Part]:
    """A dwelling: plain with a plinth, with a veranda, or with a bay window.

    Reads the attributes `colour`, `is_enterable` and `form`.
    """
    if look.flag("is_enterable"):
        return building(look)
    x, y, z = look.size_m
    colour = look.choice("colour", (*WALL_COLOURS, "brick"))
    form = look.choice("form", FORMS["house"])
    # Fittings of the ground floor keep to it in a higher house.
    top = min(z, 2.7)
    if form == "plain":
        front = x / 2 - 0.1
        parts = _mass(centred(x - 0.2), centred(y - 0.2), (0, z), colour)
        porch = block((front, x / 2), about(0.2 * y, 1.6), (0.9 * top, 0.96 * top), "dark_wood")
        plinth = block(x, y, (0, min(0.35, 0.1 * z)), "stone")
        return [*parts, plinth, porch, _door(front, 0.2 * y, z)]
    if form == "bay":
        front = x / 2 - 0.8
        parts = _mass((-x / 2 + 0.05, front), centred(y - 0.1), (0, z), colour)
        bay = about(-0.22 * y, min(2.6, 0.36 * y))
        pane = about(-0.22 * y, min(2.6, 0.36 * y) - 0.3)
        parts += [
            block((front, x / 2 - 0.03), bay, (0, top), _wall(colour)),
            paint((x / 2 - 0.03, x / 2), pane, (0.32 * top, 0.84 * top), "dark_glass"),
            block((front, x / 2), about(0.22 * y, 1.6), (0.92 * top, top), "dark_wood"),
        ]
        return [*parts, _door(front, 0.22 * y, z, 1.1)]
    # What is left is the veranda.
    front = x / 2 - 1.8
    parts = _mass((-x / 2 + 0.05, front), centred(y - 0.1), (0, z), colour)
    floor, roof = 0.16, (top - 0.14, top)
    parts += [
        block((front, x / 2), y, (0, floor), "wood"),
        block((front, x / 2), y, roof, "dark_wood"),
        *(
            block(
                inwards(1, x / 2 - 0.06, 0.14),
                about(at * y, 0.14),
                (floor, roof[0]),
                "timber_white",
            )
            for at in (-0.46, -0.16, 0.16, 0.46)
        ),
    ]
    return [*parts, _door(front, 0.0, z, 1.1)]


def tower(look: Look) -> list[Part]:
    """A tall slim block with a set-back crown, stepped in three tiers, or with ribs.

    Reads the attributes `form` and `colour`.
    """
    x, y, z = look.size_m
    form = look.choice("form", FORMS["tower"])
    colour = look.choice("colour", WALL_COLOURS)
    if form == "stepped":
        parts: list[Part] = []
        low = 0.0
        # Each tier: share of the outline, and share of the height up to which it reaches.
        for share, high in ((1.0, 0.5), (0.78, 0.8), (0.5, 1.0)):
            along, across = share * x - 0.08, share * y - 0.08
            parts += _mass(centred(along), centred(across), (low, high * z), colour)
            low = high * z
        return [*parts, _lobby(x / 2 - 0.04)]
    shaft = z - 1.5
    inset = 0.08 if form == "crown" else 0.6
    parts = _mass(centred(x - inset), centred(y - inset), (0, shaft), colour)
    parts.append(block(0.6 * x, 0.6 * y, (shaft, z), "dark_concrete"))
    if form == "ribs":
        rise = (0.0, shaft + 0.5)
        parts += [
            *(block(x, inwards(s, y / 2 - 0.1, 0.4), rise, "concrete") for s in (-1, 1)),
            *(block(about(at * x, 0.4), y, rise, "concrete") for at in (-0.16, 0.16)),
        ]
    return [*parts, _lobby((x - inset) / 2)]


def _lobby(front: float) -> Part:
    return paint((front - 0.02, front + 0.02), 2.4, (0, 2.7), "dark_glass")


def warehouse(look: Look) -> list[Part]:
    """A hall of sheet metal with a gate; with loading docks, or with a low pitched roof.

    Reads the attributes `form`, `cladding`, `colour` and `is_enterable`. The number of the object
    never draws the low pitch, only the attribute chooses it.
    """
    if look.flag("is_enterable"):
        return enterable_warehouse(look)
    x, y, z = look.size_m
    form, skin = look.choice("form", FORMS["warehouse"], ("hall", "docks")), _cladding(look)
    stripe = "paint_" + look.choice("colour", PAINT_COLOURS)
    gate = min(4.0, 0.7 * z)
    if form == "lowpitch":
        return [*_low_pitch(look, skin), _gate(x / 2 - 0.02, 0.0, 4.0, gate)]
    roof = block(x, y, (z - 0.3, z), "roofing")
    lights = [
        paint(about(at * x, 0.06 * x), 0.7 * y, (z, z + 0.015), "glass") for at in (-0.3, 0.0, 0.3)
    ]
    band = paint(x - 0.02, y - 0.02, (z - 1.0, z - 0.6), stripe)
    if form == "hall":
        core = block(x - 0.04, y - 0.04, (0, z - 0.3), skin)
        return [core, roof, band, *lights, _gate(x / 2 - 0.02, 0.0, 4.0, gate)]
    front = x / 2 - 1.6
    core = block((-x / 2 + 0.02, front), y - 0.04, (0, z - 0.3), skin)
    count = max(2, min(4, int(y // 5)))
    doors = [(i - (count - 1) / 2) * y / count for i in range(count)]
    return [
        core,
        roof,
        block((front, x / 2), 0.92 * y, (0, min(1.1, 0.25 * z)), "concrete"),
        *(
            paint((front, front + 0.03), about(at, 2.8), (min(1.1, 0.25 * z), gate), stripe)
            for at in doors
        ),
        *lights,
    ]


def _cladding(look: Look) -> str:
    return look.choice(
        "cladding", ("corrugated", "cladding_grey", "cladding_white", "cladding_blue")
    )


def _gate(front: float, at_y: float, wide: float, high: float) -> Part:
    return paint((front - 0.02, front + 0.02), about(at_y, wide), (0, high), "dark_metal")


def _low_pitch(look: Look, skin: str) -> list[Part]:
    """Walls and a roof of two planes, gentle enough to land on, ridge along y."""
    x, y, z = look.size_m
    rise = min(x / 2 * tan(_WAREHOUSE_PITCH_RAD), 0.3 * z)
    eaves = z - rise - 0.2
    body = block(x - 0.04, y - 0.04, (0, eaves), skin)
    planes = [
        (-x / 2, eaves),
        (x / 2, eaves),
        (x / 2, eaves + 0.2),
        (0.0, z),
        (-x / 2, eaves + 0.2),
    ]
    return [body, prism(planes, y, "corrugated")]
