"""Height and steepness of the land, by the theme of a scene."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class LandStyle:
    """Rise of the land of a site and around it."""

    rise_m: float
    """Greatest height in the site's green, reached if that is wide enough."""
    around_m: float
    """Greatest height around the site."""
    bank: tuple[float, float]
    """Range of the gradient of banks beside level ground."""


_COUNTRY = LandStyle(rise_m=2.2, around_m=5.0, bank=(0.12, 0.18))
_SUBURB = LandStyle(rise_m=1.2, around_m=2.8, bank=(0.1, 0.15))
_TOWN = LandStyle(rise_m=0.7, around_m=1.2, bank=(0.08, 0.12))
LAND_STYLES: Mapping[str, LandStyle] = {
    "park": _COUNTRY,
    "hillside": _COUNTRY,
    "village": _COUNTRY,
    "residential_street": _SUBURB,
    "campus": _SUBURB,
    "industrial_yard": _TOWN,
    "retail_park": _TOWN,
    "urban_block": _TOWN,
    "car_park": _TOWN,
    "waterfront": _TOWN,
}
"""Style of each theme. Scenes of other themes stay flat: old towns are paved, and rooms have no
land.
"""
