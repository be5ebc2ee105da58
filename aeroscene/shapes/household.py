"""Appliances and small things that stand on furniture; the front is +x."""

from __future__ import annotations

from math import atan2, cos, hypot, sin

from aeroscene.shapes.look import Look
from aeroscene.shapes.materials import FABRIC_COLOURS
from aeroscene.shapes.primitive import Part, block, centred, cylinder


def armchair(look: Look) -> list[Part]:
    """A seat between arms."""
    x, y, z = look.size_m
    fabric = "fabric_" + look.choice("colour", FABRIC_COLOURS)
    inner = y / 2 - 0.16
    front = (-x / 2 + 0.2, x / 2)
    return [
        block(front, centred(2 * inner), (0.08, 0.44), fabric),
        block((-x / 2, -x / 2 + 0.2), centred(y), (0.08, z), fabric),
        block(front, (-y / 2, -inner), (0.08, 0.62), fabric),
        block(front, (inner, y / 2), (0.08, 0.62), fabric),
        block(centred(x - 0.1), centred(y - 0.1), (0, 0.08), "dark_wood", collides=False),
    ]


def wardrobe(look: Look) -> list[Part]:
    """A tall case with two doors."""
    x, y, z = look.size_m
    front = (x / 2 - 0.03, x / 2)
    doors = ((-y / 2 + 0.02, -0.01), (0.01, y / 2 - 0.02))
    return [
        block((-x / 2, front[0]), centred(y), (0, z), "pale_wood"),
        *(block(front, door, (0.05, z - 0.04), "plastic_white", collides=False) for door in doors),
    ]


def fridge(look: Look) -> list[Part]:
    """A tall case, freezer door above."""
    x, y, z = look.size_m
    front = (x / 2 - 0.03, x / 2)
    doors = ((0.03, 0.64 * z), (0.66 * z, z - 0.02))
    return [
        block((-x / 2, front[0]), centred(y), (0, z), "metal"),
        *(block(front, centred(y - 0.02), d, "plastic_white", collides=False) for d in doors),
    ]


def stove(look: Look) -> list[Part]:
    """An oven with four plates on top."""
    x, y, z = look.size_m
    return [
        block((-x / 2, x / 2 - 0.02), centred(y), (0, z - 0.01), "plastic_white"),
        block(
            (x / 2 - 0.02, x / 2),
            centred(0.8 * y),
            (0.2 * z, 0.7 * z),
            "dark_glass",
            collides=False,
        ),
        block(centred(0.9 * x), centred(0.9 * y), (z - 0.01, z), "plastic_black", collides=False),
    ]


def _screen(look: Look, foot: str) -> list[Part]:
    x, y, z = look.size_m
    gap = 0.14 * z
    return [
        block((-0.02, 0.01), centred(y), (gap, z), "plastic_black"),
        block(
            (0.01, 0.02), centred(0.95 * y), (gap + 0.03 * z, 0.97 * z), "screen", collides=False
        ),
        block(centred(x), centred(0.4 * y), (0, 0.02), foot),
        block((-0.015, 0.005), centred(0.08), (0.02, gap), foot, collides=False),
    ]


def television(look: Look) -> list[Part]:
    """A flat screen on a foot."""
    return _screen(look, "plastic_black")


def monitor(look: Look) -> list[Part]:
    """A computer screen on a foot."""
    return _screen(look, "metal")


def laptop(look: Look) -> list[Part]:
    """A keyboard half and a screen that leans back."""
    x, y, z = look.size_m
    depth, thick = 0.85 * x, 0.012
    rise, run = z - 0.02 - thick, x - depth
    lean = atan2(run, rise)
    length = hypot(run, rise) - thick
    lid = Part(
        kind="box",
        position_m=(-x / 2 + run / 2 + 0.005, 0.0, 0.02 + rise / 2),
        quat_wxyz=(cos(lean / 2), 0.0, -sin(lean / 2), 0.0),
        size_m=(thick, y, length),
        material="screen",
    )
    return [block((x / 2 - depth, x / 2), centred(y), (0, 0.02), "metal"), lid]


def plate(look: Look) -> list[Part]:
    """A flat disc with a foot."""
    x, y, z = look.size_m
    width = min(x, y)
    return [
        cylinder((0, 0, 0.25 * z), 0.6 * width, 0.5 * z, "ceramic", collides=False),
        cylinder((0, 0, 0.75 * z), width, 0.5 * z, "ceramic"),
    ]


def cup(look: Look) -> list[Part]:
    """A mug with a handle."""
    x, y, z = look.size_m
    width = 0.8 * min(x, y)
    return [
        cylinder((0, 0, z / 2), width, z, "ceramic"),
        block(
            (width / 2, min(x, y) / 2),
            centred(0.015),
            (0.25 * z, 0.75 * z),
            "ceramic",
            collides=False,
        ),
    ]


def book(look: Look) -> list[Part]:
    """One to three books in a pile."""
    x, y, z = look.size_m
    count = 1 if z < 0.05 else min(3, round(z / 0.04))
    parts: list[Part] = []
    for index in range(count):
        shrink = 1 - 0.1 * index
        colour = FABRIC_COLOURS[(look.variant + index) % len(FABRIC_COLOURS)]
        rise = (index * z / count, (index + 1) * z / count)
        parts.append(block(centred(shrink * x), centred(shrink * y), rise, f"fabric_{colour}"))
    return parts


def box(look: Look) -> list[Part]:
    """A carton with tape."""
    x, y, z = look.size_m
    return [
        block(centred(x), centred(y), (0, z - 0.002), "cardboard"),
        block(centred(x), centred(0.06), (z - 0.002, z), "pale_wood", collides=False),
    ]


def cutlery(look: Look) -> list[Part]:
    """A knife and a fork beside each other, handles at -x."""
    x, y, z = look.size_m
    width = 0.3 * y
    return [
        block(
            centred(x),
            (side * (y - width) / 2 - width / 2, side * (y - width) / 2 + width / 2),
            (0, z),
            "metal",
        )
        for side in (-1, 1)
    ]
