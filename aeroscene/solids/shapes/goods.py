"""Loose goods of yards and halls, and the pads that drones land on."""

from __future__ import annotations

from aeroscene.solids.shapes.forms import FORMS
from aeroscene.solids.shapes.look import Look
from aeroscene.solids.shapes.materials import PAINT_COLOURS
from aeroscene.solids.shapes.primitive import Interval, Part, block
from aeroscene.solids.shapes.solids import about, disc, inwards, paint

PALLET_M = 0.144
"""Height of a bare pallet."""


def _paint_colour(look: Look) -> str:
    return "paint_" + look.choice("colour", PAINT_COLOURS)


def crate(look: Look) -> list[Part]:
    """A crate of boards, a plastic one in colour, or a chest with metal bands.

    Reads the attributes `form` and, of a plastic crate, `colour`.
    """
    x, y, z = look.size_m
    form = look.choice("form", FORMS["crate"])
    if form == "plastic":
        colour = _paint_colour(look)
        return [
            block(0.92 * x, 0.92 * y, (0, z - 0.03), colour),
            block(x, y, (0.8 * z, z), colour),
            paint(0.86 * x, 0.86 * y, (z, z + 0.004), "plastic_black"),
        ]
    wood = "pale_wood" if form == "boards" else "dark_wood"
    trim = "dark_wood" if form == "boards" else "metal"
    rails = [(0.06 * z, 0.18 * z), (0.8 * z, 0.92 * z)]
    parts = [block(x - 0.03, y - 0.03, (0, z), wood)]
    if form == "boards":
        return parts + [paint(x, y, rail, trim) for rail in rails]
    bands = [about(sign * 0.28 * y, 0.06) for sign in (-1, 1)]
    return parts + [paint(x, band, (0, z + 0.006), trim) for band in bands]


def pallet(look: Look) -> list[Part]:
    """A pallet; in a taller box it carries boxes, sacks or bricks.

    Reads the attribute `form`.
    """
    x, y, z = look.size_m
    deck = min(z, PALLET_M)
    is_loaded = z > deck + 0.1
    form = look.choice("form", FORMS["pallet"], FORMS["pallet"][1:]) if is_loaded else "bare"
    parts = [
        block(x, y, (0.72 * deck, deck), "wood"),
        *(
            block(x, about(at * (y - 0.12) / 2, 0.12), (0, 0.72 * deck), "dark_wood")
            for at in (-1, 0, 1)
        ),
    ]
    if form == "boxes":
        high = z - deck
        split = deck + 0.52 * high
        return [
            *parts,
            block(0.96 * x, 0.96 * y, (deck, split), "cardboard"),
            # The upper layer is a little smaller, so that the two cartons show.
            block(0.94 * x, 0.92 * y, (split, z), "cardboard"),
            paint(0.97 * x, 0.1, (deck, split), "paint_blue"),
        ]
    if form == "sacks":
        return [*parts, *_sacks(x, y, (deck, z))]
    if form == "bricks":
        bands = [about(sign * 0.25 * y, 0.04) for sign in (-1, 1)]
        return [
            *parts,
            block(0.9 * x, 0.9 * y, (deck, z - 0.005), "brick"),
            *(paint(0.91 * x, band, (deck, z), "plastic_black") for band in bands),
        ]
    return parts


def _sacks(x: float, y: float, z: Interval) -> list[Part]:
    """Layers of two sacks each; the top is level, so that a drone can land on it."""
    layers = max(1, min(3, round((z[1] - z[0]) / 0.3)))
    rise = (z[1] - z[0]) / layers
    return [
        block(
            (0.94 - 0.04 * layer) * x,
            about(side * 0.235 * y, 0.45 * y),
            (z[0] + layer * rise, z[0] + (layer + 1) * rise - 0.01),
            "fabric_beige",
        )
        for layer in range(layers)
        for side in (-1, 1)
    ]


def landing_pad(look: Look) -> list[Part]:
    """A mat with a ring and a letter, with rings like a target, or with a cross and corners.

    Reads the attributes `form` and `mat`.
    """
    x, y, z = look.size_m
    form, side = look.choice("form", FORMS["landing_pad"]), min(x, y)
    ground = look.choice("mat", ("dark_concrete", "rubber", "concrete"))
    mat = block(x, y, (0, z), ground)
    if form == "rings":
        # From the widest to the narrowest, because each is painted over the last.
        widths = (
            (0.94, "marking_white"),
            (0.78, "light_red"),
            (0.54, "marking_white"),
            (0.3, "light_red"),
        )
        return [mat, *(_disc(share * side, z, i, name) for i, (share, name) in enumerate(widths))]
    if form == "cross":
        flat = (z, z + 0.004)
        bars = [
            paint(0.86 * side, 0.12 * side, flat, "marking_white"),
            paint(0.12 * side, 0.86 * side, flat, "marking_white"),
        ]
        corners = [
            paint(
                inwards(sx, x / 2, 0.2 * side),
                inwards(sy, y / 2, 0.2 * side),
                flat,
                "marking_yellow",
            )
            for sx in (-1, 1)
            for sy in (-1, 1)
        ]
        return [mat, *bars, *corners]
    # Above the two discs of the ring.
    flat = (z + 0.004, z + 0.006)
    strokes = [
        paint(0.46 * side, about(sign * 0.15 * side, 0.08 * side), flat, "marking_white")
        for sign in (-1, 1)
    ]
    middle = paint(0.09 * side, 0.24 * side, flat, "marking_white")
    ring = _disc(0.88 * side, z, 0, "marking_yellow")
    return [mat, ring, _disc(0.78 * side, z, 1, ground), *strokes, middle]


def _disc(wide: float, z: float, layer: int, material: str) -> Part:
    """One coat of paint in the middle, above the coats of lower layers."""
    return disc((0, 0, z + 0.001 + 0.0015 * layer), wide, 0.0015, material)
