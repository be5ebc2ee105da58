"""From the number of a corpus scene to the scene."""

from __future__ import annotations

from dataclasses import replace
from math import ceil

import numpy as np

from aeroscene.curation.builder import Builder, Placed
from aeroscene.curation.draw import Draw
from aeroscene.curation.places import (
    Flats,
    Ground,
    Houses,
    Market,
    Offices,
    Park,
    Parking,
    Place,
    Yard,
)
from aeroscene.curation.site import Site, lay_out_site
from aeroscene.curation.start import place_start, start_yaw
from aeroscene.curation.streets import furnish_streets
from aeroscene.landing import derive_landing_areas
from aeroscene.scene import Scene

# The geodetic origin that PX4's simulations use (Zurich), so that scripts written for it fit.
_LATITUDE_DEG = 47.397742
_LONGITUDE_DEG = 8.545594
_ALTITUDE_M = 488.0
_SEED_SPACE = 2026
"""Entropy of the corpus beside the scene's number."""
_CEILING_M = 10.0
"""Flight volume above the highest thing."""


def curate_scene(index: int) -> Scene:
    """Scene `index` of the procedural corpus; equal on every call."""
    streams = np.random.SeedSequence((_SEED_SPACE, index)).spawn(4)
    plan, choice, start, streets = (np.random.default_rng(stream) for stream in streams)
    builder = Builder(f"corpus-{index:04d}")
    site = lay_out_site(builder, plan)
    places = _choose_places(builder, site, choice)
    for place in places:
        place.structures()
    pad = place_start(builder, Draw(start), (site.half_x, site.half_y))
    furnish_streets(builder, Draw(streets), site)
    for place in places:
        place.details()
    scene = _finish(builder, site, pad, index)
    return replace(scene, interaction_areas=derive_landing_areas(scene))


def _choose_places(builder: Builder, site: Site, rng: np.random.Generator) -> list[Place]:
    """One furnished building for certain, open ground somewhere, the rest by chance."""
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


def _finish(builder: Builder, site: Site, pad: Placed, index: int) -> Scene:
    top = max(obj.bbox.p[2] + obj.bbox.s[2] / 2 for obj in builder.objects)
    return Scene(
        scene_id=builder.scene_id,
        domain="mixed",
        seed=index,
        extent_min_enu_m=(-site.half_x, -site.half_y, 0.0),
        extent_max_enu_m=(site.half_x, site.half_y, float(max(22, ceil(top + _CEILING_M)))),
        start_position_enu_m=(round(pad.frame.x, 4), round(pad.frame.y, 4), round(pad.top, 4)),
        start_yaw_rad=round(start_yaw(pad), 6),
        latitude_deg=_LATITUDE_DEG,
        longitude_deg=_LONGITUDE_DEG,
        altitude_m=_ALTITUDE_M,
        objects=tuple(builder.objects),
    )
