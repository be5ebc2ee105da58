"""Colour and form of an object as the world shows it, read from the solids that are rendered.

An attribute may say nothing, or something that a shape has no room for. The materials of the solids
cannot be wrong: the renderer paints with them.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping

from aeroscene.scene import SceneObject
from aeroscene.solids.shapes.build import object_primitives
from aeroscene.solids.shapes.primitive import Primitive
from scenarios.words.vocabulary import COLOUR_WORDS

_LEAST_SHARE = 0.25
"""Share of the surface that a colour must have to be the object's."""
_LEAST_LEAD = 6.0
"""How many times as large the surface of that colour must be as that of any other."""
_LOADS = {"cardboard": "boxes", "fabric_beige": "sacks", "brick": "bricks"}
_FLOORS = {
    "floor_tiles": "tiles",
    "carpet": "carpet",
    "parquet": "parquet",
    "concrete": "concrete",
}


def colours_of(obj: SceneObject) -> Mapping[str, float]:
    """Shares of an object's surface by the adjectives of their colours, the largest first.

    What has no adjective, such as glass and tyres, counts for the whole surface alone.
    """
    areas_m2: Counter[str] = Counter()
    whole_m2 = 0.0
    for solid in object_primitives(obj):
        area_m2 = _surface_m2(solid)
        whole_m2 += area_m2
        name = solid.material.removeprefix("plaster_").removeprefix("facade_")
        if (word := COLOUR_WORDS.get(name)) is not None:
            areas_m2[word] += area_m2  # pyright: ignore[reportArgumentType]
    return {word: area_m2 / whole_m2 for word, area_m2 in areas_m2.most_common()}


def prevailing(shares: Mapping[str, float]) -> str | None:
    """Adjective of the colour by which one would call an object; None if none prevails.

    Args:
        shares: Shares of its surface, the largest first.
    """
    first, second = (*shares.values(), 0.0, 0.0)[:2]
    is_clear = first >= _LEAST_SHARE and first >= _LEAST_LEAD * second
    return next(iter(shares)) if is_clear else None


def form_of(obj: SceneObject, kind: str) -> str | None:
    """Form that an object shows, a key of `FORM_WORDS`; None if it shows none with a word."""
    solids = object_primitives(obj)
    materials = {solid.material for solid in solids}
    match kind:
        case "landing_pad":
            return _marking(solids)
        case "pallet":
            return next((form for name, form in _LOADS.items() if name in materials), "bare")
        case "crate":
            return "plastic" if any(name.startswith("paint_") for name in materials) else "wooden"
        case "truck":
            if any(solid.kind == "cylinder" and solid.material == "metal" for solid in solids):
                return "tanker"
            return "flatbed" if "wood" in materials else None
        case "room":
            return next((form for name, form in _FLOORS.items() if name in materials), None)
        case "roof":
            return "tiled" if materials & {"roof_red", "roof_slate"} else None
        case _:
            return None


def _marking(pad: tuple[Primitive, ...]) -> str | None:
    """Sign that is painted on a landing pad."""
    if any(solid.material == "light_red" for solid in pad):
        return "rings"
    is_round = any(solid.kind == "cylinder" for solid in pad)
    has_yellow = any(solid.material == "marking_yellow" for solid in pad)
    if not has_yellow:
        return None
    return "letter" if is_round else "cross"


def _surface_m2(solid: Primitive) -> float:
    x, y, z = solid.size_m
    return 2.0 * (x * y + y * z + z * x)
