"""Furniture; the front, where a person sits or stands, is +x."""

from __future__ import annotations

from aeroscene.shapes.look import Look
from aeroscene.shapes.materials import FABRIC_COLOURS
from aeroscene.shapes.primitive import Part, block, centred, cylinder

WOODS = ("wood", "pale_wood", "dark_wood")


def _legs(x: float, y: float, height: float, thick: float, material: str) -> list[Part]:
    parts: list[Part] = []
    for sx in (-1, 1):
        for sy in (-1, 1):
            ends = sorted((sx * x / 2, sx * (x / 2 - thick)))
            sides = sorted((sy * y / 2, sy * (y / 2 - thick)))
            parts.append(block((ends[0], ends[1]), (sides[0], sides[1]), (0, height), material))
    return parts


def table(look: Look) -> list[Part]:
    """A top on four legs."""
    x, y, z = look.size_m
    wood = look.choice("wood", WOODS)
    top = block(centred(x), centred(y), (z - 0.05, z), wood)
    return [top, *_legs(x - 0.1, y - 0.1, z - 0.05, 0.07, wood)]


def coffee_table(look: Look) -> list[Part]:
    """A low top on two panels."""
    x, y, z = look.size_m
    wood = look.choice("wood", WOODS)
    ends = ((-y / 2 + 0.08, -y / 2 + 0.13), (y / 2 - 0.13, y / 2 - 0.08))
    panels = [block(centred(0.8 * x), end, (0, z - 0.05), wood) for end in ends]
    return [block(centred(x), centred(y), (z - 0.05, z), wood), *panels]


def chair(look: Look) -> list[Part]:
    """Seat and back on four legs."""
    x, y, z = look.size_m
    seat = 0.47
    wood = look.choice("wood", WOODS)
    return [
        block(centred(x), centred(y), (seat - 0.05, seat), wood),
        block((-x / 2, -x / 2 + 0.05), centred(y), (seat + 0.1, z), wood),
        *(_legs(x, y, seat - 0.05, 0.045, "dark_metal")),
        block(
            (-x / 2 + 0.01, -x / 2 + 0.04),
            centred(0.5 * y),
            (seat, seat + 0.1),
            wood,
            collides=False,
        ),
    ]


def sofa(look: Look) -> list[Part]:
    """Base, cushions, back and arms."""
    x, y, z = look.size_m
    fabric = "fabric_" + look.choice("colour", FABRIC_COLOURS)
    arm = 0.2
    back = (-x / 2, -x / 2 + 0.24)
    inner = y / 2 - arm
    return [
        block((back[1], x / 2), centred(y - 2 * arm), (0.08, 0.44), fabric),
        block(back, centred(y), (0.08, z), fabric),
        block((back[1], x / 2), (-y / 2, -inner), (0.08, 0.62), fabric),
        block((back[1], x / 2), (inner, y / 2), (0.08, 0.62), fabric),
        block(centred(x - 0.1), centred(y - 0.1), (0, 0.08), "dark_wood", collides=False),
    ]


def bed(look: Look) -> list[Part]:
    """Frame, mattress with a cover, pillow and head board (-x)."""
    x, y, z = look.size_m
    fabric = "fabric_" + look.choice("colour", FABRIC_COLOURS)
    mattress = min(0.52, z)
    parts = [
        block((-x / 2 + 0.05, x / 2), centred(y), (0, 0.28), "wood"),
        block(
            (-x / 2 + 0.08, x / 2 - 0.03),
            centred(y - 0.06),
            (0.28, mattress - 0.02),
            "plastic_white",
        ),
        block((-x / 2 + 0.62, x / 2 - 0.02), centred(y - 0.04), (0.30, mattress), fabric),
        block((-x / 2, -x / 2 + 0.05), centred(y), (0, z), "wood"),
    ]
    if z > mattress + 0.1:
        pillow = (mattress - 0.02, mattress + 0.08)
        parts.append(
            block((-x / 2 + 0.1, -x / 2 + 0.5), centred(0.8 * y), pillow, "ceramic", collides=False)
        )
    return parts


