"""Trees, bushes and plants. Crowns collide as they look, because drones do hit them."""

from __future__ import annotations

from math import cos, sin

from aeroscene.solids.shapes.forms import FORMS
from aeroscene.solids.shapes.look import Look
from aeroscene.solids.shapes.primitive import Interval, Part, block, cylinder, ellipsoid
from aeroscene.solids.shapes.solids import about, cone, paint, shifted

LEAVES = ("leaves", "leaves_dark", "leaves_autumn")
_CLEAR_TRUNK_M = 2.6
"""Height under the crown of a tall street tree: people walk there."""


def tree(look: Look) -> list[Part]:
    """A trunk under a crown; a birch is slim, pale and sparse.

    Reads the attributes `form` and `leaves`.
    """
    form = look.choice("form", FORMS["tree"])
    z = look.size_m[2]
    base = min(0.32 * z, _CLEAR_TRUNK_M)
    crown = {
        "round": _round_crown,
        "spreading": _spreading_crown,
        "conical": _conical_crown,
        "poplar": _poplar_crown,
        "birch": _birch_crown,
    }[form](look, base)
    thick = max(0.14, min(0.5, 0.034 * z)) * (0.85 if form == "birch" else 1.0)
    # At most 40% of the box, for saplings that are high and narrow.
    thick = min(thick, 0.4 * min(look.size_m[:2]))
    # The trunk ends inside the crown; a birch shows its trunk almost to the top.
    rise = 0.9 * z if form == "birch" else base + 0.35 * z
    bark = "birch_bark" if form == "birch" else "bark"
    return [cylinder((0, 0, rise / 2), thick, rise, bark), *crown]


def _leaves(look: Look) -> str:
    """Material of the leaves; green is drawn three times out of four."""
    return look.choice("leaves", LEAVES, ("leaves", "leaves", "leaves_dark", "leaves_autumn"))


def _round_crown(look: Look, base: float) -> list[Part]:
    x, y, z = look.size_m
    leaves, rise = _leaves(look), z - base
    low, shoulder = base + 0.34 * rise, z - 0.07 * rise
    return [
        ellipsoid(x, y, (base, base + 0.84 * rise), leaves),
        ellipsoid((-0.42 * x, 0.22 * x), (-0.3 * y, 0.4 * y), (low, z), leaves),
        ellipsoid((-0.16 * x, 0.44 * x), (-0.44 * y, 0.2 * y), (low, shoulder), leaves),
    ]


def _spreading_crown(look: Look, base: float) -> list[Part]:
    """Wide and flat: three lobes, the middle one highest."""
    x, y, z = look.size_m
    leaves, rise = _leaves(look), z - base
    low = base + 0.12 * rise
    return [
        ellipsoid((-x / 2, 0.14 * x), (-0.44 * y, 0.3 * y), (base, low + 0.62 * rise), leaves),
        ellipsoid((-0.12 * x, x / 2), (-0.3 * y, y / 2), (low, low + 0.68 * rise), leaves),
        ellipsoid((-0.34 * x, 0.34 * x), (-y / 2, 0.26 * y), (low + 0.22 * rise, z), leaves),
    ]


def _conical_crown(look: Look, base: float) -> list[Part]:
    """A spruce: three skirts, from low on."""
    x, y, z = look.size_m
    # Spruces have branches from low on.
    base = min(base, 0.14 * z)
    rise = z - base
    leaves = look.choice("leaves", ("leaves_dark",))
    return [
        cone((reach * x, reach * y), (tip * x, tip * y), span, leaves)
        for reach, tip, span in (
            (1.0, 0.42, (base, base + 0.42 * rise)),
            (0.78, 0.26, (base + 0.34 * rise, base + 0.72 * rise)),
            (0.54, 0.0, (base + 0.62 * rise, z)),
        )
    ]


def _poplar_crown(look: Look, base: float) -> list[Part]:
    """A tall spindle."""
    x, y, z = look.size_m
    base = min(base, 0.12 * z)
    slim_x, slim_y = min(x, 0.34 * z), min(y, 0.34 * z)
    leaves = _leaves(look)
    return [
        ellipsoid(slim_x, slim_y, (base, base + 0.66 * (z - base)), leaves),
        ellipsoid(0.76 * slim_x, 0.76 * slim_y, (base + 0.2 * z, z), leaves),
    ]


def _birch_crown(look: Look, base: float) -> list[Part]:
    """Loose clumps about a trunk that shows below them and between them."""
    x, y, z = look.size_m
    rise = z - base
    leaves = look.choice(
        "leaves", (*LEAVES, "leaves_light"), ("leaves_light", "leaves_light", "leaves")
    )
    return [
        ellipsoid((-x / 2, 0.3 * x), (-0.36 * y, 0.36 * y), (base, base + 0.56 * rise), leaves),
        ellipsoid(
            (-0.22 * x, x / 2), (-y / 2, 0.28 * y), (base + 0.2 * rise, base + 0.76 * rise), leaves
        ),
        ellipsoid((-0.32 * x, 0.3 * x), (-0.26 * y, 0.36 * y), (base + 0.4 * rise, z), leaves),
    ]


