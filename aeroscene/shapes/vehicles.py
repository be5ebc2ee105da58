"""Cars, vans, trucks, buses and bicycles; the front is +x."""

from __future__ import annotations

from aeroscene.scene import Vector3
from aeroscene.shapes.look import Look
from aeroscene.shapes.materials import PAINT_COLOURS
from aeroscene.shapes.primitive import Interval, Part, block, centred, cylinder, hull


def _wheels(x: float, y: float, diameter: float, axles: tuple[float, ...]) -> list[Part]:
    width = 0.22
    return [
        cylinder(
            (at * x, side * (y / 2 - width / 2), diameter / 2),
            diameter,
            width,
            "rubber",
            axis="y",
            collides=False,
        )
        for at in axles
        for side in (-1, 1)
    ]


def _lights(x: float, y: float, height: float) -> list[Part]:
    parts: list[Part] = []
    for end, material in ((1, "light_warm"), (-1, "light_red")):
        face = sorted((end * x / 2, end * (x / 2 - 0.03)))
        for side in (-1, 1):
            middle = side * (y / 2 - 0.3)
            lamp = (middle - 0.17, middle + 0.17)
            parts.append(
                block((face[0], face[1]), lamp, (height, height + 0.14), material, collides=False)
            )
    return parts


def _prism(bottom: Interval, top: Interval, y: float, taper: float, z: Interval, name: str) -> Part:
    """A hull with a sloping front and back and sides that lean in by `taper`."""
    vertices: list[Vector3] = []
    for side in (-1, 1):
        vertices += [(end, side * y / 2, z[0]) for end in bottom]
        vertices += [(end, side * (y / 2 - taper), z[1]) for end in top]
    return hull(vertices, name)


def car(look: Look) -> list[Part]:
    """Body, glass cabin with a painted roof, wheels and lights."""
    x, y, z = look.size_m
    paint = "paint_" + look.choice("colour", PAINT_COLOURS)
    sill, waist = 0.2, 0.58 * z
    rear = -0.40 if look.variant % 2 else -0.30
    cabin = _prism(
        (rear * x - 0.05 * x, 0.20 * x),
        (rear * x + 0.04 * x, 0.06 * x),
        0.92 * y,
        0.12,
        (waist, z - 0.04),
        "dark_glass",
    )
    roof = block((rear * x + 0.04 * x, 0.06 * x), centred(0.92 * y - 0.26), (z - 0.06, z), paint)
    front = block((0.485 * x, 0.5 * x), centred(0.7 * y), (0.3, 0.42), "rubber", collides=False)
    body = block((-x / 2 + 0.03, x / 2 - 0.03), centred(y - 0.08), (sill, waist), paint)
    wheels = _wheels(x, y, 0.64, (-0.31, 0.31))
    return [body, cabin, roof, front, *wheels, *_lights(x, y, waist - 0.26)]


def van(look: Look) -> list[Part]:
    """A box body with a short sloping nose."""
    x, y, z = look.size_m
    paint = "paint_" + look.choice("colour", PAINT_COLOURS)
    body = block((-x / 2 + 0.03, 0.30 * x), centred(y - 0.06), (0.25, z), paint)
    nose = _prism(
        (0.30 * x, 0.5 * x - 0.03),
        (0.30 * x, 0.36 * x),
        y - 0.08,
        0.1,
        (0.52 * z, z - 0.05),
        "dark_glass",
    )
    bonnet = block((0.30 * x, 0.5 * x - 0.03), centred(y - 0.08), (0.25, 0.52 * z), paint)
    return [body, nose, bonnet, *_wheels(x, y, 0.68, (-0.32, 0.33)), *_lights(x, y, 0.75)]


