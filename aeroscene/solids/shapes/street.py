"""Street furniture, along roads and paths; lights and signs face +x."""

from __future__ import annotations

from aeroscene.solids.shapes.forms import FORMS
from aeroscene.solids.shapes.look import Look
from aeroscene.solids.shapes.materials import PAINT_COLOURS
from aeroscene.solids.shapes.primitive import Part, block, centred, cylinder
from aeroscene.solids.shapes.solids import about, cone, disc, frustum, inwards, paint


def street_lamp(look: Look) -> list[Part]:
    """A post with an arm over the road (+x), with one over each side, or with a lantern.

    Reads the attribute `form`. Short boxes have no room for an arm and hold a lantern.
    """
    x, y, z = look.size_m
    form = look.choice("form", FORMS["street_lamp"] if x > 0.9 else ("lantern",))
    post = min(0.14, 0.5 * min(x, y))
    if form == "lantern":
        wide, head = min(x, y, 0.5), min(0.6, 0.2 * z)
        low = z - head
        return [
            cylinder((0, 0, low / 2), post, low, "dark_metal"),
            cone(0.5 * wide, wide, (low, z - 0.2 * head), "light_warm", sides=6),
            cone(wide, 0.2 * wide, (z - 0.2 * head, z), "dark_metal", sides=6),
        ]
    # A twin stands in the middle; a single arm starts from the rear end of the box.
    foot = 0.0 if form == "twin" else -x / 2 + 0.15
    arm = (-x / 2, x / 2) if form == "twin" else (foot, x / 2)
    head = min(0.6, 0.4 * x)
    lamps = [(x / 2 - head, x / 2)] + ([(-x / 2, head - x / 2)] if form == "twin" else [])
    return [
        cylinder((foot, 0, z / 2 - 0.05), post, z - 0.1, "dark_metal"),
        block(arm, min(0.09, y), (z - 0.12, z - 0.02), "dark_metal"),
        *(block(lamp, min(y, 0.36), (z - 0.2, z - 0.1), "light_warm") for lamp in lamps),
    ]


def traffic_light(look: Look) -> list[Part]:
    """A post with a head of lamps: three for vehicles, with or without a plate, or two for people.

    Reads the attribute `form`.
    """
    x, y, z = look.size_m
    form = look.choice("form", FORMS["traffic_light"])
    # From the lowest lamp to the highest.
    colours = ["light_green", "marking_yellow", "light_red"]
    if form == "pedestrian":
        colours = ["light_green", "light_red"]
    tall = 0.32 * len(colours)
    low = z - tall - (0.06 if form == "plate" else 0.0)
    wide = min(y, 0.34)
    parts = [
        cylinder(
            (-0.1 * x, 0, low / 2 + 0.02), min(0.12, 0.4 * min(x, y)), low + 0.04, "dark_metal"
        ),
        block(x - 0.08, wide, (low, low + tall), "plastic_black"),
    ]
    if form == "plate":
        parts.append(paint(about(0.1 * x, 0.02), y, (low - 0.06, z), "plastic_white"))
    parts += [
        disc(
            (x / 2 - 0.025, 0, low + 0.16 + 0.32 * index),
            min(0.22, 0.7 * wide),
            0.03,
            colour,
            axis="x",
        )
        for index, colour in enumerate(colours)
    ]
    return parts


def sign(look: Look) -> list[Part]:
    """A plate on a post, a round traffic sign, a board between two posts, or a flat panel.

    Reads the attributes `form` and `colour`. Only the attribute chooses a panel, which has no post:
    it hangs on a wall.
    """
    x, y, z = look.size_m
    drawn = FORMS["sign"] if y > 0.9 else FORMS["sign"][:2]
    form = look.choice("form", (*FORMS["sign"], "panel"), drawn)
    thick, post = min(0.04, x), min(0.08, x)
    colour = "paint_" + look.choice("colour", PAINT_COLOURS)
    back = -thick / 2
    if form == "panel":
        rim = min(0.06, 0.1 * y, 0.1 * z)
        inner = (centred(y - 2 * rim), (rim, z - rim))
        return [block(x, y, (0, z), "dark_wood"), paint((x / 2, x / 2 + 0.004), *inner, colour)]
    if form == "round":
        wide = min(y, 0.8)
        middle = z - wide / 2
        return [
            cylinder((back, 0, (z - wide / 2) / 2), min(post, 0.06), z - wide / 2, "metal"),
            cylinder((0, 0, middle), wide, thick, "light_red", axis="x"),
            disc((thick / 2, 0, middle), 0.74 * wide, 0.012, "plastic_white", axis="x"),
        ]
    if form == "board":
        low = max(0.4 * z, z - 1.4)
        ends = [about(side * (y / 2 - 0.12), min(0.1, post)) for side in (-1, 1)]
        return [
            *(block(post, end, (0, z), "dark_wood") for end in ends),
            block(thick, y, (low, z - 0.06), "pale_wood"),
            paint((thick / 2, thick / 2 + 0.01), y - 0.24, (low + 0.1, z - 0.16), colour),
        ]
    plate = min(0.8, 0.4 * z)
    return [
        cylinder((back, 0, (z - 0.1) / 2), min(post, 0.06), z - 0.1, "metal"),
        block(thick, y, (z - plate, z), colour),
        paint(
            (thick / 2, thick / 2 + 0.01),
            0.8 * y,
            about(z - plate / 2, 0.2 * plate),
            "plastic_white",
        ),
    ]


def bin_(look: Look) -> list[Part]:
    """A wheeled bin with a lid, a round litter bin, or a container with a domed top.

    Reads the attributes `form` and `material`.
    """
    x, y, z = look.size_m
    form, wide = look.choice("form", FORMS["bin"]), min(x, y)
    colour = look.choice(
        "material", ("plastic_green", "plastic_black", "paint_blue", "paint_yellow")
    )
    if form == "litter":
        rim = min(0.16, 0.2 * z)
        return [
            cylinder((0, 0, (z - rim) / 2), 0.92 * wide, z - rim, "dark_metal"),
            cylinder((0, 0, z - rim / 2), wide, rim, "metal"),
            disc((0, 0, z), 0.6 * wide, 0.004, "rubber"),
        ]
    if form == "dome":
        shell = [
            frustum((0.8 * x, 0.84 * y), (x, y), (0, 0.74 * z), colour),
            frustum((x, y), (0.62 * x, 0.62 * y), (0.74 * z, z), colour),
        ]
        hole = disc((0.44 * x, 0, 0.66 * z), 0.24 * wide, 0.08 * x, "rubber", axis="x")
        return [*shell, hole]
    wheel = min(0.2, 0.25 * x, 0.3 * z)
    axle = disc((-0.36 * x, 0, wheel / 2), wheel, 0.94 * y, "rubber", axis="y")
    return [
        frustum((0.74 * x, 0.8 * y), (0.92 * x, 0.94 * y), (0.04, 0.88 * z), colour),
        block(x, y, (0.88 * z, z), colour),
        axle,
        paint(inwards(-1, x / 2, 0.05), 0.8 * y, (0.8 * z, 0.86 * z), "plastic_black"),
    ]
