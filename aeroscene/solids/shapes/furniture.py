"""Furniture with a top to put things on; the front, where a person sits or stands, is +x.

The space under a table is free between its legs, so that a small drone can fly there.
"""

from __future__ import annotations

from aeroscene.solids.shapes.forms import FORMS
from aeroscene.solids.shapes.look import Look
from aeroscene.solids.shapes.primitive import Part, block, cylinder
from aeroscene.solids.shapes.solids import about, inwards, legs, paint

WOODS = ("wood", "pale_wood", "dark_wood")
_TOP_M = 0.045
_SQUARE = 1.3
"""Ratio of length to width up to which a table may be round."""


def table(look: Look) -> list[Part]:
    """A top on four legs or two trestles; a small square one may be round or have one foot.

    Reads the attributes `form`, `wood` and `legs`.
    """
    x, y, z = look.size_m
    # Larger ones are round or on feet only if the attribute asks for it.
    is_small = max(x, y) <= min(1.5, _SQUARE * min(x, y))
    form = look.set_choice("form", FORMS["table"], () if is_small else ("legs", "trestle"))
    wood = look.set_choice("wood", WOODS)
    under = z - _TOP_M
    if form == "legs":
        top = block(x, y, (under, z), wood)
        return [top, *legs(x - 0.08, y - 0.08, (0, under), 0.065, wood)]
    if form == "trestle":
        metal = look.set_choice("legs", ("dark_metal", wood))
        ends = [inwards(sign, y / 2 - 0.12, 0.05) for sign in (-1, 1)]
        return [
            block(x, y, (under, z), wood),
            *(block(0.72 * x, end, (0, under), metal) for end in ends),
        ]
    wide = min(x, y)
    if form == "round":
        top = cylinder((0, 0, z - _TOP_M / 2), wide, _TOP_M, wood)
        return [top, *legs(0.62 * wide, 0.62 * wide, (0, under), 0.055, wood)]
    # A long one has two feet.
    feet = (0.0,) if is_small else (-0.27 * y, 0.27 * y)
    return [
        block(x, y, (under, z), "stone"),
        *(cylinder((0, at, under / 2), 0.1, under, "dark_metal") for at in feet),
        *(cylinder((0, at, 0.015), min(0.5 * wide, 0.42 * y), 0.03, "dark_metal") for at in feet),
    ]


def coffee_table(look: Look) -> list[Part]:
    """A low top on two panels, round on a drum, or on legs with a board between them.

    Reads the attributes `form` and `wood`.
    """
    x, y, z = look.size_m
    is_square = max(x, y) <= 1.15 * min(x, y)
    form = look.choice("form", FORMS["coffee_table"], () if is_square else ("panels", "legs"))
    wood = look.choice("wood", WOODS)
    under = z - 0.04
    top = block(x, y, (under, z), wood)
    if form == "panels":
        ends = [inwards(sign, y / 2 - 0.08, 0.05) for sign in (-1, 1)]
        return [top, *(block(0.8 * x, end, (0, under), wood) for end in ends)]
    if form == "legs":
        board = block(0.86 * x, 0.86 * y, (0.32 * z, 0.32 * z + 0.025), wood)
        return [top, board, *legs(x - 0.04, y - 0.04, (0, under), 0.04, "dark_metal")]
    wide = min(x, y)
    return [
        *(cylinder((0, at, z - 0.02), wide, 0.04, wood) for at in _round_tops(wide, y)),
        *(
            cylinder((0, at, under / 2), 0.5 * wide, under, "dark_metal")
            for at in _round_tops(wide, y)
        ),
    ]


def _round_tops(wide: float, y: float) -> list[float]:
    """Middle of one round table, or of two side by side if there is room."""
    if y < 1.8 * wide:
        return [0.0]
    return [-(y - wide) / 2, (y - wide) / 2]


