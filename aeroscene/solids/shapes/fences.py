"""Fences, which run along y."""

from __future__ import annotations

from aeroscene.solids.shapes.forms import FORMS
from aeroscene.solids.shapes.look import Look
from aeroscene.solids.shapes.materials import WALL_COLOURS
from aeroscene.solids.shapes.primitive import Interval, Part, block
from aeroscene.solids.shapes.solids import about

_POST_SPACING_M = 2.5
# Bounds the parts of a long fence; its posts then stand farther apart.
_MOST_POSTS = 7
_WIRES = 4


def fence(look: Look) -> list[Part]:
    """A hedge, boards or rails between posts, a wall with a coping, or a mesh of wires.

    Reads the attributes `form`, `material` (of a wall) and `wood` (of boards).
    """
    form = look.choice("form", FORMS["fence"])
    x, y, z = look.size_m
    if form == "hedge":
        return [block(x, y, (0, z), "hedge")]
    if form == "wall":
        plaster = tuple(f"plaster_{colour}" for colour in WALL_COLOURS)
        wall = look.choice("material", ("brick", "stone", *plaster[:3]))
        cope = min(0.08, 0.1 * z)
        return [block(0.8 * x, y, (0, z - cope), wall), block(x, y, (z - cope, z), "concrete")]
    # Only a hedge or a wall fills a wide box; other fences stay thin in the middle of it.
    thick = min(x, 0.1)
    if form == "boards":
        wood = look.choice("wood", ("wood", "dark_wood", "pale_wood"))
        panel = block(0.5 * thick, y, (0.06, z - 0.05), wood)
        return [panel, *_posts(thick, y, z, "dark_wood")]
    metal = "dark_metal" if form == "rails" else "plastic_green"
    bars = [block(0.5 * thick, y, bar, metal) for bar in _bars(form, z)]
    return [*bars, *_posts(thick, y, z, metal)]


def _bars(form: str, z: float) -> list[Interval]:
    """Three stout rails, or a row of wires from the ground to the top."""
    if form == "rails":
        return [about(at * z, 0.07) for at in (0.16, 0.56)] + [(z - 0.09, z - 0.02)]
    low, high = 0.1 * z, z - 0.03
    return [about(low + i * (high - low) / _WIRES, 0.025) for i in range(_WIRES + 1)]


def _posts(thick: float, y: float, z: float, material: str) -> list[Part]:
    count = max(2, min(_MOST_POSTS, round(y / _POST_SPACING_M) + 1))
    wide = min(0.1, 0.2 * y)
    return [
        block(thick, about((index / (count - 1) - 0.5) * (y - wide), wide), (0, z), material)
        for index in range(count)
    ]
