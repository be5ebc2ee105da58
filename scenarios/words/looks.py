"""Colour and form of an object as the world shows it, read from the solids that are rendered.

A pilot sees pictures, so a text must agree with them. An attribute may be missing, or name a form
that the shape has no room for. The materials of the solids cannot be wrong, because the renderer
paints with them.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping

from aeroscene.scene import SceneObject
from aeroscene.solids.shapes.build import object_primitives
from aeroscene.solids.shapes.primitive import Primitive
from scenarios.words.vocabulary import COLOUR_WORDS

_LEAST_SHARE = 0.25
"""Least share of the surface that a colour needs to be the object's."""
_LEAST_LEAD = 6.0
"""Least ratio of the surface of that colour to that of any other colour."""
_LOADS = {"cardboard": "boxes", "fabric_beige": "sacks", "brick": "bricks"}
_FLOORS = {
    "floor_tiles": "tiles",
    "carpet": "carpet",
    "parquet": "parquet",
    "concrete": "concrete",
}


def colours_of(obj: SceneObject) -> Mapping[str, float]:
    """Return the shares of an object's surface by colour adjective, the largest first.

    Materials without an adjective, such as glass and tyres, count for the whole surface only, so
    the shares may add up to less than 1.

    Args:
        obj: Object of a scene.
    """
    areas_m2: Counter[str] = Counter()
    whole_m2 = 0.0
    for solid in object_primitives(obj):
        area_m2 = _surface_m2(solid)
        whole_m2 += area_m2
        name = solid.material.removeprefix("plaster_").removeprefix("facade_")
        if (word := COLOUR_WORDS.get(name)) is not None:
            areas_m2[word] += area_m2  # pyrefly: ignore[unsupported-operation]
    return {word: area_m2 / whole_m2 for word, area_m2 in areas_m2.most_common()}


def prevailing(shares: Mapping[str, float]) -> str | None:
    """Return the colour by which a reader would call an object, None if no colour prevails.

    Args:
        shares: Shares of its surface, the largest first, as `colours_of` returns them.
    """
    first, second = (*shares.values(), 0.0, 0.0)[:2]
    is_clear = first >= _LEAST_SHARE and first >= _LEAST_LEAD * second
    return next(iter(shares)) if is_clear else None


def form_of(obj: SceneObject, kind: str) -> str | None:
    """Return the form that an object shows, None if it shows none that has a word.

    Args:
        obj: Object of a scene.
        kind: Its kind, which is with the form a key of `FORM_WORDS`.
    """
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
            # The tank is the only metal cylinder; wheels are cylinders of rubber.
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
    """Return the sign that is painted on a landing pad, None if there is none."""
    if any(solid.material == "light_red" for solid in pad):
        return "rings"
    is_round = any(solid.kind == "cylinder" for solid in pad)
    has_yellow = any(solid.material == "marking_yellow" for solid in pad)
    if not has_yellow:
        return None
    return "letter" if is_round else "cross"


def _surface_m2(solid: Primitive) -> float:
    # That of its box, whatever its kind: only the shares of colours matter.
    x, y, z = solid.size_m
    return 2.0 * (x * y + y * z + z * x)
