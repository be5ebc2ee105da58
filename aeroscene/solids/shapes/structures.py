"""Open structures: canopies, decks, stairs and bridges. Surfaces to walk or land on are level."""

from __future__ import annotations

from math import atan2, hypot, radians, tan

from aeroscene.solids.shapes.forms import FORMS
from aeroscene.solids.shapes.look import Look
from aeroscene.solids.shapes.materials import PAINT_COLOURS
from aeroscene.solids.shapes.primitive import Interval, Part, block, cylinder
from aeroscene.solids.shapes.solids import about, inwards, leaning, legs, prism

_RISER_M = 0.19
# Bounds the parts of a high flight of stairs; its risers are higher then.
_MOST_STEPS = 16
RAIL_M = 1.1
"""Height of a bridge's railing."""
_CANOPY_PITCH_RAD = radians(8.0)
_SLAB_M = 0.16


def canopy(look: Look) -> list[Part]:
    """A roof on posts, open on every side: level, a low gable, or one plane of solar panels.

    Reads the attributes `form` and `colour`.
    """
    x, y, z = look.size_m
    form = look.choice("form", FORMS["canopy"])
    paint = "paint_" + look.choice("colour", PAINT_COLOURS)
    if form == "flat":
        return [
            block(x, y, (z - 0.25, z - 0.04), paint),
            block(x - 0.1, y - 0.1, (z - 0.04, z), "plastic_white"),
            *_columns(x, y, (z - 0.25, z - 0.25)),
        ]
    if form == "solar":
        rise = min(x * tan(_CANOPY_PITCH_RAD), 0.4 * z)
        low, high = z - rise - _SLAB_M, z - _SLAB_M
        plane = [(x / 2, low), (x / 2, low + _SLAB_M), (-x / 2, z), (-x / 2, high)]
        frame = [
            (x / 2, low - 0.06),
            (x / 2, low + 0.02),
            (-x / 2, high + 0.02),
            (-x / 2, high - 0.06),
        ]
        return [
            prism(plane, y, "solar"),
            prism(frame, 0.8 * y, "metal"),
            *_columns(x, y, (high - 0.08, low)),
        ]
    rise = min(x / 2 * tan(_CANOPY_PITCH_RAD), 0.3 * z)
    eaves = z - rise - _SLAB_M
    planes = [
        prism(
            [(0.0, z - _SLAB_M), (0.0, z), (sign * x / 2, eaves + _SLAB_M), (sign * x / 2, eaves)],
            y,
            paint,
        )
        for sign in (-1, 1)
    ]
    return [*planes, *_columns(x, y, (eaves, eaves))]


def _columns(x: float, y: float, heights: tuple[float, float]) -> list[Part]:
    """Four round posts a little inside the corners; heights are those at -x and at +x."""
    inset = min(0.25, 0.12 * min(x, y))
    return [
        cylinder((sx * (x / 2 - inset), sy * (y / 2 - inset), height / 2), 0.14, height, "metal")
        for sx, height in zip((-1, 1), heights, strict=True)
        for sy in (-1, 1)
    ]


def deck(look: Look) -> list[Part]:
    """A wooden platform: on a dark plinth, on posts, or with a darker edge.

    Reads the attributes `form` and `boards`.
    """
    x, y, z = look.size_m
    form = look.choice("form", FORMS["deck"])
    top = 0.1 if z > 0.2 else 0.5 * z
    boards = look.choice("boards", ("pale_wood", "wood"))
    if form == "posts" and z > 0.35:
        beam = (z - top - 0.14, z - top)
        return [
            block(x, y, (z - top, z), boards),
            *(block(x - 0.2, about(at * y, 0.14), beam, "dark_wood") for at in (-0.4, 0.4)),
            *legs(x - 0.1, 0.8 * y + 0.14, (0, beam[0]), 0.16, "dark_wood"),
        ]
    plinth = block(x - 0.2, y - 0.2, (0, z - top), "dark_wood")
    if form == "edged":
        rim = 0.18
        return [
            plinth,
            block(x - 2 * rim, y - 2 * rim, (z - top, z), boards),
            *(block(inwards(s, x / 2, rim), y, (z - top, z), "dark_wood") for s in (-1, 1)),
            *(
                block(x - 2 * rim, inwards(s, y / 2, rim), (z - top, z), "dark_wood")
                for s in (-1, 1)
            ),
        ]
    return [plinth, block(x, y, (z - top, z), boards)]


