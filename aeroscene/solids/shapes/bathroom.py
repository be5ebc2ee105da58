"""Fittings of a bathroom; their back, at the wall, is -x."""

from __future__ import annotations

from aeroscene.solids.shapes.forms import FORMS
from aeroscene.solids.shapes.furniture import WOODS
from aeroscene.solids.shapes.look import Look
from aeroscene.solids.shapes.primitive import Interval, Part, block, cylinder
from aeroscene.solids.shapes.solids import about, cone, disc, inwards, legs, paint, shifted

_SEAT_M = 0.42
"""Height of a toilet's seat."""
_TAP_M = 0.12
"""Height of a tap above the rim of its basin."""
_USER_M = 0.75
"""Length of a basin for each person who washes at it."""
_TUB_M = 0.62
"""Greatest height of a tub's rim; a higher box also holds a pane or rod on the rim."""
_SHOWER_M = 1.2
"""Boxes above this height hold a shower, or a tub with a pane beside it."""
_LYING_M = 1.3
"""Shorter boxes are showers: nobody can lie in them."""
_PANE_M = 0.02


def toilet(look: Look) -> list[Part]:
    """A bowl before a cistern, its lid down or up, or a bowl that hangs from a tiled casing.

    Reads the attribute `form`.
    """
    x, y, z = look.size_m
    form = look.choice("form", FORMS["toilet"])
    # Proportions instead of metres for boxes that are low or shallow, so that parts stay inside.
    seat, deep = min(_SEAT_M, 0.55 * z), min(0.16 if form == "panel" else 0.2, 0.35 * x)
    back, long = (-x / 2, deep - x / 2), x - deep
    middle, rim = back[1] + long / 2, (long, min(y, 0.8 * long))
    is_hung = form == "panel"
    foot, low = (0.7 * long, 0.6 * rim[1]), 0.3 * seat if is_hung else 0.0
    lid = (0.9 * seat, seat)
    parts = [
        shifted(cone(foot, rim, (low, lid[0]), "enamel"), middle),
        shifted(cone(rim, rim, lid, "plastic_white"), middle),
    ]
    if is_hung:
        plate = paint((back[1], back[1] + 0.01), 0.6 * y, about(0.85 * z, 0.16 * z), "metal")
        return [*parts, block(back, y, (0, z), "wall_tiles"), plate]
    button = disc((back[0] + deep / 2, 0, z + 0.004), 0.3 * deep, 0.008, "metal")
    parts += [block(back, 0.94 * y, (0.8 * seat, z), "enamel"), button]
    if form == "open":
        leaf = (back[1], back[1] + 0.06 * long)
        parts += [
            block(leaf, 0.9 * rim[1], (seat, min(z, seat + 0.9 * long)), "plastic_white"),
            disc((middle + 0.05 * long, 0, seat), 0.6 * min(rim), 0.006, "dark_glass"),
        ]
    return parts


def basin(look: Look) -> list[Part]:
    """A basin on a pedestal, one in a cupboard, or a trough on the wall; a tap for each user.

    Reads the attributes `form` and `doors`.
    """
    x, y, z = look.size_m
    # Narrow basins may have any form; wide ones serve several people, for whom a pedestal is too
    # weak.
    form = look.choice("form", FORMS["basin"], () if y < 0.9 else ("vanity", "trough"))
    rim = z - min(_TAP_M, 0.2 * z)
    count = 1 if form == "pedestal" else max(1, min(4, round(y / _USER_M)))
    step = y / count
    parts: list[Part] = []
    for index in range(count):
        at = -y / 2 + (index + 0.5) * step
        tap = -0.42 * x, -0.36 * x
        parts += [
            paint(tap, about(at, 0.06 * x), (rim, z), "metal"),
            paint((tap[0], -0.05 * x), about(at, 0.06 * x), (0.3 * rim + 0.7 * z, z), "metal"),
            _hollow((-0.3 * x, 0.42 * x), about(at, min(0.8 * step, 0.6)), rim),
        ]
    if form == "vanity":
        doors = look.choice("doors", ("plastic_white", *WOODS))
        front = inwards(1, 0.48 * x, 0.02)
        return [
            *parts,
            block((-x / 2, front[0]), 0.98 * y, (0.1 * z, 0.86 * rim), doors),
            *(
                paint(front, about(sign * y / 4, 0.47 * y), (0.14 * z, 0.84 * rim), doors)
                for sign in (-1, 1)
            ),
            block(x, y, (0.86 * rim, rim), "enamel"),
            paint(0.8 * x, 0.9 * y, (0, 0.1 * z), "dark_metal"),
        ]
    if form == "trough":
        bracket = (-x / 2, 0.2 * x)
        return [
            *parts,
            block(x, y, (0.78 * rim, rim), "enamel"),
            block(inwards(-1, x / 2, 0.04 * x), y, (0, z), "wall_tiles"),
            *(
                block(bracket, about(sign * 0.4 * y, 0.04), (0.62 * rim, 0.78 * rim), "metal")
                for sign in (-1, 1)
            ),
        ]
    return [
        *parts,
        cone((0.55 * x, 0.5 * y), (x, y), (0.76 * rim, rim), "enamel"),
        cylinder((-0.1 * x, 0, 0.39 * rim), 0.34 * min(x, y), 0.78 * rim, "enamel"),
    ]


