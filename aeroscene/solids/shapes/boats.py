"""Boats: a hull with its bow at +x, and the fittings that make its kind."""

from __future__ import annotations

from aeroscene.scene import Vector3
from aeroscene.solids.shapes.forms import FORMS
from aeroscene.solids.shapes.look import Look
from aeroscene.solids.shapes.materials import PAINT_COLOURS
from aeroscene.solids.shapes.primitive import Part, block, cylinder, hull
from aeroscene.solids.shapes.solids import paint, prism

_ROWING_M = 5.5
"""Length up to which a boat may be a rowing boat."""
_MAST_PER_LENGTH = 0.6
"""Ratio of height to length from which a boat has a mast."""


def boat(look: Look) -> list[Part]:
    """An open rowing boat, a motor boat with a cabin, or a sailing boat with its mast.

    Reads the attributes `form` and `colour`.
    """
    x, _, z = look.size_m
    fitting = ("motor", "rowing") if x <= _ROWING_M else ("motor",)
    if z >= _MAST_PER_LENGTH * x:
        fitting = ("sailing",)
    form = look.choice("form", FORMS["boat"], fitting)
    colour = "paint_" + look.choice("colour", PAINT_COLOURS)
    if form == "rowing":
        return _rowing(look, colour)
    return _motor(look, colour) if form == "motor" else _sailing(look, colour)


def _keel(x: float, y: float, rise: float, material: str) -> Part:
    """A pointed hull that widens upwards."""
    vertices: list[Vector3] = []
    # Two rings, at the gunwale and at the keel: height, share of the beam, and place of the bow.
    for height, beam, bow in ((rise, 1.0, 0.5), (0.0, 0.55, 0.36)):
        for along, share in ((-0.5, 0.8), (0.05, 1.0), (0.3, 0.72)):
            vertices += [(along * x, side * share * beam * y / 2, height) for side in (-1, 1)]
        vertices.append((bow * x, 0.0, height))
    return hull(vertices, material)


def _rowing(look: Look, colour: str) -> list[Part]:
    x, y, z = look.size_m
    # The floor and the thwarts lie just above the hull, which is solid: a convex collider has no
    # inside.
    rise = min(z, 0.75)
    parts = [_keel(x, y, rise - 0.03, colour)]
    parts.append(paint((-0.44 * x, 0.26 * x), 0.62 * y, (rise - 0.03, rise - 0.02), "wood"))
    for at in (-0.3, -0.04, 0.2):
        thwart = (at * x - 0.13, at * x + 0.13)
        parts.append(block(thwart, 0.7 * y, (rise - 0.03, rise), "pale_wood"))
    return parts


def _motor(look: Look, colour: str) -> list[Part]:
    x, y, z = look.size_m
    rise = min(0.42 * z, 1.3)
    top = min(z, rise + 2.1)
    cabin = [(-0.2 * x, rise), (-0.2 * x, top - 0.08), (0.08 * x, top - 0.08), (0.2 * x, rise)]
    deck = paint((-0.47 * x, -0.2 * x), 0.66 * y, (rise, rise + 0.01), "wood")
    return [
        _keel(x, y, rise, "plastic_white"),
        prism(cabin, 0.64 * y, "dark_glass", lean_m=0.06 * y),
        block((-0.22 * x, 0.1 * x), 0.6 * y, (top - 0.09, top), colour),
        deck,
        block((-x / 2, -0.47 * x), 0.3 * y, (0.5 * rise, 1.15 * rise), "plastic_black"),
    ]


def _sailing(look: Look, colour: str) -> list[Part]:
    x, y, z = look.size_m
    rise = min(0.3 * z, 0.9)
    foot = 0.1 * x
    main = [(-0.4 * x, 1.35 * rise), (foot - 0.05, 1.35 * rise), (foot - 0.05, 0.96 * z)]
    return [
        _keel(x, y, rise, colour),
        block((-0.16 * x, 0.24 * x), 0.5 * y, (rise, 1.3 * rise), "plastic_white"),
        cylinder((foot, 0, (rise + z) / 2), 0.1, z - rise, "metal"),
        prism(main, 0.06, "plaster_white"),
        block((-0.42 * x, foot), 0.1, (1.22 * rise, 1.35 * rise), "metal"),
        paint((-0.46 * x, -0.18 * x), 0.6 * y, (rise, rise + 0.01), "pale_wood"),
    ]