def truck(look: Look) -> list[Part]:
    """A cab before a cargo box on a dark frame."""
    x, y, z = look.size_m
    paint = "paint_" + look.choice("colour", PAINT_COLOURS)
    cab_z = min(z, 2.7)
    split = x / 2 - 2.1
    cargo = block((-x / 2, split - 0.25), centred(y), (0.95, z), "plastic_white")
    cab = block((split, x / 2 - 0.03), centred(y - 0.1), (0.5, cab_z), paint)
    frame = block((-x / 2 + 0.2, x / 2 - 0.3), centred(0.6 * y), (0.5, 0.95), "dark_metal")
    screen = block(
        (x / 2 - 0.03, x / 2 - 0.01),
        centred(y - 0.5),
        (0.55 * cab_z, 0.9 * cab_z),
        "dark_glass",
        collides=False,
    )
    return [
        cargo,
        cab,
        frame,
        screen,
        *_wheels(x, y, 0.95, (-0.36, -0.2, 0.36)),
        *_lights(x, y, 0.7),
    ]


def bus(look: Look) -> list[Part]:
    """One long body with a band of windows."""
    x, y, z = look.size_m
    paint = "paint_" + look.choice("colour", PAINT_COLOURS)
    body = block((-x / 2 + 0.03, x / 2 - 0.03), centred(y - 0.06), (0.3, z), paint)
    band = (0.45 * z, 0.78 * z)
    parts = [body, *_wheels(x, y, 0.95, (-0.3, 0.32)), *_lights(x, y, 0.55)]
    for side in (-1, 1):
        pane = sorted((side * y / 2, side * (y / 2 - 0.03)))
        parts.append(
            block(centred(0.94 * x), (pane[0], pane[1]), band, "dark_glass", collides=False)
        )
    parts.append(
        block(
            (x / 2 - 0.03, x / 2),
            centred(0.85 * y),
            (0.4 * z, 0.82 * z),
            "dark_glass",
            collides=False,
        )
    )
    return parts


def bicycle(look: Look) -> list[Part]:
    """Two wheels, a frame, a saddle and a handlebar."""
    x, y, z = look.size_m
    paint = "paint_" + look.choice("colour", PAINT_COLOURS)
    wheel = min(0.66, 0.42 * x, 0.7 * z)
    axle = x / 2 - wheel / 2
    return [
        cylinder((axle, 0, wheel / 2), wheel, 0.05, "rubber", axis="y"),
        cylinder((-axle, 0, wheel / 2), wheel, 0.05, "rubber", axis="y"),
        block((-axle, axle), centred(0.04), (0.5 * wheel, 0.5 * wheel + 0.05), paint),
        block((-0.3 * x, 0.26 * x), centred(0.04), (0.75 * z, 0.75 * z + 0.04), paint),
        block((-0.3 * x, -0.3 * x + 0.05), centred(0.04), (0.5 * wheel, 0.92 * z), paint),
        block((0.24 * x, 0.24 * x + 0.05), centred(0.04), (0.5 * wheel, 0.96 * z), paint),
        block((-0.38 * x, -0.22 * x), centred(0.16), (0.92 * z, 0.97 * z), "plastic_black"),
        block((0.22 * x, 0.27 * x), centred(y), (z - 0.05, z), "plastic_black"),
    ]


def boat(look: Look) -> list[Part]:
    """An open hull with a pointed bow at +x and a cabin amidships."""
    x, y, z = look.size_m
    deck, paint = 0.4 * z, "paint_" + look.choice("colour", PAINT_COLOURS)
    beam, keel = centred(y), centred(0.6 * y)
    stern = [(-x / 2, side, deck) for side in beam] + [(-x / 2, side, 0.0) for side in keel]
    middle = [(0.2 * x, side, deck) for side in beam] + [(0.2 * x, side, 0.0) for side in keel]
    bow = [(x / 2, 0.0, deck), (0.4 * x, 0.0, 0.0)]
    cabin = block((-0.3 * x, 0.1 * x), centred(0.6 * y), (deck, z), "plastic_white")
    return [hull([*stern, *middle, *bow], paint), cabin]
