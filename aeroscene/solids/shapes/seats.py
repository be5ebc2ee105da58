"""Furniture to sit or lie on; the front is +x, the back or the headboard -x."""

from __future__ import annotations

from math import hypot

from aeroscene.solids.shapes.forms import FORMS
from aeroscene.solids.shapes.furniture import WOODS
from aeroscene.solids.shapes.look import Look
from aeroscene.solids.shapes.materials import FABRIC_COLOURS
from aeroscene.solids.shapes.primitive import Part, block, cylinder
from aeroscene.solids.shapes.solids import about, cone, disc, inwards, leaning, legs, paint, prism

SEAT_M = 0.46
"""Height of a chair's seat."""
_BACK_LEAN = 0.1
"""Angle by which a back rest leans, rad, as rise to run."""


def _fabric(look: Look) -> str:
    return "fabric_" + look.set_choice("colour", FABRIC_COLOURS)


def chair(look: Look) -> list[Part]:
    """Seat and back on four legs, on two runners, upholstered, or on a column with a star foot.

    Reads the attributes `form`, `wood` and `colour`.
    """
    x, y, z = look.size_m
    form = look.set_choice("form", FORMS["chair"])
    wood, seat = look.set_choice("wood", WOODS), min(SEAT_M, 0.6 * z)
    if form == "swivel":
        cloth, stem = _fabric(look), 0.07
        return [
            block(0.9 * x, 0.9 * y, (seat - 0.08, seat), cloth),
            _back(look, seat + 0.12, 0.05, 0.84 * y, cloth),
            block(inwards(-1, 0.45 * x, 0.03), 0.06, (seat - 0.06, seat + 0.2), "dark_metal"),
            cylinder((0, 0, seat / 2), stem, seat - 0.08, "dark_metal"),
            cone((0.92 * x, 0.92 * y), 0.2, (0, 0.09), "plastic_black", sides=5),
        ]
    if form == "sled":
        sides = [inwards(sign, y / 2, 0.03) for sign in (-1, 1)]
        return [
            block(x, y, (seat - 0.03, seat), wood),
            _back(look, seat, 0.03, 0.9 * y, wood),
            *(block(0.9 * x, side, (0, 0.03), "metal") for side in sides),
            *(block(about(0.32 * x, 0.03), side, (0.03, seat - 0.03), "metal") for side in sides),
        ]
    is_soft = form == "upholstered"
    cover, thick = (_fabric(look), 0.1) if is_soft else (wood, 0.04)
    return [
        block(x, y, (seat - thick, seat), cover),
        _back(look, seat + 0.01, 0.5 * thick + 0.015, y if is_soft else 0.86 * y, cover),
        *legs(x - 0.02, y - 0.02, (0, seat - thick), 0.045, wood),
    ]


def _back(look: Look, low: float, thick: float, width: float, material: str) -> Part:
    """A rest that leans back within the box."""
    x, _, z = look.size_m
    rise = z - low
    # At most 12% of the depth, so that a tall rest leaves room to sit.
    run = min(_BACK_LEAN * rise, 0.12 * x)
    profile = [(-x / 2 + run, low), (-x / 2 + run + thick, low), (-x / 2 + thick, z), (-x / 2, z)]
    return prism(profile, width, material)


def sofa(look: Look) -> list[Part]:
    """Base, back and arms; on feet with cushions, or with a long seat at one end.

    Reads the attributes `form` and `colour`.
    """
    x, y, z = look.size_m
    form, cloth = look.set_choice("form", FORMS["sofa"]), _fabric(look)
    arm = 0.2 if form == "block" else 0.13
    back, inner, foot = (-x / 2, -x / 2 + 0.22), y / 2 - arm, 0.08 if form == "block" else 0.13
    rest = 0.62 if form == "block" else 0.56
    front = x / 2 if form != "chaise" else 0.3 * x
    parts = [
        block((back[1], front), 2 * inner, (foot, 0.43), cloth),
        block(back, y, (foot, z), cloth),
        block((back[1], front), (-y / 2, -inner), (foot, min(rest, z)), cloth),
        block((back[1], front), (inner, y / 2), (foot, min(rest, z)), cloth),
        paint(x - 0.1, y - 0.12, (0, foot), "dark_wood"),
    ]
    if form == "cushions":
        pillow = (back[1], back[1] + 0.14)
        parts += [
            paint(pillow, about(sign * inner / 2, 0.9 * inner), (0.43, z - 0.04), "fabric_beige")
            for sign in (-1, 1)
        ]
        parts.append(paint((back[1] + 0.1, x / 2 + 0.01), 0.02, (0.36, 0.435), "dark_wood"))
    elif form == "chaise":
        parts.append(block((front, x / 2), (0.1 * y, y / 2), (foot, 0.43), cloth))
    return parts