def bush(look: Look) -> list[Part]:
    """Clumps, a clipped ball on a stem, or a shrub in flower.

    Reads the attributes `form` and `leaves`.
    """
    x, y, z = look.size_m
    form = look.choice("form", FORMS["bush"])
    leaves = look.choice("leaves", LEAVES[:2])
    if form == "ball":
        return [
            cylinder((0, 0, 0.15 * z), 0.1 * min(x, y), 0.3 * z, "bark"),
            ellipsoid(x, y, (0.12 * z, z), "hedge"),
        ]
    clumps = [
        ellipsoid((-x / 2, 0.3 * x), (-y / 2, 0.4 * y), (0, 0.86 * z), leaves),
        ellipsoid((-0.2 * x, x / 2), (-0.3 * y, y / 2), (0, 0.94 * z), leaves),
    ]
    if form == "blossom":
        clumps.append(ellipsoid(0.66 * x, 0.66 * y, (0.4 * z, z), "blossom"))
    return clumps


def planter(look: Look) -> list[Part]:
    """A trough or a pot with a shrub, or a bed of flowers.

    Reads the attribute `form`.
    """
    x, y, z = look.size_m
    form = look.choice("form", FORMS["planter"])
    # Flowers stand low, and a shrub takes half of the height.
    rim = min(0.5, 0.6 * z) if form != "flowers" else max(0.6 * z, z - 0.35)
    soil = paint(x - 0.1, y - 0.1, (rim, rim + 0.02), "soil")
    if form == "pot":
        pot = cone((0.72 * x, 0.72 * y), (x, y), (0, rim), "terracotta")
        crown = ellipsoid(0.9 * x, 0.9 * y, (rim - 0.1 * z, z), "hedge")
        return [pot, cylinder((0, 0, 0.5 * (rim + z)), 0.06, z - rim - 0.05, "bark"), crown]
    if form == "trough":
        trough = block(x, y, (0, rim), "concrete")
        shrub = ellipsoid(0.92 * x, 0.92 * y, (rim - 0.2 * z, z), "leaves")
        return [trough, soil, shrub]
    rows = max(2, min(4, round(y / 0.5)))
    clumps = [
        ellipsoid(0.84 * x, about(-y / 2 + (i + 0.5) * y / rows, 0.9 * y / rows), rise, name)
        for i, (name, rise) in enumerate(_flowers(look, rows, rim, z))
    ]
    return [block(x, y, (0, rim), "dark_wood"), soil, *clumps]


def _flowers(look: Look, rows: int, rim: float, z: float) -> list[tuple[str, Interval]]:
    """Colour and rise of each clump of a bed; every other clump is a little lower."""
    names = ("blossom", "blossom_yellow", "leaves_light", "blossom_red")
    return [
        (names[(index + look.variant) % 4], (rim - 0.1 * z, z if index % 2 else 0.9 * z))
        for index in range(rows)
    ]


def plant(look: Look) -> list[Part]:
    """A house plant in a pot: bushy, a palm, or upright blades.

    Reads the attributes `form` and `pot`.
    """
    x, y, z = look.size_m
    form = look.choice("form", FORMS["plant"])
    rim, wide = 0.28 * z, min(x, y)
    glaze = look.choice("pot", ("terracotta", "ceramic", "paint_blue", "dark_concrete"))
    pot = cylinder((0, 0, rim / 2), 0.52 * wide, rim, glaze)
    if form == "bushy":
        return [
            pot,
            ellipsoid((-x / 2, 0.36 * x), (-y / 2, 0.4 * y), (0.9 * rim, 0.82 * z), "leaves"),
            ellipsoid((-0.34 * x, x / 2), (-0.36 * y, y / 2), (0.45 * z, z), "leaves_light"),
        ]
    if form == "palm":
        stem = cylinder((0, 0, (rim + 0.8 * z) / 2), 0.05 * wide + 0.01, 0.8 * z - rim, "bark")
        fan = (0.62 * z, z - 0.02 * z)
        return [
            pot,
            stem,
            # Three crossed fronds, 60 degrees apart, make a star of six.
            _frond(0.94 * wide, 0.3 * wide, fan, 0.0),
            _frond(0.94 * wide, 0.3 * wide, fan, 1.05),
            _frond(0.94 * wide, 0.3 * wide, fan, 2.1),
        ]
    blades = ((-0.16, 0.0, 1.0), (0.14, 0.1, 0.84), (0.0, -0.16, 0.72))
    leaf = 0.16 * wide
    return [
        pot,
        *(
            shifted(cone(leaf, 0, (0.8 * rim, rise * z), "leaves"), u * wide, v * wide)
            for u, v, rise in blades
        ),
    ]


def _frond(length: float, width: float, z: Interval, yaw: float) -> Part:
    """A flat ellipsoid about the stem, turned about the vertical."""
    flat = ellipsoid(length, width, z, "leaves")
    return Part(
        kind=flat.kind,
        position_m=flat.position_m,
        quat_wxyz=(cos(yaw / 2), 0.0, 0.0, sin(yaw / 2)),
        size_m=flat.size_m,
        material=flat.material,
    )
