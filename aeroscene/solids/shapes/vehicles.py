"""Vehicles: cars, vans, trucks, buses and bicycles; the front is +x.

Wheels, lights and panes are decor that touches nothing: the body's underside lies lower than any
drone could fly.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from aeroscene.solids.shapes.forms import FORMS
from aeroscene.solids.shapes.look import Look
from aeroscene.solids.shapes.materials import PAINT_COLOURS
from aeroscene.solids.shapes.primitive import Interval, Part, block, centred, cylinder
from aeroscene.solids.shapes.solids import disc, inwards, paint, prism


def _wheels(x: float, y: float, diameter: float, axles: Sequence[float]) -> list[Part]:
    # Short or narrow vehicles get smaller wheels, which stay inside the box.
    width = min(0.24, 0.2 * y)
    diameter = min(diameter, 0.3 * x)
    return [
        disc((at * x, side * (y - width) / 2, diameter / 2), diameter, width, "rubber", axis="y")
        for at in axles
        for side in (-1, 1)
    ]


def _lights(x: float, y: float, height: float) -> list[Part]:
    """A bar of light across the front and another across the rear."""
    rise = (height, height + 0.1)
    return [
        paint(inwards(1, x / 2, 0.05), 0.84 * y, rise, "light_warm"),
        paint(inwards(-1, x / 2, 0.05), 0.84 * y, rise, "light_red"),
    ]


def _colour(look: Look) -> str:
    return "paint_" + look.choice("colour", PAINT_COLOURS)


@dataclass(frozen=True, slots=True)
class _CarPlan:
    """Side view of a car in fractions of its length and height."""

    cabin: Interval
    """Extent from the rear pane's foot to the windscreen's."""
    roof: Interval
    waist: float = 0.57
    nose: float = 0.44
    """Height of the bonnet's front edge."""
    sill_m: float = 0.2
    wheel_m: float = 0.64


_CARS = {
    "hatchback": _CarPlan((-0.47, 0.23), (-0.36, 0.06)),
    "saloon": _CarPlan((-0.34, 0.22), (-0.2, 0.06)),
    "estate": _CarPlan((-0.48, 0.22), (-0.43, 0.07)),
    "suv": _CarPlan((-0.48, 0.25), (-0.43, 0.11), 0.54, 0.47, 0.28, 0.74),
    "pickup": _CarPlan((-0.14, 0.26), (-0.12, 0.12), 0.54, 0.47, 0.3, 0.76),
}


def car(look: Look) -> list[Part]:
    """A body with a sloping bonnet, a glass cabin under a painted roof, wheels and lights.

    Reads the attributes `form` and `colour`.
    """
    x, y, z = look.size_m
    form = look.choice("form", FORMS["car"])
    plan, colour = _CARS[form], _colour(look)
    waist, tail = plan.waist * z, -x / 2 + 0.03
    # Side view from the tail clockwise; 3 cm at each end are left to lights and bumpers.
    body = prism(
        [
            (tail, plan.sill_m),
            # A saloon's boot falls a little to the rear.
            (tail, 0.94 * waist if form == "saloon" else waist),
            (plan.cabin[1] * x, waist),
            (x / 2 - 0.03, plan.nose * z),
            (x / 2 - 0.03, plan.sill_m),
        ],
        y - 0.05,
        colour,
        lean_m=0.02,
    )
    rear, front = plan.roof[0] * x, plan.roof[1] * x
    cabin = prism(
        [
            (plan.cabin[0] * x, 0.96 * waist),
            (plan.cabin[1] * x, waist),
            (front, z - 0.05),
            (rear, z - 0.05),
        ],
        0.94 * y,
        "dark_glass",
        lean_m=0.11 * y,
    )
    roof = block((rear, front), 0.74 * y, (z - 0.06, z), colour)
    parts = [body, cabin, roof, *_wheels(x, y, plan.wheel_m, (-0.3, 0.31))]
    parts += _lights(x, y, 0.8 * plan.nose * z)
    if form == "pickup":
        bed = (-x / 2 + 0.12, plan.cabin[0] * x - 0.06)
        parts.append(paint(bed, 0.8 * y, (waist, waist + 0.01), "rubber"))
    return parts


def van(look: Look) -> list[Part]:
    """A closed panel van, a minibus with windows, or a parcel van with a box of its own.

    Reads the attributes `form` and `colour`.
    """
    x, y, z = look.size_m
    form, colour = look.choice("form", FORMS["van"]), _colour(look)
    split, side = 0.24 * x, centred(y - 0.06)
    tall = z if form != "parcel" else min(z, 0.88 * z + 0.1)
    face, foot = x / 2 - 0.03, 0.44 * z
    nose = [(split, 0.25), (split, tall), (0.3 * x, tall), (face, foot), (face, 0.25)]
    # The windscreen lies on the slope between roof and bonnet, a few centimetres thick.
    slope = [(0.3 * x + t * (face - 0.3 * x), tall + t * (foot - tall)) for t in (0.08, 0.6)]
    screen = [(at + out, height) for at, height in slope for out in (-0.03, 0.02)]
    parts = [
        prism(nose, side, colour),
        prism(screen, y - 0.2, "dark_glass"),
        *_wheels(x, y, 0.68, (-0.3, 0.33)),
        *_lights(x, y, 0.3 * z),
    ]
    if form == "parcel":
        frame = block((-x / 2 + 0.05, split), 0.7 * y, (0.3, 0.6), "dark_metal")
        cargo = block((-x / 2 + 0.03, split), y, (0.6, z), "plastic_white")
        return [*parts, frame, cargo]
    parts.append(block((-x / 2 + 0.03, split), side, (0.25, z), colour))
    pane = (-0.46 * x, 0.22 * x) if form == "minibus" else (0.2 * x, 0.3 * x)
    parts.append(paint(pane, y - 0.04, (0.54 * z, 0.86 * z), "dark_glass"))
    return parts