def armchair(look: Look) -> list[Part]:
    """A seat between arms: square, with a high wing back on feet, or a round tub.

    Reads the attributes `form` and `colour`.
    """
    x, y, z = look.size_m
    form, cloth = look.set_choice("form", FORMS["armchair"]), _fabric(look)
    if form == "tub":
        return [
            cylinder((0.02, 0, 0.25), 0.82 * min(x, y), 0.36, cloth),
            block((-x / 2, -x / 2 + 0.16), 0.8 * y, (0.1, z), cloth),
            *(
                block(
                    (-x / 2 + 0.1, 0.3 * x), inwards(sign, y / 2, 0.12), (0.1, min(0.68, z)), cloth
                )
                for sign in (-1, 1)
            ),
            disc((0, 0, 0.05), 0.4 * min(x, y), 0.1, "dark_metal"),
        ]
    arm, foot = (0.17, 0.08) if form == "block" else (0.11, 0.18)
    inner, front = y / 2 - arm, (-x / 2 + 0.18, x / 2)
    parts = [
        block(front, 2 * inner, (foot, 0.44), cloth),
        _back(look, foot, 0.16, y, cloth)
        if form == "wing"
        else block((-x / 2, front[0]), y, (foot, z), cloth),
        block(front, (-y / 2, -inner), (foot, min(0.62, z)), cloth),
        block(front, (inner, y / 2), (foot, min(0.62, z)), cloth),
    ]
    if form == "wing":
        return [*parts, *legs(x - 0.06, y - 0.04, (0, foot), 0.05, "dark_wood")]
    return [*parts, paint(x - 0.1, y - 0.1, (0, foot), "dark_wood")]


def bed(look: Look) -> list[Part]:
    """Frame, mattress, cover, pillows; a headboard, an upholstered divan, or four low posts.

    Reads the attributes `form`, `wood`, `colour` and `cover`.
    """
    x, y, z = look.size_m
    form, cloth = look.set_choice("form", FORMS["bed"]), _fabric(look)
    wood = look.set_choice("wood", WOODS)
    top = min(0.52, z)
    frame = cloth if form == "divan" else wood
    low = 0.0 if form == "divan" else 0.16
    head = z if form != "posts" else min(z, top + 0.3)
    parts = [
        block((-x / 2 + 0.05, x / 2), y, (low, 0.6 * top), frame),
        block((-x / 2 + 0.07, x / 2 - 0.03), y - 0.06, (0.6 * top, top - 0.02), "plastic_white"),
        block((-x / 2 + 0.62, x / 2 - 0.02), y - 0.04, (0.64 * top, top), _cover(look)),
        block((-x / 2, -x / 2 + 0.07), y, (low, head), frame),
    ]
    if form != "divan":
        # Legs of a plain bed end under the frame; posts rise to the height of the headboard.
        parts += legs(x, y, (0, low if form == "boards" else head), 0.07, wood)
    # Lower boxes end with the mattress and leave no room for pillows.
    if z > top + 0.08:
        count = 2 if y > 1.3 else 1
        parts += [
            paint(
                (-x / 2 + 0.12, -x / 2 + 0.52),
                about((i - (count - 1) / 2) * 0.46 * y, 0.8 * y / count),
                (top - 0.03, min(z, top + 0.08)),
                "ceramic",
            )
            for i in range(count)
        ]
    return parts


def _cover(look: Look) -> str:
    return look.choice("cover", tuple(f"fabric_{colour}" for colour in FABRIC_COLOURS))


def bench(look: Look) -> list[Part]:
    """A seat for two to four: with a leaning rest behind, plain, or planks on blocks of stone.

    Reads the attribute `form`.
    """
    x, y, z = look.size_m
    form = look.choice("form", FORMS["bench"])
    seat = min(0.45, z) if form != "rest" else min(0.45, 0.6 * z)
    ends = [about(sign * (y / 2 - 0.25), 0.08) for sign in (-1, 1)]
    if form == "stone":
        blocks = [about(sign * (y / 2 - 0.22), 0.34) for sign in (-1, 1)]
        return [
            block(x, y, (seat - 0.08, seat), "wood"),
            *(block(0.9 * x, at, (0, seat - 0.08), "stone") for at in blocks),
        ]
    parts = [
        block(x, y, (seat - 0.06, seat), "wood"),
        *(block(0.86 * x, end, (0, seat - 0.06), "dark_metal") for end in ends),
    ]
    if form == "plain" or z < seat + 0.2:
        return parts
    rise, run = z - seat - 0.1, 0.1
    rest = leaning(
        (-x / 2 + 0.09, 0, seat + 0.1 + rise / 2),
        (0.05, y, hypot(rise, run) - 0.06),
        -0.18,
        "y",
        "wood",
    )
    stays = [
        paint(inwards(-1, x / 2 - 0.06, 0.05), end, (seat, seat + 0.3 * rise + 0.1), "dark_metal")
        for end in ends
    ]
    return [*parts, rest, *stays]
