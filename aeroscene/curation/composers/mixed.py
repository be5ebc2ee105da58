"""Mixed scenes: an urban block in which a drone can leave the street and enter a building."""

from __future__ import annotations

from functools import partial

import numpy as np

from aeroscene.curation.builder import Builder
from aeroscene.curation.composition import Composition, Place
from aeroscene.curation.draw import Draw
from aeroscene.curation.places import Flats, Ground, Houses, Market, Offices, Park, Parking, Yard
from aeroscene.curation.site import Site, lay_out_site
from aeroscene.curation.start import place_start
from aeroscene.curation.streets import Streets


def compose_mixed(builder: Builder, rng: np.random.Generator) -> Composition:
    """Streets, one furnished building for certain, open ground somewhere, the rest by chance."""
    plan, choice, start, streets = rng.spawn(4)
    site = lay_out_site(builder, plan)
    return Composition(
        places=[*_choose_places(builder, site, choice), Streets(builder, Draw(streets), site)],
        extent_min_enu_m=(-site.half_x, -site.half_y, 0.0),
        extent_max_enu_m=(site.half_x, site.half_y, 22.0),
        place_start=partial(place_start, builder, Draw(start), (site.half_x, site.half_y)),
    )


def _choose_places(builder: Builder, site: Site, rng: np.random.Generator) -> list[Place]:
    parcels = list(site.parcels)
    order = [int(i) for i in rng.permutation(len(parcels))]
    kinds = ["offices", str(rng.choice(["park", "market", "parking"]))]
    others = ["houses", "flats", "yard", "park", "market", "parking", "furnished_house"]
    weights = [0.2, 0.24, 0.14, 0.12, 0.1, 0.1, 0.1]
    while len(kinds) < len(parcels):
        kind = str(rng.choice(others, p=weights))
        if kind not in kinds or kind in {"houses", "flats"}:
            kinds.append(kind)
    streams = rng.spawn(len(parcels))
    return [
        _place(kind, Ground(builder, Draw(stream), parcels[parcel]))
        for kind, parcel, stream in zip(kinds, order, streams, strict=False)
    ]


def _place(kind: str, ground: Ground) -> Place:
    match kind:
        case "offices":
            return Offices(ground)
        case "houses":
            return Houses(ground)
        case "furnished_house":
            return Houses(ground, is_furnished=True)
        case "flats":
            return Flats(ground)
        case "park":
            return Park(ground)
        case "market":
            return Market(ground)
        case "parking":
            return Parking(ground)
        case _:
            return Yard(ground)
