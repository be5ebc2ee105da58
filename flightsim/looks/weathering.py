"""Paints in season, rain and snow: leaves turn, wet ground darkens, roofs and meadows whiten.

The change is one of paints, not of geometry: labels and collisions are the same in every
weather, so that a flight differs only in what its cameras show.
"""

from __future__ import annotations

import zlib
from collections.abc import Mapping
from dataclasses import replace

from flightsim.looks.light import Light
from flightsim.looks.paint import Colour, Paint
from flightsim.looks.weather.words import Season

_GROUND = frozenset(
    {"asphalt", "paving", "cobbles", "gravel", "soil", "sand", "concrete", "roof_tiles", "felt"}
)
"""Textures that rain darkens."""
_SNOW_COVER: Mapping[str, float] = {
    "grass": 0.92,
    "meadow": 0.95,
    "crops": 0.92,
    "soil": 0.90,
    "sand": 0.85,
    "gravel": 0.80,
    "roof_tiles": 0.88,
    "felt": 0.88,
    "paving": 0.60,
    "cobbles": 0.60,
    "asphalt": 0.35,
    "leaves": 0.45,
}
"""Share of each texture's colour that is snow's; roads are driven on, and trees shake it off."""
_SNOW: Colour = (0.93, 0.95, 0.98)
_WET: Colour = (0.62, 0.63, 0.66)
"""Factors of the colour of wet ground: water fills the pores that would scatter light."""
_LEAVES: Mapping[Season, tuple[Colour, ...]] = {
    "spring": ((1.15, 1.22, 0.85), (1.30, 1.20, 1.10)),
    "summer": ((1.0, 1.0, 1.0),),
    "autumn": ((2.2, 1.25, 0.55), (2.6, 0.85, 0.50), (1.7, 1.20, 0.60), (1.2, 1.0, 0.8)),
    "winter": ((1.15, 0.85, 0.75), (1.0, 0.80, 0.80), (0.75, 0.85, 0.85)),
}
_GRASS: Mapping[Season, Colour] = {
    "spring": (0.95, 1.10, 0.90),
    "summer": (1.0, 1.0, 1.0),
    "autumn": (1.20, 0.98, 0.80),
    "winter": (1.22, 0.98, 0.95),
}
_FIELDS = frozenset({"grass", "meadow", "crops"})
_FACADES = frozenset(
    {
        *("punched", "shuttered", "brickwork", "stonework", "balconies"),
        *("ribbon", "curtain_wall", "shop_front", "entrance"),
    }
)


def weathered(paint: Paint, light: Light) -> Paint:
    """A paint in the season and the weather of a light."""
    texture = paint.texture
    if texture == "leaves":
        tints = _LEAVES[light.season]
        # Trees have paints of several tints already; each gets one colour of the season.
        paint = paint.tinted(tints[zlib.crc32(repr(paint.rgb).encode()) % len(tints)])
    elif texture in _FIELDS:
        paint = paint.tinted(_GRASS[light.season])
    if light.falling == "rain" and texture in _GROUND:
        paint = paint.tinted(_WET)
    elif light.falling == "snow" and texture is not None and texture in _SNOW_COVER:
        share = _SNOW_COVER[texture]
        red, green, blue = (
            (1.0 - share) * own + share * snow for own, snow in zip(paint.rgb, _SNOW, strict=True)
        )
        paint = replace(paint, rgb=(red, green, blue))
    return replace(paint, is_lit_within=light.is_dark and texture in _FACADES)
