"""Small buildings and boxes: garages, sheds, kiosks and shipping containers; the front is +x."""

from __future__ import annotations

from math import radians, tan

from aeroscene.solids.shapes.forms import FORMS
from aeroscene.solids.shapes.look import Look
from aeroscene.solids.shapes.materials import PAINT_COLOURS
from aeroscene.solids.shapes.primitive import Part, block, cylinder
from aeroscene.solids.shapes.solids import about, disc, inwards, legs, paint, prism

_ROOF_M = 0.18
_PITCH_RAD = radians(6.0)


def garage(look: Look) -> list[Part]:
    """A garage with a roller door, a shed of boards, or a carport to park and fly under.

    Reads the attributes `form`, `wall` and `door`.
    """
    x, y, z = look.size_m
    form = look.choice("form", FORMS["garage"])
    roof = block(x, y, (z - _ROOF_M, z), "roofing")
    if form == "carport":
        screen = block(inwards(-1, x / 2 - 0.06, 0.06), y - 0.3, (0.1, z - _ROOF_M), "wood")
        return [roof, screen, *legs(x - 0.1, y - 0.1, (0, z - _ROOF_M), 0.12, "dark_wood")]
    if form == "shed":
        return _shed(look)
    wall = look.choice("wall", ("plaster_white", "plaster_cream", "brick"))
    leaf = look.choice("door", ("metal", "paint_white", "timber"))
    core = block((-x / 2, x / 2 - 0.05), y - 0.1, (0, z - _ROOF_M), wall)
    count = 2 if y > 5 else 1
    doors = [
        paint(
            inwards(1, x / 2 - 0.01, 0.05),
            about((i - (count - 1) / 2) * y / 2, 0.78 * y / count),
            (0, 0.8 * z),
            leaf,
        )
        for i in range(count)
    ]
    return [core, roof, *doors]


def _shed(look: Look) -> list[Part]:
    """Board walls under a felt roof that falls gently to the back."""
    x, y, z = look.size_m
    boards = look.choice("wall", ("timber", "timber_red", "timber_white"))
    fall = min(x * tan(_PITCH_RAD), 0.2 * z)
    thick = 0.12
    body = [
        (0.1 - x / 2, 0.0),
        (x / 2 - 0.1, 0.0),
        (x / 2 - 0.1, z - thick),
        (0.1 - x / 2, z - fall - thick),
    ]
    top = [(-x / 2, z - fall), (x / 2, z), (x / 2, z - thick), (-x / 2, z - fall - thick)]
    high = min(1.95, z - 0.4)
    front = inwards(1, x / 2 - 0.07, 0.05)
    parts = [prism(body, y - 0.2, boards), prism(top, y, "roofing")]
    parts.append(paint(front, about(-0.15 * y, min(0.9, 0.4 * y)), (0, high), "dark_wood"))
    if y > 2:
        parts.append(
            paint(front, about(0.25 * y, 0.22 * y), (0.5 * high, 0.85 * high), "dark_glass")
        )
    return parts


def kiosk(look: Look) -> list[Part]:
    """A stall with a hatch under a projecting roof, a round pavilion, or a market stall.

    Reads the attributes `form` and `colour`.
    """
    x, y, z = look.size_m
    form = look.choice("form", FORMS["kiosk"])
    colour = "paint_" + look.choice("colour", PAINT_COLOURS)
    sill, lintel = 0.36 * z, 0.72 * z
    if form == "round":
        wide = min(x, y)
        return [
            cylinder((0, 0, (z - 0.3) / 2), 0.84 * wide, z - 0.3, colour),
            disc((0, 0, (sill + lintel) / 2), 0.86 * wide, lintel - sill, "dark_glass"),
            cylinder((0, 0, sill), 0.94 * wide, 0.08, "wood"),
            cylinder((0, 0, z - 0.15), wide, 0.3, "plastic_white"),
        ]
    if form == "stall":
        return _stall(look, colour)
    body = (-x / 2 + 0.1, x / 2 - 0.6)
    return [
        block(body, y - 0.3, (0, z - 0.2), colour),
        block(x, y, (z - 0.2, z), "plastic_white"),
        block((body[1], body[1] + 0.35), y - 0.6, about(sill, 0.08), "wood"),
        paint((body[1], body[1] + 0.02), y - 0.6, (sill + 0.04, lintel), "dark_glass"),
        paint((x / 2, x / 2 + 0.01), 0.9 * y, (z - 0.18, z - 0.02), colour),
    ]


def _stall(look: Look, colour: str) -> list[Part]:
    """A counter and shelves under a striped cloth that falls gently to the front."""
    x, y, z = look.size_m
    fall = min(x * tan(_PITCH_RAD), 0.15 * z)
    cloth = [(-x / 2, z), (x / 2, z - fall), (x / 2, z - fall - 0.08), (-x / 2, z - 0.08)]
    # Stripes are a little thicker than the cloth, so that they lie above it.
    stripe = [(px, pz + 0.012) if pz > z - fall - 0.05 else (px, pz) for px, pz in cloth]
    stripes = [prism(stripe, about(at * y, 0.16 * y), colour) for at in (-0.34, 0.0, 0.34)]
    return [
        prism(cloth, y, "plastic_white"),
        *stripes,
        block((0.05 * x, x / 2 - 0.1), y - 0.2, (0, 0.34 * z), "wood"),
        *legs(x - 0.1, y - 0.1, (0, z - fall - 0.08), 0.08, "metal"),
        block(inwards(-1, x / 2 - 0.02, 0.04), y - 0.2, (0, 0.7 * z), colour),
    ]


def container(look: Look) -> list[Part]:
    """A shipping container, closed or open at its front, or one that is a site office.

    Reads the attributes `form` and `colour`.
    """
    x, y, z = look.size_m
    form = look.choice("form", FORMS["container"])
    colour = "paint_" + look.choice("colour", PAINT_COLOURS)
    front, ends = inwards(1, x / 2, 0.03), (-x / 2, x / 2 - 0.03)
    if form == "open":
        skin = 0.08
        # No wall at +x: a small drone can fly in.
        return [
            block(x, y, (z - skin, z), colour),
            block(x, y, (0, 0.12), "dark_wood"),
            block(inwards(-1, x / 2, skin), y, (0.12, z - skin), colour),
            *(block(x, inwards(s, y / 2, skin), (0.12, z - skin), colour) for s in (-1, 1)),
        ]
    if form == "office":
        band = (0.36 * z, 0.76 * z)
        door = paint((x / 2 - 0.03, x / 2 + 0.005), 0.9, (0.08, 0.82 * z), "plastic_white")
        windows = [
            paint(about(at * x, 0.2 * x), y + 0.01, band, "dark_glass") for at in (-0.24, 0.24)
        ]
        return [block(ends, y, (0, z), colour), door, *windows]
    leaves = [(0.04, y / 2 - 0.04), (-y / 2 + 0.04, -0.04)]
    return [
        block(ends, y, (0, z), colour),
        *(paint(front, leaf, (0.08, z - 0.08), colour) for leaf in leaves),
        *(
            paint((front[0], x / 2 + 0.01), about(s * y / 4, 0.06), (0.1, z - 0.1), "metal")
            for s in (-1, 1)
        ),
        paint(0.3 * x, y + 0.01, (0.36 * z, 0.64 * z), "plastic_white"),
    ]