def desk(look: Look) -> list[Part]:
    """A top with a drawer block, on four legs with a modesty panel, or on two lifting columns.

    Reads the attributes `form` and `wood`.
    """
    x, y, z = look.size_m
    form, wood = look.set_choice("form", FORMS["desk"]), look.set_choice("wood", WOODS)
    under = z - 0.04
    top = block(x, y, (under, z), wood)
    back = (-x / 2 + 0.06, -x / 2 + 0.08)
    if form == "legs":
        panel = block(back, y - 0.2, (0.45 * z, under), wood)
        return [top, panel, *legs(x - 0.06, y - 0.06, (0, under), 0.05, "dark_metal")]
    if form == "standing":
        columns = [about(sign * 0.36 * y, 0.08) for sign in (-1, 1)]
        return [
            top,
            *(block(0.1, column, (0.03, under), "metal") for column in columns),
            *(block(0.9 * x, column, (0, 0.03), "metal") for column in columns),
        ]
    drawers = (y / 2 - 0.44, y / 2 - 0.02)
    front = (0.45 * x - 0.005, 0.45 * x + 0.005)
    return [
        top,
        block(0.9 * x, (-y / 2 + 0.02, -y / 2 + 0.06), (0, under), "dark_metal"),
        # The drawers take one end; the other stands on a panel.
        block(0.9 * x, drawers, (0.06, under), wood),
        block(back, y - 0.2, (0.5 * z, under), wood),
        paint(
            front, about((drawers[0] + drawers[1]) / 2, 0.2), about(0.68 * z, 0.02), "dark_metal"
        ),
        paint(
            front, about((drawers[0] + drawers[1]) / 2, 0.2), about(0.36 * z, 0.02), "dark_metal"
        ),
    ]


def nightstand(look: Look) -> list[Part]:
    """A small chest with two drawers, an open case, or a round side table.

    Reads the attributes `form` and `wood`.
    """
    x, y, z = look.size_m
    form, wood = look.set_choice("form", FORMS["nightstand"]), look.set_choice("wood", WOODS)
    if form == "round":
        wide = min(x, y)
        return [
            cylinder((0, 0, z - 0.015), wide, 0.03, wood),
            cylinder((0, 0, z / 2), 0.06, z - 0.06, "dark_metal"),
            cylinder((0, 0, 0.015), 0.6 * wide, 0.03, "dark_metal"),
        ]
    if form == "open":
        return [
            *(block(x, inwards(sign, y / 2, 0.025), (0, z), wood) for sign in (-1, 1)),
            block(inwards(-1, x / 2, 0.02), y - 0.05, (0.1, z), wood),
            *(block(x, y - 0.05, (low, low + 0.025), wood) for low in (0.1, 0.55 * z, z - 0.025)),
        ]
    front = inwards(1, x / 2, 0.02)
    return [
        # The body ends where the fronts of the drawers begin.
        block((-x / 2, front[0]), y, (0, z), wood),
        *(paint(front, 0.86 * y, (low * z, (low + 0.36) * z), "dark_wood") for low in (0.12, 0.56)),
    ]


def counter(look: Look) -> list[Part]:
    """A worktop over cupboards, plain or with a sink, or a bar with a panel to lean on.

    Reads the attributes `form`, `doors` and, of a bar, `wood`.
    """
    x, y, z = look.size_m
    form = look.choice("form", FORMS["counter"])
    top = block(x, y, (z - 0.05, z), "stone")
    if form == "bar":
        wood = look.choice("wood", WOODS)
        rail = paint(inwards(1, x / 2, 0.06), 0.94 * y, (0.16, 0.2), "metal")
        return [
            block((-x / 2, x / 2 - 0.16), y, (0, z - 0.06), wood),
            block(x, y, (z - 0.06, z), "dark_wood"),
            rail,
        ]
    front = inwards(1, x / 2 - 0.02, 0.02)
    doors = look.choice("doors", ("plastic_white", "pale_wood", "paint_green"))
    # One door for each 60 cm, the usual width of kitchen cupboards.
    count = max(1, min(6, round(y / 0.6)))
    step = y / count
    parts = [
        block((-x / 2, front[0]), y, (0, z - 0.05), "dark_wood"),
        top,
        *(
            paint(front, about(-y / 2 + (i + 0.5) * step, step - 0.02), (0.1, z - 0.07), doors)
            for i in range(count)
        ),
    ]
    if form == "sink" and y > 1.0:
        at = -y / 2 + 0.25 * y
        parts.append(paint(0.6 * x, about(at, 0.5), (z, z + 0.004), "dark_metal"))
        # The tap stays within the slack by which parts may exceed their box.
        tap = (-0.36 * x, -0.36 * x + 0.03)
        parts.append(paint(tap, about(at, 0.03), (z - 0.01, z + 0.018), "metal"))
    return parts
