"""Equipment that stands on roofs; the front is +x."""

from __future__ import annotations

from dataclasses import replace
from math import atan2, cos, hypot, sin

from aeroscene.solids.shapes.forms import FORMS
from aeroscene.solids.shapes.look import Look
from aeroscene.solids.shapes.primitive import Interval, Part, block, cylinder
from aeroscene.solids.shapes.solids import about, cone, disc, inwards, leaning, legs, paint, shifted


def ac_unit(look: Look) -> list[Part]:
    """A housing with a fan on top, with two fans in front, or with a duct behind it.

    Reads the attribute `form`.
    """
    x, y, z = look.size_m
    form = look.choice("form", FORMS["ac_unit"])
    front = inwards(1, x / 2, 0.02)
    if form == "twin":
        wide = min(0.44 * y, 0.8 * z)
        fans = [
            disc((x / 2 - 0.01, sign * 0.24 * y, 0.52 * z), wide, 0.02, "dark_metal", axis="x")
            for sign in (-1, 1)
        ]
        feet = [block(x, about(sign * 0.4 * y, 0.1), (0, 0.1), "rubber") for sign in (-1, 1)]
        return [block((-x / 2, front[0]), y, (0.1, z), "plastic_white"), *fans, *feet]
    grille = paint(front, 0.8 * y, (0.2 * z, 0.8 * z), "dark_metal")
    if form == "duct":
        split = -0.1 * x
        bend = block((-x / 2, split), 0.5 * y, (0, 0.62 * z), "corrugated")
        return [block((split, front[0]), y, (0, z), "metal"), bend, grille]
    fan = 0.74 * min(x, y)
    return [
        block((-x / 2, front[0]), y, (0, z), "metal"),
        disc((0, 0, z + 0.004), fan, 0.008, "dark_metal"),
        disc((0, 0, z + 0.008), 0.2 * fan, 0.008, "metal"),
        grille,
    ]


def chimney(look: Look) -> list[Part]:
    """A brick stack with a cap, one with two pots, or a flue of steel.

    Reads the attribute `form`.
    """
    x, y, z = look.size_m
    form = look.choice("form", FORMS["chimney"])
    if form == "flue":
        wide, hood = 0.7 * min(x, y), min(0.3, 0.2 * z)
        return [
            block(x, y, (0, 0.2 * z), "concrete"),
            cylinder((0, 0, (z - hood) / 2), wide, z - hood, "metal"),
            cone(1.3 * wide, 0.1, (z - hood, z), "dark_metal"),
        ]
    pots = min(0.35, 0.25 * z) if form == "pots" else 0.15
    top = z - pots
    parts = [
        block(0.86 * x, 0.86 * y, (0, top), "brick"),
        block(x, y, (top - 0.15, top), "concrete"),
    ]
    if form == "stack":
        return [*parts, paint(0.5 * x, 0.5 * y, (top, z), "dark_concrete")]
    wide = 0.4 * min(x, y)
    return parts + [
        shifted(cone(wide, 0.8 * wide, (top, z), "terracotta"), 0, side * 0.24 * y)
        for side in (-1, 1)
    ]


def solar_panel(look: Look) -> list[Part]:
    """A panel that leans back from low front (+x) to high rear; one, two in rows, or a tent.

    Reads the attribute `form`.
    """
    x, y, z = look.size_m
    form = look.choice("form", FORMS["solar_panel"] if x > 1.2 else ("rack",))
    if form == "tent":
        half = _panel((0.01, x / 2), y, min(z, 0.35 * x))
        return [*half, *(_mirrored(part) for part in half)]
    if form == "rows":
        return [*_panel((0.04 * x, x / 2), y, z), *_panel((-x / 2, -0.08 * x), y, z)]
    feet = [
        block(inwards(-1, 0.46 * x, 0.06), about(at * y, 0.06), (0, 0.74 * z), "metal")
        for at in (-0.35, 0.35)
    ]
    return [*_panel((-x / 2, x / 2), y, z), *feet]


def _panel(along: Interval, y: float, z: float) -> list[Part]:
    """A tilted panel on a rail at its low front edge, within an interval of x."""
    thick, low = 0.05, min(0.12, 0.3 * z)
    length_x = along[1] - along[0]
    rise, run = z - low - thick, length_x - thick
    # The panel's own thickness takes part of both sides of the triangle that it spans.
    tilt = atan2(rise, run)
    length = hypot(rise, run) - thick * sin(tilt)
    middle = ((along[0] + along[1]) / 2, 0.0, low + rise / 2)
    rail = about(middle[0] + 0.4 * length * cos(tilt), 0.06)
    return [
        leaning(middle, (length, y, thick), tilt, "y", "solar"),
        block(rail, 0.9 * y, (0, low), "metal"),
    ]


def _mirrored(part: Part) -> Part:
    """The same part on the other side of x = 0."""
    w, qx, qy, qz = part.quat_wxyz
    px, py, pz = part.position_m
    # A mirror image of a turn keeps the component along the mirror's normal and negates the others.
    return replace(part, position_m=(-px, py, pz), quat_wxyz=(w, qx, -qy, -qz))


def water_tank(look: Look) -> list[Part]:
    """A drum on a frame, a wooden one under a pointed hat, or one that lies on saddles.

    Reads the attribute `form`.
    """
    x, y, z = look.size_m
    form, wide = look.choice("form", FORMS["water_tank"]), min(x, y)
    if form == "lying" and max(x, y) > 0.8 * z:
        girth = min(wide, z - 0.2)
        saddles = [about(sign * 0.3 * x, 0.16) for sign in (-1, 1)]
        return [
            cylinder((0, 0, z - girth / 2), girth, x, "paint_blue", axis="x"),
            *(block(at, 0.8 * girth, (0, z - 0.8 * girth), "concrete") for at in saddles),
            cylinder((0, 0, z - 0.02), 0.3 * girth, 0.06, "dark_metal"),
        ]
    frame = 0.25 * z
    feet = legs(0.64 * wide, 0.64 * wide, (0, frame), 0.12, "dark_metal")
    if form == "hat":
        eaves = 0.78 * z
        return [
            cylinder((0, 0, (eaves + frame) / 2), 0.94 * wide, eaves - frame, "wood"),
            cone(wide, 0.1, (eaves, z), "dark_metal", sides=10),
            *feet,
        ]
    lid = disc((0, 0, z + 0.004), 0.3 * wide, 0.008, "dark_metal")
    return [cylinder((0, 0, (z + frame) / 2), wide, z - frame, "corrugated"), lid, *feet]