def truck(look: Look) -> list[Part]:
    """A cab before a box, a flat bed or a tank, all on a dark frame.

    Reads the attributes `form`, `colour` and, of a box, `cargo`.
    """
    x, y, z = look.size_m
    form = look.choice("form", FORMS["truck"])
    cab_z, split = min(z, 2.75), x / 2 - min(2.1, 0.34 * x)
    face = x / 2 - 0.03
    cab = [(split, 0.5), (split, cab_z), (face - 0.2, cab_z), (face, 0.5 * cab_z), (face, 0.5)]
    screen = (face - 0.2, face + 0.02)
    pane = [
        (screen[0] + 0.01, 0.95 * cab_z),
        (screen[0] + 0.07, 0.95 * cab_z),
        (screen[1], 0.56 * cab_z),
        (screen[0], 0.56 * cab_z),
    ]
    parts = [
        prism(cab, y - 0.1, _colour(look)),
        prism(pane, y - 0.35, "dark_glass"),
        block((-x / 2 + 0.2, x / 2 - 0.3), 0.6 * y, (0.5, 0.95), "dark_metal"),
        *_wheels(x, y, 0.95, (-0.36, -0.22, 0.34)),
        *_lights(x, y, 0.62),
    ]
    return parts + _load(form, (-x / 2 + 0.02, split - 0.2), y, z, look)


def _load(form: str, along: Interval, y: float, z: float, look: Look) -> list[Part]:
    if form == "box":
        colour = look.choice("cargo", ("plastic_white", "corrugated", "paint_blue"))
        return [block(along, y, (0.95, z), colour)]
    if form == "flatbed":
        head = (along[1] - 0.12, along[1])
        return [
            block(along, y, (0.95, 1.15), "wood"),
            block(head, y, (1.15, min(z, 2.0)), "dark_metal"),
        ]
    # The tank lies on the frame, 0.95 m above the road, with a walkway on top to land on.
    wide = min(y - 0.1, z - 1.0)
    middle = ((along[0] + along[1]) / 2, 0.0, 0.95 + wide / 2)
    tank = cylinder(middle, wide, along[1] - along[0], "metal", axis="x")
    top = 0.95 + wide
    walk = block((along[0] + 0.3, along[1] - 0.3), 0.9, (top - 0.12, top), "dark_metal")
    return [tank, walk]


def bus(look: Look) -> list[Part]:
    """A city bus or a coach with a band of windows, or a school bus with a bonnet.

    Reads the attributes `form` and, except of a school bus, `colour`.
    """
    x, y, z = look.size_m
    form = look.choice("form", FORMS["bus"])
    colour = "paint_yellow" if form == "school" else _colour(look)
    front = 0.4 * x if form == "school" else x / 2 - 0.03
    floor = 0.45 if form == "coach" else 0.3
    body = block((-x / 2 + 0.03, front), y - 0.06, (floor, z), colour)
    band = {"city": (0.38, 0.8), "coach": (0.5, 0.9), "school": (0.48, 0.8)}[form]
    windows = paint((-0.46 * x, front - 0.35), y - 0.03, (band[0] * z, band[1] * z), "dark_glass")
    screen = paint(
        (front - 0.02, front + 0.02), 0.86 * y, ((band[0] - 0.08) * z, 0.88 * z), "dark_glass"
    )
    parts = [body, windows, screen, *_wheels(x, y, 0.95, (-0.3, 0.34))]
    parts += _lights(x if form == "school" else 2 * front + 0.06, y, 0.62)
    if form == "school":
        parts.append(block((front, x / 2 - 0.03), 0.84 * y, (0.45, 0.46 * z), colour))
    else:
        stripe = paint(0.9 * x, y - 0.05, (0.26 * z, 0.3 * z), "plastic_white")
        parts.append(stripe)
    return parts


def bicycle(look: Look) -> list[Part]:
    """Two wheels, a frame, a saddle and a handlebar; a cargo bicycle has a box in front.

    Reads the attributes `form` and `colour`.
    """
    x, y, z = look.size_m
    form, colour = look.choice("form", FORMS["bicycle"]), _colour(look)
    wheel = min(0.68, 0.4 * x, 0.7 * z)
    small = wheel if form != "cargo" else 0.7 * wheel
    # Middles of the wheels.
    front, rear = (x - small) / 2, (wheel - x) / 2
    saddle = -0.2 * x
    bar = front - 0.16 * x if form != "cargo" else 0.02 * x
    top = 0.76 * z if form == "race" else 0.6 * z
    parts = [
        cylinder((front, 0, small / 2), small, 0.05, "rubber", axis="y"),
        cylinder((rear, 0, wheel / 2), wheel, 0.05, "rubber", axis="y"),
        block((rear, front), 0.04, (0.46 * wheel, 0.46 * wheel + 0.05), colour),
        block((saddle, saddle + 0.05), 0.04, (0.4 * wheel, 0.92 * z), colour),
        block((bar, bar + 0.05), 0.04, (0.4 * wheel, 0.97 * z), colour),
        block((saddle - 0.1, saddle + 0.16), 0.15, (0.92 * z, 0.97 * z), "plastic_black"),
        block((bar - 0.02, bar + 0.04), y, (z - 0.05, z), "plastic_black"),
    ]
    if form == "cargo":
        box = block((0.1 * x, front), y, (0.5 * wheel, 0.62 * z), "wood")
        return [*parts, box]
    return [*parts, block((saddle, bar), 0.04, (top, top + 0.04), colour)]
