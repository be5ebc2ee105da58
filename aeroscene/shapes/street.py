"""Street furniture and things that lie about in yards."""

from __future__ import annotations

from aeroscene.shapes.look import Look
from aeroscene.shapes.materials import PAINT_COLOURS
from aeroscene.shapes.primitive import Part, block, centred, cylinder


def street_lamp(look: Look) -> list[Part]:
    """A post with an arm over the road (+x)."""
    x, y, z = look.size_m
    post = 0.14
    foot = -x / 2 + 0.15
    arm = (foot, x / 2)
    return [
        cylinder((foot, 0, z / 2 - 0.05), post, z - 0.1, "dark_metal"),
        block(arm, centred(0.09), (z - 0.12, z - 0.02), "dark_metal"),
        block((x / 2 - min(0.6, x / 2), x / 2), centred(y), (z - 0.2, z - 0.1), "light_warm"),
    ]


def traffic_light(look: Look) -> list[Part]:
    """A post with a head of three lamps that face +x."""
    x, y, z = look.size_m
    head = (z - 1.0, z)
    parts = [
        cylinder((0, 0, (z - 1) / 2), 0.12, z - 1, "dark_metal"),
        block(centred(x - 0.06), centred(y), head, "plastic_black"),
    ]
    for index, colour in enumerate(("light_green", "marking_yellow", "light_red")):
        middle = z - 0.83 + 0.33 * index
        parts.append(
            cylinder(
                (x / 2 - 0.015, 0, middle),
                min(0.2, 0.7 * y),
                0.03,
                colour,
                axis="x",
                collides=False,
            )
        )
    return parts


def sign(look: Look) -> list[Part]:
    """A plate on a post."""
    x, y, z = look.size_m
    plate = min(0.8, 0.4 * z)
    paint = "paint_" + look.choice("colour", PAINT_COLOURS)
    return [
        cylinder((0, 0, (z - plate) / 2), min(0.08, x), z - plate, "metal"),
        block(centred(min(0.04, x)), centred(y), (z - plate, z), paint),
    ]


def bench(look: Look) -> list[Part]:
    """Seat, back rest behind (-x) and two feet."""
    x, y, z = look.size_m
    seat = min(0.45, 0.6 * z)
    parts = [
        block((-x / 2, x / 2), centred(y), (seat - 0.06, seat), "wood"),
        block((-x / 2, -x / 2 + 0.06), centred(y), (seat + 0.12, z), "wood"),
    ]
    for side in (-1, 1):
        middle = side * (y / 2 - 0.25)
        foot = (middle - 0.04, middle + 0.04)
        parts.append(block((-x / 2, x / 2 - 0.05), foot, (0, seat - 0.06), "dark_metal"))
        parts.append(
            block((-x / 2, -x / 2 + 0.05), foot, (seat, seat + 0.14), "dark_metal", collides=False)
        )
    return parts


def bin_(look: Look) -> list[Part]:
    """A bin with a lid."""
    x, y, z = look.size_m
    return [
        block(centred(0.92 * x), centred(0.92 * y), (0, 0.86 * z), "plastic_green"),
        block(centred(x), centred(y), (0.86 * z, z), "plastic_black"),
    ]


def crate(look: Look) -> list[Part]:
    """A wooden crate with a darker rim."""
    x, y, z = look.size_m
    return [
        block(centred(x - 0.02), centred(y - 0.02), (0, z), "pale_wood"),
        block(centred(x), centred(y), (0.45 * z, 0.55 * z), "dark_wood", collides=False),
    ]


def barrel(look: Look) -> list[Part]:
    """A steel drum with a hoop."""
    x, y, z = look.size_m
    diameter = min(x, y)
    paint = "paint_" + look.choice("colour", PAINT_COLOURS)
    return [
        cylinder((0, 0, z / 2), 0.97 * diameter, z, paint),
        cylinder((0, 0, z / 2), diameter, 0.06, "dark_metal", collides=False),
    ]


def pallet(look: Look) -> list[Part]:
    """A pallet, and the load on it when it is taller than a bare one."""
    x, y, z = look.size_m
    deck = min(z, 0.144)
    parts = [
        block(centred(x), centred(y), (deck - 0.03, deck), "wood"),
        block(centred(x), centred(0.8 * y), (0, deck - 0.03), "dark_wood"),
    ]
    if z > deck + 0.05:
        parts.append(block(centred(0.95 * x), centred(0.95 * y), (deck, z), "cardboard"))
    return parts


def landing_pad(look: Look) -> list[Part]:
    """A mat with a ring and an H."""
    x, y, z = look.size_m
    side = min(x, y)
    yellow, dark = (z + 0.001, z + 0.003)
    parts = [
        block(centred(x), centred(y), (0, z), "dark_concrete"),
        cylinder((0, 0, yellow), 0.86 * side, 0.002, "marking_yellow", collides=False),
        cylinder((0, 0, dark), 0.76 * side, 0.002, "dark_concrete", collides=False),
    ]
    paint = (z + 0.003, z + 0.005)
    for sign_ in (-1, 1):
        middle = sign_ * 0.15 * side
        bar = (middle - 0.04 * side, middle + 0.04 * side)
        parts.append(block(centred(0.46 * side), bar, paint, "marking_white", collides=False))
    parts.append(
        block(centred(0.09 * side), centred(0.24 * side), paint, "marking_white", collides=False)
    )
    return parts
