"""Screens, lamps and the small objects that lie on furniture; the front is +x."""

from __future__ import annotations

from math import atan2, hypot

from aeroscene.solids.shapes.forms import FORMS
from aeroscene.solids.shapes.look import Look
from aeroscene.solids.shapes.materials import FABRIC_COLOURS, PAINT_COLOURS
from aeroscene.solids.shapes.primitive import Part, block, cylinder, ellipsoid
from aeroscene.solids.shapes.solids import about, cone, disc, leaning, paint


def lamp(look: Look) -> list[Part]:
    """A shade on a stem and a foot: a drum, a globe or a cone, or a pendant on its cord.

    Reads the attributes `form` and `foot`. Only the attribute chooses a pendant: one that the
    number of the object drew would hang in the air.
    """
    x, y, z = look.size_m
    form = look.set_choice("form", (*FORMS["lamp"], "pendant"), FORMS["lamp"])
    wide = min(x, y)
    if form == "pendant":
        shade = min(0.4, 0.6 * z)
        cord = cylinder((0, 0, (z + shade) / 2), min(0.02, 0.2 * wide), z - shade, "dark_metal")
        return [cord, cylinder((0, 0, shade / 2), wide, shade, "light_warm")]
    shade = min(0.3, 0.42 * z) if form != "globe" else min(wide, 0.5 * z)
    low = z - shade
    foot = look.set_choice("foot", ("dark_metal", "ceramic", "metal"))
    stand = [
        cylinder((0, 0, 0.015), 0.6 * wide, 0.03, foot),
        cylinder((0, 0, low / 2), min(0.04, 0.2 * wide), low, foot),
    ]
    if form == "drum":
        return [*stand, cylinder((0, 0, z - shade / 2), wide, shade, "light_warm")]
    if form == "globe":
        return [*stand, ellipsoid(shade, shade, (low, z), "light_warm")]
    return [*stand, cone(wide, 0.5 * wide, (low, z), "light_warm")]


def television(look: Look) -> list[Part]:
    """A flat screen on a foot, on two legs, or over a bar of loudspeakers.

    Reads the attribute `form`.
    """
    x, y, z = look.size_m
    form = look.choice("form", FORMS["television"])
    low = 0.12 * z
    parts = _screen(y, (low, z), 0.0)
    if form == "legs":
        ends = [about(sign * 0.36 * y, 0.03) for sign in (-1, 1)]
        return (
            parts
            + [block(x, end, (0, 0.02), "dark_metal") for end in ends]
            + [paint(about(-0.005, 0.02), end, (0.02, low), "dark_metal") for end in ends]
        )
    if form == "bar":
        bar = block((-0.02, 0.5 * x), 0.8 * y, (0, low - 0.01), "dark_metal")
        return [*parts, bar]
    stem = paint(about(-0.005, 0.02), 0.08, (0.02, low), "plastic_black")
    return [*parts, block(x, 0.42 * y, (0, 0.02), "plastic_black"), stem]


def _screen(width: float, z: tuple[float, float], at_y: float) -> list[Part]:
    """A thin case with a picture that faces +x."""
    # The rim is as wide at the sides as at the top, about.
    rim = 0.025 * (z[1] - z[0])
    return [
        block((-0.02, 0.01), about(at_y, width), z, "plastic_black"),
        paint((0.01, 0.015), about(at_y, 0.95 * width), (z[0] + rim, z[1] - rim), "screen"),
    ]


def monitor(look: Look) -> list[Part]:
    """A computer screen on a foot, two side by side if wide enough, or one on a tall stem.

    Reads the attribute `form`.
    """
    x, y, z = look.size_m
    form = look.choice("form", FORMS["monitor"])
    low = 0.3 * z if form != "thin" else 0.42 * z
    foot = block(x, min(0.4 * y, 0.26), (0, 0.02), "metal")
    stem = paint(about(-0.035, 0.03), 0.05, (0.02, 0.7 * z), "metal")
    if form == "pair" and y > 0.6:
        half = y / 2 - 0.01
        screens = [p for sign in (-1, 1) for p in _screen(half, (low, z), sign * y / 4)]
        return [*screens, foot, stem]
    return [*_screen(y, (low, z), 0.0), foot, stem]


def laptop(look: Look) -> list[Part]:
    """A keyboard half and a screen that leans back.

    Reads the attribute `form`, which is the colour of its case.
    """
    x, y, z = look.size_m
    form = look.choice("form", FORMS["laptop"])
    case = {"silver": "metal", "black": "plastic_black", "white": "plastic_white"}[form]
    depth, thick = 0.85 * x, 0.012
    # The lid leans over the rest of the depth; its thickness counts on both axes.
    rise, run = z - 0.02 - thick, x - depth
    lean = atan2(run, rise)
    middle = (-x / 2 + run / 2 + 0.005, 0.0, 0.02 + rise / 2)
    lid = leaning(middle, (thick, y, hypot(run, rise) - thick), -lean, "y", "screen")
    base = (x / 2 - depth, x / 2)
    keys = paint(
        (base[0] + 0.1 * depth, base[0] + 0.6 * depth), 0.86 * y, (0.02, 0.022), "dark_metal"
    )
    return [block(base, y, (0, 0.02), case), lid, keys]