def bath(look: Look) -> list[Part]:
    """A tub in a tiled casing, one on feet, or the tray of a shower between panes of glass.

    A tub in a higher box has a pane at one end or the rod of a shower head. Reads the attributes
    `form`, `casing` and, of a shower, `hand`.
    """
    x, y, z = look.size_m
    lying = ("tub", "oval") if z < _SHOWER_M else ("tub", "shower")
    form = look.choice("form", FORMS["bath"], ("shower",) if y < _LYING_M else lying)
    if form == "shower":
        return _shower(look)
    # Up to a third above a usual rim the box is just a deep tub; higher ones have something on the
    # rim.
    rim = z if z < 1.3 * _TUB_M else _TUB_M
    wall, low = 0.09 * x, 0.2 * rim if form == "oval" else 0.0
    floor = low + 0.2 * rim
    casing = look.choice("casing", ("wall_tiles", "enamel")) if form == "tub" else "enamel"
    parts = [
        block(x, y, (low, floor), casing),
        *(block(inwards(sign, x / 2, wall), y, (floor, rim), casing) for sign in (-1, 1)),
        *(
            block(x - 2 * wall, inwards(sign, y / 2, wall), (floor, rim), casing)
            for sign in (-1, 1)
        ),
        paint(x - 2 * wall, y - 2 * wall, (floor, floor + 0.004), "plastic_white"),
        paint(0.06, inwards(-1, y / 2 - 0.2 * wall, 0.06), (rim, rim + 0.015), "metal"),
    ]
    if form == "oval":
        parts += legs(0.8 * x, 0.8 * y, (0, low), 0.1 * x, "dark_metal")
    if z > rim + 0.1 and form == "tub":
        pane = (-y / 2, 0.0)
        parts.append(block(inwards(1, x / 2, _PANE_M), pane, (rim, z), "glass"))
    elif z > rim + 0.1:
        rod = block(inwards(-1, x / 2, 0.04), about(0.2 * y, 0.04), (rim, z), "metal")
        parts.append(rod)
    return parts


def _shower(look: Look) -> list[Part]:
    """A tray in the corner of two panes, a rod with a head at the wall; open at the front's end."""
    x, y, z = look.size_m
    side = 1 if look.choice("hand", ("left", "right")) == "left" else -1
    tray = min(0.1, 0.2 * z)
    end = inwards(side, y / 2, _PANE_M)
    front: Interval = (0.0, y / 2) if side > 0 else (-y / 2, 0.0)
    head = (-x / 2, -0.1 * x)
    return [
        block(x, y, (0, tray), "enamel"),
        disc((0, 0, tray + 0.002), 0.12 * min(x, y), 0.004, "metal"),
        block(x - _PANE_M, end, (tray, z), "glass"),
        block(inwards(1, x / 2, _PANE_M), front, (tray, z), "glass"),
        block(inwards(-1, x / 2, 0.04), 0.04, (tray, z), "metal"),
        paint(head, 0.04, (0.93 * z, 0.96 * z), "metal"),
        disc((head[1], 0, 0.92 * z), 0.25 * min(x, y), 0.02 * z, "metal"),
    ]


def _hollow(x: Interval, y: Interval, z: float) -> Part:
    """Inner surface of a basin as seen from above, drawn on its rim."""
    return paint(x, y, (z, z + 0.004), "concrete")
