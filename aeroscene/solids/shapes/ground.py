"""Surfaces that lie on the ground, and the paint on them. Paint touches nothing."""

from __future__ import annotations

from aeroscene.scene import Vector3
from aeroscene.solids.shapes.forms import FORMS
from aeroscene.solids.shapes.look import Look
from aeroscene.solids.shapes.primitive import Interval, Part, block, hull
from aeroscene.solids.shapes.solids import PAINT_M, about, disc, inwards, paint

BAY_WIDTH_M = 2.5
"""Width of one parking space."""
BAY_DEPTH_M = 5.0
_DASH_PERIOD_M = 6.0
_DASH_M = 2.5
# Bounds the parts of a long road; its dashes then lie farther apart.
_MOST_DASHES = 12
_TWO_LANES_M = 5.5
"""Width from which a road has a line in the middle."""


def _slab(look: Look, material: str) -> Part:
    x, y, z = look.size_m
    return block(x, y, (0, z), material)


def _coat(z: float) -> Interval:
    return (z, z + PAINT_M)


def road(look: Look) -> list[Part]:
    """A carriageway along x: dashes, edge lines or arrows, and a zebra crossing if asked for.

    Reads the attributes `form` and `zebra_end` (1 or -1: crossing at that end of x).
    """
    x, y, z = look.size_m
    form, end = look.choice("form", FORMS["road"]), look.number("zebra_end", 0.0)
    parts = [_slab(look, "asphalt")]
    if y >= _TWO_LANES_M:
        parts += _dashes(x, z, end)
    if form == "edged" or y < _TWO_LANES_M:
        parts += [
            paint(x, about(sign * (y / 2 - 0.25), 0.12), _coat(z), "marking_white")
            for sign in (-1, 1)
        ]
    # Arrows need a straight of 24 m; traffic keeps to the right, so each points along its lane.
    if form == "arrows" and x > 24 and y >= _TWO_LANES_M:
        for sign in (-1, 1):
            parts += _arrow((sign * (x / 2 - 9.0), -sign * y / 4), sign, z)
    return parts + (_zebra(x, y, z, end) if end else [])