def plate(look: Look) -> list[Part]:
    """A flat disc on a foot, a bowl, or a plate with a meal on it.

    Reads the attribute `form`.
    """
    x, y, z = look.size_m
    form, wide = look.set_choice("form", FORMS["plate"]), min(x, y)
    if form == "bowl":
        inside = disc((0, 0, z), 0.86 * wide, 0.002, "marking_yellow")
        return [cone(0.45 * wide, wide, (0, z), "ceramic", sides=12), inside]
    rim = z if form == "flat" else 0.6 * z
    dish = cylinder((0, 0, 0.7 * rim), wide, 0.6 * rim, "ceramic")
    foot = disc((0, 0, 0.2 * rim), 0.6 * wide, 0.4 * rim, "ceramic")
    if form == "flat":
        well = disc((0, 0, z + 0.001), 0.66 * wide, 0.002, "plastic_white")
        return [dish, foot, well]
    return [
        dish,
        foot,
        disc((-0.12 * wide, 0, 0.8 * z), 0.4 * wide, 0.4 * z, "leaves_light"),
        disc((0.2 * wide, 0.1 * wide, 0.8 * z), 0.3 * wide, 0.4 * z, "bark"),
    ]


def cup(look: Look) -> list[Part]:
    """A mug with a handle, a glass, or a paper cup with a lid.

    Reads the attributes `form` and, of a mug, `glaze`.
    """
    x, y, z = look.size_m
    form, wide = look.set_choice("form", FORMS["cup"]), min(x, y)
    if form == "glass":
        glass = cone(0.7 * wide, 0.9 * wide, (0, z), "glass", sides=10)
        return [glass]
    if form == "paper":
        return [
            cone(0.66 * wide, 0.94 * wide, (0, 0.9 * z), "plastic_white"),
            cylinder((0, 0, 0.95 * z), wide, 0.1 * z, "plastic_black"),
        ]
    glaze = look.choice("glaze", ("ceramic", "paint_blue", "paint_red", "terracotta"))
    handle = paint((0.36 * wide, wide / 2), 0.015, (0.25 * z, 0.75 * z), glaze)
    inside = disc((0, 0, z), 0.66 * wide, 0.004, "bark")
    return [cylinder((0, 0, z / 2), 0.8 * wide, z, glaze), handle, inside]


def book(look: Look) -> list[Part]:
    """A pile, one that lies open, or a row that stands upright.

    Reads the attribute `form`.
    """
    x, y, z = look.size_m
    # High boxes suit a row, very low ones an open book, all of them a pile.
    drawn = ("pile", "upright") if z > 0.1 else ("pile", "open") if z < 0.05 else ("pile",)
    form = look.choice("form", FORMS["book"], drawn)
    covers = [
        f"fabric_{FABRIC_COLOURS[(look.variant + index) % len(FABRIC_COLOURS)]}"
        for index in range(4)
    ]
    if form == "upright":
        return [
            block(
                # Uneven depths and heights make four volumes of one block.
                (0.9, 0.76, 1.0, 0.84)[i] * x,
                about((i - 1.5) * y / 4, 0.235 * y),
                (0, (0.94, 1.0, 0.86, 0.97)[i] * z),
                cover,
            )
            for i, cover in enumerate(covers)
        ]
    if form == "open":
        return [
            block(x, y, (0, 0.3 * z), covers[0]),
            *(
                block(0.94 * x, about(sign * 0.24 * y, 0.46 * y), (0.3 * z, z), "paper")
                for sign in (-1, 1)
            ),
        ]
    count = 1 if z < 0.05 else min(4, max(2, round(z / 0.05)))
    shares = (1.0, 0.86, 0.94, 0.78)
    return [
        block(shares[i] * x, shares[i] * y, (i * z / count, (i + 1) * z / count), covers[i])
        for i in range(count)
    ]


def box(look: Look) -> list[Part]:
    """A carton with tape, one with a label, or a plastic tub with a lid.

    Reads the attributes `form` and, of a tub, `colour`.
    """
    x, y, z = look.size_m
    form = look.choice("form", FORMS["box"])
    if form == "tub":
        colour = "paint_" + look.choice("colour", PAINT_COLOURS)
        return [
            block(0.94 * x, 0.94 * y, (0, 0.86 * z), "plastic_white"),
            block(x, y, (0.86 * z, z), colour),
        ]
    carton = block(x, y, (0, z - 0.002), "cardboard")
    tape = paint(x, 0.06, (z - 0.002, z), "pale_wood")
    if form == "taped":
        return [carton, tape]
    label = paint((x / 2, x / 2 + 0.003), 0.5 * y, (0.3 * z, 0.7 * z), "paper")
    stripe = paint((x / 2, x / 2 + 0.004), 0.5 * y, (0.6 * z, 0.66 * z), "plastic_black")
    return [carton, tape, label, stripe]
