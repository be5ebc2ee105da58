"""Roofs, which lie on buildings: flat with a parapet, gable, hip, and one gentle plane."""

from __future__ import annotations

from math import radians, tan

from aeroscene.scene import Vector3
from aeroscene.solids.shapes.forms import FORMS
from aeroscene.solids.shapes.look import Look
from aeroscene.solids.shapes.materials import WALL_COLOURS
from aeroscene.solids.shapes.primitive import Part, block, centred, hull
from aeroscene.solids.shapes.solids import inwards, prism

ROOF_SLAB_M = 0.25
"""Height of a flat roof's deck above its underside; machines stand on it."""
PARAPET_M = 0.2
_TILES_M = 0.18
"""Thickness of a pitched roof's planes."""
_EAVES_M = 0.4
"""Overhang of a gable roof over the wall below."""
_SHED_EDGE_M = 0.2
_SHED_PITCH_RAD = radians(9.5)
_PITCHED_M = 1.2
"""Height up to which a roof is flat unless its attribute `form` differs."""


def roof(look: Look) -> list[Part]:
    """A flat roof, a gable with its ridge along x, a hip, or one plane that rises towards +x.

    Reads the attributes `form`, `cover` (of flat roofs and single planes), `tiles` and `colour` (of
    pitched ones).
    """
    z = look.size_m[2]
    drawn = ("gable", "hip") if z > _PITCHED_M else ("flat",)
    form = look.choice("form", FORMS["roof"], drawn)
    if form == "shed":
        return [_monopitch(look)]
    if form == "flat":
        return _flat(look)
    tiles = look.choice("tiles", ("roof_red", "roof_slate"))
    return _gable(look, tiles) if form == "gable" else [_hip(look, tiles)]


def _flat(look: Look) -> list[Part]:
    """A deck, and a parapet if the box is high enough."""
    x, y, z = look.size_m
    slab = min(ROOF_SLAB_M, z)
    # Roofing twice: it is drawn twice as often as each of the others.
    cover = look.choice("cover", ("roofing", "roofing", "gravel", "concrete"))
    parts = [block(x, y, (0, slab), cover)]
    if z <= slab + 0.05:
        return parts
    inner = y - 2 * PARAPET_M
    for sign in (-1, 1):
        parts.append(block(inwards(sign, x / 2, PARAPET_M), inner, (slab, z), "concrete"))
        parts.append(block(x, inwards(sign, y / 2, PARAPET_M), (slab, z), "concrete"))
    return parts


def _gable(look: Look, tiles: str) -> list[Part]:
    """Two planes on a triangular wall that stands back from the eaves."""
    x, y, z = look.size_m
    thick = min(_TILES_M, 0.3 * z)
    planes = [
        hull(
            [
                (end, across, height)
                for end in centred(x)
                for across, height in (
                    (0.0, z),
                    (0.0, z - thick),
                    (side * y / 2, thick),
                    (side * y / 2, 0.0),
                )
            ],
            tiles,
        )
        for side in (-1, 1)
    ]
    back = min(_EAVES_M, 0.1 * min(x, y))
    foot = y / 2 - back
    # The wall ends below the planes, at the height that they have above its foot.
    ridge = (z - thick) * foot / (y / 2)
    wall: list[Vector3] = [
        (end, across, height)
        for end in centred(x - 2 * back)
        for across, height in ((-foot, 0.0), (foot, 0.0), (0.0, ridge))
    ]
    plaster = "plaster_" + look.choice("colour", WALL_COLOURS)
    return [*planes, hull(wall, plaster)]


def _hip(look: Look, tiles: str) -> Part:
    x, y, z = look.size_m
    eaves = min(0.15, 0.2 * z)
    # The ridge is shorter than the roof by 0.7 of the short side, which gives the ends their slope.
    ridge = max(0.0, x / 2 - 0.35 * min(x, y))
    corners: list[Vector3] = [
        (sx * x / 2, sy * y / 2, h) for sx in (-1, 1) for sy in (-1, 1) for h in (0.0, eaves)
    ]
    return hull([*corners, (-ridge, 0.0, z), (ridge, 0.0, z)], tiles)


def _monopitch(look: Look) -> Part:
    """A plane gentle enough to land on, whatever the box's height."""
    x, y, z = look.size_m
    edge = min(_SHED_EDGE_M, 0.5 * z)
    low = max(edge, z - x * tan(_SHED_PITCH_RAD))
    cover = look.choice("cover", ("corrugated", "roofing"))
    profile = [(-x / 2, 0.0), (x / 2, 0.0), (x / 2, z), (-x / 2, low)]
    return prism(profile, y, cover)
