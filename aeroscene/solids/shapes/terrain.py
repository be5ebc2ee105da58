"""Ground that is not flat, and water."""

from __future__ import annotations

from math import cos, pi, radians, sin, tan

from aeroscene.scene import Vector3
from aeroscene.solids.shapes.forms import FORMS
from aeroscene.solids.shapes.look import Look
from aeroscene.solids.shapes.primitive import Part, block, centred, hull
from aeroscene.solids.shapes.solids import cone, disc, inwards

FINISHES = ("grass", "paving", "asphalt", "gravel", "concrete")
"""Covers of terrain: values of the attribute `finish`."""
_CRUST_M = 0.15
"""Thickness of a terrace's cover over its retaining walls."""
_MOUND_SIDE_RAD = radians(19.0)
"""Steepest side of a mound."""
_MOUND_SLOPE_SHARE = 0.8
"""Share of the distance to the middle that the sides may take."""
_MOUND_CORNERS = 12
_SHEET_M = 0.03
"""Height of a pond's water above its bed of grass."""
_POND_M = 15.0
"""Width from which water has banks of its own, and no rim unless its attribute says so."""


def terrain(look: Look) -> list[Part]:
    """Raised ground: a terrace, a low mound, or a ramp from nothing at -x to its height at +x.

    Reads the attributes `form`, `finish` and, of a terrace, `wall`.
    """
    form, finish = look.choice("form", FORMS["terrain"]), look.choice("finish", FINISHES)
    if form == "terrace":
        return _terrace(look, finish)
    return [_ramp(look, finish)] if form == "ramp" else [_mound(look, finish)]


def _terrace(look: Look, finish: str) -> list[Part]:
    x, y, z = look.size_m
    wall = look.choice("wall", ("stone", "brick", "dark_concrete"))
    # Low terraces and those walled with their own cover are one block.
    if z < 2 * _CRUST_M or wall == finish:
        return [block(x, y, (0, z), finish)]
    low = z - _CRUST_M
    return [block(x, y, (0, low), wall), block(x, y, (low, z), finish)]


def _ramp(look: Look, finish: str) -> Part:
    x, y, z = look.size_m
    low, high = centred(x)
    foot: list[Vector3] = [(low, side, 0.0) for side in centred(y)]
    back: list[Vector3] = [(high, side, height) for side in centred(y) for height in (0.0, z)]
    return hull([*foot, *back], finish)


def mound_top(size_m: Vector3) -> tuple[float, float, float]:
    """Extents along x and y of a mound's level top, and its height, m.

    A box that is too high for its width holds a mound that is lower than the box.
    """
    x, y, z = size_m
    # A polygon's sides lie further in than its corners: they are what is steepest.
    reach = min(x, y) / 2 * cos(pi / _MOUND_CORNERS)
    height = min(z, _MOUND_SLOPE_SHARE * reach * tan(_MOUND_SIDE_RAD))
    # The sides narrow both axes by the same share, hence one share for x and y.
    share = 1 - height / tan(_MOUND_SIDE_RAD) / reach
    return (share * x, share * y, height)


def _mound(look: Look, finish: str) -> Part:
    """Two rings of one shape: along the shorter axis the sides are steepest."""
    x, y, _ = look.size_m
    top_x, top_y, height = mound_top(look.size_m)
    return cone((x, y), (top_x, top_y), (0.0, height), finish, sides=_MOUND_CORNERS)


def _pond(look: Look) -> list[Part]:
    """Water with a shore that wanders, on a bed of grass that fills the box.

    The shore is a convex polygon of sixteen corners whose radii differ a little, so that no two
    ponds are alike; the variant decides how.
    """
    x, y, z = look.size_m
    level = 0.5 * z
    bed = level - min(_SHEET_M, 0.5 * level)
    parts = [block(x, y, (0, bed), "grass")]
    # Sixteen corners are smooth enough for a shore seen from a drone.
    shore: list[Vector3] = []
    for corner in range(16):
        angle = 2 * pi * corner / 16
        # One slow wave keeps the outline convex, which colliders need.
        reach = 0.46 + 0.04 * sin(2 * angle + look.variant)
        at = (reach * x * cos(angle), reach * y * sin(angle))
        shore += [(*at, bed), (*at, level)]
    return [*parts, hull(shore, "water")]


def water(look: Look) -> list[Part]:
    """A basin with a rim, bare or with water lilies; `open` is a sheet, `pond` a natural one.

    Reads the attributes `form` and `rim`.
    """
    x, y, z = look.size_m
    is_pond = max(x, y) <= _POND_M
    form = look.choice("form", FORMS["water"], ("basin", "planted") if is_pond else ("open",))
    if form == "pond":
        return _pond(look)
    if form == "open":
        return [block(x, y, (0, z), "water")]
    rim = min(0.35, 0.12 * min(x, y))
    stone = look.choice("rim", ("stone", "brick", "dark_wood"))
    level = 0.6 * z
    parts = [block(x - 2 * rim, y - 2 * rim, (0, level), "water")]
    for sign in (-1, 1):
        parts.append(block(inwards(sign, x / 2, rim), y, (0, z), stone))
        parts.append(block(x - 2 * rim, inwards(sign, y / 2, rim), (0, z), stone))
    if form == "planted":
        wide = min(0.9, 0.16 * min(x, y))
        for index, (u, v) in enumerate(((-0.3, 0.28), (-0.22, 0.2), (0.3, -0.26))):
            lily = (u * x, v * y, level + 0.005)
            name = "blossom" if index == 1 else "leaves"
            parts.append(disc(lily, wide, 0.01, name))
    return parts