def desk(look: Look) -> list[Part]:
    """A top on two side panels with a drawer block."""
    x, y, z = look.size_m
    wood = look.choice("wood", WOODS)
    return [
        block(centred(x), centred(y), (z - 0.04, z), wood),
        block(centred(0.9 * x), (-y / 2 + 0.02, -y / 2 + 0.06), (0, z - 0.04), "dark_metal"),
        block(centred(0.9 * x), (y / 2 - 0.44, y / 2 - 0.02), (0.1, z - 0.04), wood),
        block(
            centred(0.8 * x), (y / 2 - 0.4, y / 2 - 0.06), (0, 0.1), "dark_metal", collides=False
        ),
    ]


def cabinet(look: Look) -> list[Part]:
    """A chest with doors and handles at the front."""
    x, y, z = look.size_m
    wood = look.choice("wood", WOODS)
    door = "pale_wood" if wood != "pale_wood" else "wood"
    parts = [block((-x / 2, x / 2 - 0.03), centred(y), (0, z), wood)]
    parts += [
        block((x / 2 - 0.03, x / 2 - 0.01), side, (0.06, z - 0.05), door, collides=False)
        for side in ((-y / 2 + 0.02, -0.01), (0.01, y / 2 - 0.02))
    ]
    parts.append(
        block(
            (x / 2 - 0.01, x / 2),
            centred(0.12),
            (0.5 * z, 0.5 * z + 0.03),
            "dark_metal",
            collides=False,
        )
    )
    return parts


def nightstand(look: Look) -> list[Part]:
    """A small chest with two drawers."""
    x, y, z = look.size_m
    parts = [block((-x / 2, x / 2 - 0.02), centred(y), (0, z), look.choice("wood", WOODS))]
    front = (x / 2 - 0.02, x / 2)
    drawers = [(low, low + 0.34 * z) for low in (0.12 * z, 0.56 * z)]
    parts += [
        block(front, centred(0.85 * y), drawer, "dark_wood", collides=False) for drawer in drawers
    ]
    return parts


def shelf(look: Look) -> list[Part]:
    """Boards between two sides, books drawn as blocks."""
    x, y, z = look.size_m
    wood = look.choice("wood", WOODS)
    count = max(3, round(z / 0.42))
    rise = z / count
    parts = [
        block((-x / 2, x / 2), (-y / 2, -y / 2 + 0.03), (0, z), wood),
        block((-x / 2, x / 2), (y / 2 - 0.03, y / 2), (0, z), wood),
        block((-x / 2, -x / 2 + 0.02), centred(y - 0.06), (0, z), wood),
        block(centred(x), centred(y - 0.06), (z - 0.03, z), wood),
    ]
    for index in range(count):
        low = index * rise
        parts.append(block(centred(x), centred(y - 0.06), (low, low + 0.03), wood))
        fill = ((index * 37 + look.variant * 13) % 5 + 3) / 8 * (y - 0.1)
        colour = FABRIC_COLOURS[(index + look.variant) % len(FABRIC_COLOURS)]
        parts.append(
            block(
                (-x / 2 + 0.02, x / 2 - 0.06),
                (-y / 2 + 0.04, -y / 2 + 0.04 + fill),
                (low + 0.03, low + 0.03 + 0.62 * rise),
                f"fabric_{colour}",
                collides=False,
            )
        )
    return parts


def counter(look: Look) -> list[Part]:
    """Cupboards under a stone worktop."""
    x, y, z = look.size_m
    parts = [
        block((-x / 2, x / 2 - 0.04), centred(y), (0, z - 0.05), "plastic_white"),
        block(centred(x), centred(y), (z - 0.05, z), "stone"),
    ]
    count = max(1, round(y / 0.6))
    for index in range(1, count):
        at = -y / 2 + index * y / count
        parts.append(
            block(
                (x / 2 - 0.04, x / 2 - 0.03),
                (at - 0.01, at + 0.01),
                (0.1, z - 0.08),
                "dark_metal",
                collides=False,
            )
        )
    return parts


def lamp(look: Look) -> list[Part]:
    """A shade on a stem and a foot."""
    x, y, z = look.size_m
    width = min(x, y)
    shade = min(0.3, 0.4 * z)
    return [
        cylinder((0, 0, 0.015), 0.6 * width, 0.03, "dark_metal"),
        cylinder((0, 0, (z - shade) / 2), 0.03, z - shade, "dark_metal"),
        cylinder((0, 0, z - shade / 2), width, shade, "light_warm"),
    ]