def count_steps(rise_m: float) -> int:
    """Number of steps in a flight of stairs of some height."""
    return max(2, min(_MOST_STEPS, round(rise_m / _RISER_M)))


def stairs(look: Look) -> list[Part]:
    """Steps that rise towards +x: solid, open treads on two beams, or between cheek walls.

    Reads the attributes `form` and `material`.
    """
    x, y, z = look.size_m
    form = look.choice("form", FORMS["stairs"])
    count = count_steps(z)
    run, rise = x / count, z / count
    # Low or narrow flights have no room for beams under the treads.
    if form == "open" and z > 0.9 and y > 0.6:
        slab = min(0.06, 0.5 * rise)
        treads = [
            block(
                (-x / 2 + i * run, -x / 2 + (i + 1) * run),
                y,
                ((i + 1) * rise - slab, (i + 1) * rise),
                "wood",
            )
            for i in range(count)
        ]
        beam = [
            (-x / 2, 0.0),
            (-x / 2 + run, 0.0),
            (x / 2, z - rise - slab),
            (x / 2, z - slab),
            (x / 2 - run, z - slab),
        ]
        return [
            *treads,
            *(prism(beam, inwards(s, y / 2 - 0.05, 0.06), "dark_metal") for s in (-1, 1)),
        ]
    cheek = min(0.25, 0.1 * y) if form == "cheeks" else 0.0
    stone = look.choice("material", ("concrete", "stone"))
    # Each step is a block from its riser to the back, so that the steps carry each other.
    steps = [
        block((-x / 2 + i * run, x / 2), y - 2 * cheek, (i * rise, (i + 1) * rise), stone)
        for i in range(count)
    ]
    if form != "cheeks":
        return steps
    side = [(-x / 2, 0.0), (x / 2, 0.0), (x / 2, z), (x / 2 - run, z), (-x / 2, rise)]
    return [*steps, *(prism(side, inwards(s, y / 2, cheek), "dark_concrete") for s in (-1, 1))]


def bridge(look: Look) -> list[Part]:
    """A footbridge along x: level from end to end, with stairs at both ends, or a truss.

    Reads the attribute `form`.
    """
    x, y, z = look.size_m
    form = look.choice("form", FORMS["bridge"])
    top = z - RAIL_M
    # Stairs of 32 degrees; they have to leave at least 6 m of level deck.
    run = 1.6 * top
    if form == "stairs" and x - 2 * run > 6:
        ends = [part for sign in (-1, 1) for part in _flight(sign, (x / 2 - run, x / 2), y, top)]
        return [*_span(x - 2 * run, y, z, "glass"), *ends]
    if form == "truss":
        return [*_span(x, y, z, "none"), *_truss(x, y, z)]
    return _span(x, y, z, "glass")


def _span(x: float, y: float, z: float, panel: str) -> list[Part]:
    """A deck on two piers with handrails and, unless `panel` is "none", panels below them."""
    top = z - RAIL_M
    parts = [block(x, y, (top - 0.35, top), "concrete")]
    for sign in (-1, 1):
        side = inwards(sign, y / 2, 0.08)
        parts.append(block(x, side, (z - 0.1, z), "dark_metal"))
        if panel != "none":
            parts.append(block(x, side, (top, top + 0.55), panel))
        pier = inwards(sign, x / 2, 0.8)
        parts.append(block(pier, 0.7 * y, (0, top - 0.35), "concrete"))
    return parts


def _flight(sign: int, along: Interval, y: float, top: float) -> list[Part]:
    """Stairs from the ground to the deck at one end."""
    count = min(10, count_steps(top))
    run = (along[1] - along[0]) / count
    return [
        block(
            inwards(sign, along[1] - i * run, along[1] - along[0] - i * run),
            y,
            (i * top / count, (i + 1) * top / count),
            "concrete",
        )
        for i in range(count)
    ]


def _truss(x: float, y: float, z: float) -> list[Part]:
    """Diagonals between deck and handrail on both sides."""
    count = max(2, min(6, round(x / 4)))
    bay, rise = x / count, RAIL_M - 0.1
    tilt, length = atan2(rise, bay), hypot(rise, bay)
    parts: list[Part] = []
    for sign in (-1, 1):
        parts += [
            leaning(
                ((i - (count - 1) / 2) * bay, sign * (y / 2 - 0.04), z - RAIL_M + rise / 2),
                (length - 0.1, 0.07, 0.07),
                tilt if i % 2 else -tilt,
                "y",
                "dark_metal",
            )
            for i in range(count)
        ]
    return parts
