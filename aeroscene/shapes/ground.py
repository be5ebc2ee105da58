"""What lies on the ground: roads and their paint, lawns, decks, ponds, fences, canopies."""

from __future__ import annotations

from aeroscene.scene import Vector3
from aeroscene.shapes.look import Look
from aeroscene.shapes.materials import PAINT_COLOURS
from aeroscene.shapes.primitive import Interval, Part, block, centred, cylinder, hull

PAINT_M = 0.005
"""Thickness of paint on a road."""
_DASH_PERIOD_M = 5.0
BAY_WIDTH_M = 2.5
"""Width of one parking space."""


def road(look: Look) -> list[Part]:
    """A carriageway along x, dashed in the middle, with a zebra crossing where asked."""
    x, y, z = look.size_m
    parts = [block(centred(x), centred(y), (0, z), "asphalt")]
    paint = (z, z + PAINT_M)
    n_dashes = int((x - 2.0) // _DASH_PERIOD_M)
    end = look.number("zebra_end", 0.0)
    for index in range(n_dashes):
        start = -_DASH_PERIOD_M * n_dashes / 2 + _DASH_PERIOD_M * index + 1.5
        is_crossing = end != 0 and end * (start + 1) > x / 2 - 5
        if not is_crossing:
            dash = (start, start + 2)
            parts.append(block(dash, centred(0.14), paint, "marking_white", collides=False))
    return parts + (_zebra(x, y, paint, end) if end else [])


def _zebra(x: float, y: float, paint: Interval, end: float) -> list[Part]:
    sign = 1 if end > 0 else -1
    near, far = sorted((sign * (x / 2 - 0.8), sign * (x / 2 - 3.3)))
    count = int((y - 0.6) // 1.0)
    stripes = [-count / 2 + index + 0.25 for index in range(count)]
    return [
        block((near, far), (low, low + 0.5), paint, "marking_white", collides=False)
        for low in stripes
    ]


def parking_lot(look: Look) -> list[Part]:
    """Asphalt with bays for cars along both long (x) sides, cars heading along y."""
    x, y, z = look.size_m
    parts = [block(centred(x), centred(y), (0, z), "asphalt")]
    n_bays = int((x - 0.1) // BAY_WIDTH_M)
    rows = look.number("rows", 2 if y > 12 else 1)
    for row in range(round(rows)):
        sign = 1 if row == 0 else -1
        for index in range(n_bays + 1):
            at = -n_bays * BAY_WIDTH_M / 2 + index * BAY_WIDTH_M
            ends = sorted((sign * (y / 2 - 0.2), sign * (y / 2 - 5.0)))
            parts.append(
                block(
                    (at - 0.06, at + 0.06),
                    (ends[0], ends[1]),
                    (z, z + PAINT_M),
                    "marking_white",
                    collides=False,
                )
            )
    return parts


def sidewalk(look: Look) -> list[Part]:
    """A raised strip of paving."""
    x, y, z = look.size_m
    material = look.choice("paving", ("paving",))
    return [block(centred(x), centred(y), (0, z), material)]


def plaza(look: Look) -> list[Part]:
    """A paved square with a border of another colour."""
    x, y, z = look.size_m
    parts = [block(centred(x), centred(y), (0, z), "red_paving")]
    for sign in (-1, 1):
        edge = sorted((sign * x / 2, sign * (x / 2 - 0.8)))
        parts.append(
            block((edge[0], edge[1]), centred(y), (z, z + PAINT_M), "concrete", collides=False)
        )
    return parts


def lawn(look: Look) -> list[Part]:
    """Grass."""
    x, y, z = look.size_m
    return [block(centred(x), centred(y), (0, z), "grass")]


def water(look: Look) -> list[Part]:
    """A basin: a rim of stone around water."""
    x, y, z = look.size_m
    rim = 0.35
    parts = [block(centred(x - 2 * rim), centred(y - 2 * rim), (0, 0.6 * z), "water")]
    for sign in (-1, 1):
        ends = sorted((sign * x / 2, sign * (x / 2 - rim)))
        sides = sorted((sign * y / 2, sign * (y / 2 - rim)))
        parts.append(block((ends[0], ends[1]), centred(y), (0, z), "stone"))
        parts.append(block(centred(x - 2 * rim), (sides[0], sides[1]), (0, z), "stone"))
    return parts


def deck(look: Look) -> list[Part]:
    """A wooden platform with a dark plinth."""
    x, y, z = look.size_m
    top = 0.1 if z > 0.2 else 0.5 * z
    return [
        block(centred(x - 0.3), centred(y - 0.3), (0, z - top), "dark_wood"),
        block(centred(x), centred(y), (z - top, z), "pale_wood"),
    ]


def stairs(look: Look) -> list[Part]:
    """Steps that rise towards +x."""
    x, y, z = look.size_m
    count = max(2, min(8, round(z / 0.25)))
    return [
        block(
            (-x / 2 + index * x / count, x / 2),
            centred(y),
            (0, (index + 1) * z / count),
            "concrete",
        )
        for index in range(count)
    ]


def fence(look: Look) -> list[Part]:
    """A barrier along y: hedge, boards or rails between posts."""
    x, y, z = look.size_m
    form = look.choice("form", ("hedge", "boards", "rails"))
    if form == "hedge":
        return [block(centred(x), centred(y), (0, z), "hedge")]
    posts = max(2, round(y / 3.0) + 1)
    material = "wood" if form == "boards" else "dark_metal"
    thick = min(x, 0.1)
    parts = [
        block(
            centred(thick),
            centred_at(-y / 2 + 0.05 + index * (y - 0.1) / (posts - 1), 0.1),
            (0, z),
            "dark_wood" if form == "boards" else "dark_metal",
            collides=form != "boards",
        )
        for index in range(posts)
    ]
    if form == "boards":
        return [*parts, block(centred(0.6 * thick), centred(y), (0.08, z - 0.06), material)]
    rails = [(0.12, 0.2), (0.5 * z, 0.5 * z + 0.06), (z - 0.08, z - 0.02)]
    return [*parts, *(block(centred(0.5 * thick), centred(y), rail, material) for rail in rails)]


def centred_at(middle: float, length: float) -> tuple[float, float]:
    """The interval of a length about a point."""
    return (middle - length / 2, middle + length / 2)


def canopy(look: Look) -> list[Part]:
    """A roof on four posts, open on every side."""
    x, y, z = look.size_m
    paint = "paint_" + look.choice("colour", PAINT_COLOURS)
    parts = [
        block(centred(x), centred(y), (z - 0.25, z - 0.04), paint),
        block(centred(x - 0.1), centred(y - 0.1), (z - 0.04, z), "plastic_white"),
    ]
    reach_x, reach_y = x / 2 - 0.25, y / 2 - 0.25
    for sx in (-1, 1):
        for sy in (-1, 1):
            centre = (sx * reach_x, sy * reach_y, (z - 0.25) / 2)
            parts.append(cylinder(centre, 0.16, z - 0.25, "metal"))
    return parts


def bridge(look: Look) -> list[Part]:
    """A footbridge along x: deck, railings and a pier at each end."""
    x, y, z = look.size_m
    rail = 1.1
    top = z - rail
    parts = [block(centred(x), centred(y), (top - 0.35, top), "concrete")]
    for sign in (-1, 1):
        side = sorted((sign * y / 2, sign * (y / 2 - 0.08)))
        parts.append(block(centred(x), (side[0], side[1]), (z - 0.1, z), "dark_metal"))
        parts.append(block(centred(x), (side[0], side[1]), (top, top + 0.5), "glass"))
        pier = sorted((sign * x / 2, sign * (x / 2 - 0.8)))
        parts.append(block((pier[0], pier[1]), centred(0.7 * y), (0, top - 0.35), "concrete"))
    return parts


def terrain(look: Look) -> list[Part]:
    """Raised ground: a terrace, or a ramp that rises from nothing at -x to its height at +x."""
    x, y, z = look.size_m
    material = look.choice("finish", ("grass", "paving", "asphalt", "gravel", "concrete"))
    if look.choice("form", ("terrace", "ramp")) == "terrace":
        return [block(centred(x), centred(y), (0, z), material)]
    low, high = centred(x)
    foot: list[Vector3] = [(low, side, 0.0) for side in centred(y)]
    back: list[Vector3] = [(high, side, height) for side in centred(y) for height in (0.0, z)]
    return [hull([*foot, *back], material)]
