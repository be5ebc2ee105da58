"""Trees, bushes and plants."""

from __future__ import annotations

from aeroscene.shapes.look import Look
from aeroscene.shapes.primitive import Part, block, centred, cylinder, ellipsoid

LEAVES = ("leaves", "leaves_dark", "leaves_autumn")


def tree(look: Look) -> list[Part]:
    """A trunk under a crown: round, spreading or conical."""
    x, y, z = look.size_m
    form = look.choice("form", ("round", "spreading", "conical"))
    leaves = look.choice("leaves", LEAVES)
    trunk = max(0.16, min(0.5, 0.035 * z))
    base = min(0.32 * z, 2.6)
    parts = [cylinder((0, 0, (base + 0.35 * z) / 2), trunk, base + 0.35 * z, "bark")]
    if form == "conical":
        rise = z - base
        for reach, low, high in ((1.0, 0.0, 0.55), (0.73, 0.3, 0.8), (0.46, 0.6, 1.0)):
            span = (base + low * rise, base + high * rise)
            parts.append(ellipsoid(centred(x * reach), centred(y * reach), span, "leaves_dark"))
        return parts
    if form == "spreading":
        mid = base + 0.62 * (z - base)
        parts += [
            ellipsoid((-x / 2, 0.2 * x), (-0.42 * y, 0.36 * y), (base, mid + 0.1 * z), leaves),
            ellipsoid(
                (-0.2 * x, x / 2), (-0.34 * y, 0.5 * y), (base + 0.05 * z, mid + 0.14 * z), leaves
            ),
            ellipsoid((-0.32 * x, 0.32 * x), (-y / 2, 0.3 * y), (base + 0.15 * z, z), leaves),
        ]
        return parts
    parts.append(ellipsoid(centred(x), centred(y), (base, z - 0.1 * (z - base)), leaves))
    parts.append(
        ellipsoid(centred(0.68 * x), centred(0.68 * y), (base + 0.42 * (z - base), z), leaves)
    )
    return parts


def bush(look: Look) -> list[Part]:
    """Two overlapping clumps."""
    x, y, z = look.size_m
    leaves = look.choice("leaves", LEAVES[:2])
    return [
        ellipsoid((-x / 2, 0.3 * x), (-y / 2, 0.4 * y), (0, 0.9 * z), leaves),
        ellipsoid((-0.2 * x, x / 2), (-0.3 * y, y / 2), (0, z), leaves),
    ]


def planter(look: Look) -> list[Part]:
    """A trough of concrete, soil and a low shrub."""
    x, y, z = look.size_m
    rim = min(0.5, 0.6 * z)
    return [
        block(centred(x), centred(y), (0, rim), "terracotta" if look.variant % 2 else "concrete"),
        block(centred(x - 0.1), centred(y - 0.1), (rim, rim + 0.02), "soil", collides=False),
        ellipsoid(centred(0.92 * x), centred(0.92 * y), (rim - 0.2 * z, z), "leaves"),
    ]


def plant(look: Look) -> list[Part]:
    """A house plant in a pot."""
    x, y, z = look.size_m
    pot = 0.3 * z
    return [
        cylinder((0, 0, pot / 2), 0.5 * min(x, y), pot, "terracotta"),
        cylinder((0, 0, 0.45 * z), 0.05, 0.4 * z, "bark", collides=False),
        ellipsoid(centred(x), centred(y), (0.4 * z, z), "leaves"),
    ]
