"""Surroundings of a site, by its theme."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

Range = tuple[float, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class NeighbourhoodStyle:
    """Density and look of the land around a site."""

    length_m: Range
    width_m: Range
    height_m: Range
    """Sizes of houses: depth from the street, width along it, and height with the roof."""
    walls: tuple[str, ...]
    roofs: tuple[str | None, ...]
    """Materials of the houses; None is a flat roof."""
    pitch: float
    """Rise of a gable roof over its half width."""
    spacing_m: float
    """Distance between two houses along a street."""
    setback_m: float
    """Distance of a house's front from the kerb."""
    n_houses: int
    """Most houses."""
    n_trees: int
    """Most trees."""
    is_rural: bool = False
    """True if fields begin behind the houses."""


_VILLAGE = NeighbourhoodStyle(
    length_m=(8, 10),
    width_m=(9, 13),
    height_m=(6, 8),
    walls=("plaster_cream", "brick"),
    roofs=("roof_red",),
    pitch=0.7,
    spacing_m=30.0,
    setback_m=6.0,
    n_houses=9,
    n_trees=30,
    is_rural=True,
)
_SUBURB = NeighbourhoodStyle(
    length_m=(8, 10),
    width_m=(9, 13),
    height_m=(6, 8.5),
    walls=("plaster_cream", "brick"),
    roofs=("roof_red", "roof_slate"),
    pitch=0.75,
    spacing_m=18.0,
    setback_m=5.0,
    n_houses=24,
    n_trees=22,
)
_TOWN = NeighbourhoodStyle(
    length_m=(11, 14),
    width_m=(14, 22),
    height_m=(9, 17),
    walls=("plaster_ochre", "brick"),
    roofs=(None,),
    pitch=0.0,
    spacing_m=25.0,
    setback_m=3.5,
    n_houses=20,
    n_trees=14,
)
_ESTATE = NeighbourhoodStyle(
    length_m=(14, 20),
    width_m=(18, 28),
    height_m=(6, 9),
    walls=("cladding_white", "brick"),
    roofs=("corrugated",),
    pitch=0.14,
    spacing_m=36.0,
    setback_m=7.0,
    n_houses=14,
    n_trees=14,
)
NEIGHBOURHOOD_STYLES: Mapping[str, NeighbourhoodStyle] = {
    "urban_block": _TOWN,
    "old_town": _TOWN,
    "car_park": _TOWN,
    "waterfront": _TOWN,
    "residential_street": _SUBURB,
    "campus": _SUBURB,
    "industrial_yard": _ESTATE,
    "retail_park": _ESTATE,
    "park": _VILLAGE,
    "hillside": _VILLAGE,
    "village": _VILLAGE,
}
"""Style of each theme; scenes of other themes, or without one, have nothing around them."""
LEAVES = ("leaves", "leaves_dark")