def _dashes(x: float, z: float, zebra_end: float) -> list[Part]:
    """Dashes of the middle line, which ends before a crossing."""
    count = min(_MOST_DASHES, int((x - 2.0) // _DASH_PERIOD_M))
    period = (x - 2.0) / max(1, count)
    middles = [(index - (count - 1) / 2) * period for index in range(count)]
    return [
        paint(about(at, _DASH_M), 0.14, _coat(z), "marking_white")
        for at in middles
        # A crossing takes the last 3.3 m; dashes keep half their length from it.
        if zebra_end == 0 or zebra_end * at < x / 2 - 5.5
    ]


def _arrow(tip: tuple[float, float], heading: int, z: float) -> list[Part]:
    """A straight arrow along x that ends at `tip`, pointing to `heading` times x."""
    along, across = tip
    neck = along - heading * 1.2
    head: list[Vector3] = [
        (at, across + side, height)
        for at, side in ((along, 0.0), (neck, -0.42), (neck, 0.42))
        for height in _coat(z)
    ]
    shaft = sorted((neck, neck - heading * 2.0))
    return [
        hull(head, "marking_white", collides=False),
        paint((shaft[0], shaft[1]), about(across, 0.18), _coat(z), "marking_white"),
    ]


def _zebra(x: float, y: float, z: float, end: float) -> list[Part]:
    stripe = inwards(1 if end > 0 else -1, x / 2 - 0.8, 2.5)
    count = int((y - 0.6) // 1.0)
    return [
        paint(stripe, about(index - (count - 1) / 2, 0.5), _coat(z), "marking_white")
        for index in range(count)
    ]


def parking_lot(look: Look) -> list[Part]:
    """Asphalt with bays for cars along the long (x) sides, cars heading along y.

    Reads the attributes `form` and `rows` (1 or 2).
    """
    x, y, z = look.size_m
    form = look.choice("form", FORMS["parking_lot"])
    n_bays = int((x - 0.1) // BAY_WIDTH_M)
    deep = min(BAY_DEPTH_M, y - 0.4)
    # A single row lies at +y; narrow lots have no room for a second one.
    signs = (1, -1)[: round(look.number("rows", 2 if y > 12 else 1))]
    parts = [_slab(look, "asphalt")]
    for sign in signs:
        row = inwards(sign, y / 2 - 0.2, deep - 0.2)
        parts += [
            paint(about((index - n_bays / 2) * BAY_WIDTH_M, 0.12), row, _coat(z), "marking_white")
            for index in range(n_bays + 1)
        ]
        if form == "marked" and n_bays > 2:
            first = about((0.5 - n_bays / 2) * BAY_WIDTH_M, BAY_WIDTH_M - 0.3)
            parts.append(
                paint(first, inwards(sign, y / 2 - 0.4, deep - 0.6), _coat(z), "paint_blue")
            )
    if form == "arrows" and len(signs) == 2 and x > 12:
        for sign in (-1, 1):
            parts += _arrow((sign * (0.25 * x + 1.6), -sign * 1.2), sign, z)
    return parts


def sidewalk(look: Look) -> list[Part]:
    """Raised paving with a kerb along the street (-y); bands or a tactile strip on it.

    Reads the attributes `form` and `paving`.
    """
    x, y, z = look.size_m
    form = look.choice("form", FORMS["sidewalk"])
    paving = look.choice("paving", ("paving",))
    # No room for a kerb.
    if y < 0.6:
        return [_slab(look, paving)]
    kerb = -y / 2 + 0.18
    parts = [block(x, (kerb, y / 2), (0, z), paving), block(x, (-y / 2, kerb), (0, z), "concrete")]
    if form == "tactile":
        parts.append(paint(x, (kerb + 0.15, kerb + 0.45), _coat(z), "marking_yellow"))
    elif form == "banded":
        parts.append(paint(x, inwards(1, y / 2, 0.3 * y), _coat(z), "dark_concrete"))
    return parts


def plaza(look: Look) -> list[Part]:
    """Paving with a border, with bands across it, or with a cross and a disc in the middle.

    Reads the attributes `form` and `paving`.
    """
    x, y, z = look.size_m
    form = look.choice("form", FORMS["plaza"])
    base = look.choice("paving", ("red_paving", "paving"))
    trim = "concrete" if base == "red_paving" else "dark_concrete"
    parts = [_slab(look, base)]
    if form == "bands":
        count = max(2, min(7, int(x // 4)))
        parts += [
            paint(about((i - (count - 1) / 2) * x / count, 0.6), y, _coat(z), trim)
            for i in range(count)
        ]
    elif form == "cross":
        parts += [
            paint(x, 0.9, _coat(z), trim),
            paint(0.9, y, _coat(z), trim),
            # Both discs lie above the bars of the cross.
            disc((0, 0, z + 0.004), 0.4 * min(x, y), 0.008, trim),
            disc((0, 0, z + 0.006), 0.3 * min(x, y), 0.008, base),
        ]
    else:
        wide = min(0.8, 0.1 * min(x, y))
        for sign in (-1, 1):
            parts.append(paint(inwards(sign, x / 2, wide), y, _coat(z), trim))
            parts.append(paint(x - 2 * wide, inwards(sign, y / 2, wide), _coat(z), trim))
    return parts


def lawn(look: Look) -> list[Part]:
    """Grass; with a path along the middle, or with beds along two sides.

    Reads the attribute `form`.
    """
    x, y, z = look.size_m
    form = look.choice("form", FORMS["lawn"])
    parts = [_slab(look, "grass")]
    if form == "path" and min(x, y) > 4:
        parts.append(paint(x, min(1.4, 0.1 * y), _coat(z), "gravel"))
    elif form == "beds" and min(x, y) > 4:
        for sign in (-1, 1):
            bed = inwards(sign, y / 2 - 0.25, min(0.7, 0.08 * y))
            parts.append(paint(x - 1.0, bed, _coat(z), "soil"))
    return parts
