"""Curation of one scene of the corpus, given its number."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import ceil

import numpy as np

from aeroscene.areas.landing import AreaLimits, derive_interaction_areas
from aeroscene.corpus.corpus import scene_domain
from aeroscene.corpus.curation.builder import Builder, Placed
from aeroscene.corpus.curation.composers import compose_indoor, compose_mixed, compose_outdoor
from aeroscene.corpus.curation.composition import Composition, fill
from aeroscene.corpus.curation.start import start_yaw
from aeroscene.landform import raise_relief
from aeroscene.scene import Scene, SceneDomain
from aeroscene.scene.origin import ALTITUDE_M, LATITUDE_DEG, LONGITUDE_DEG

_SEED_SPACE = 2026
"""Entropy of the corpus, beside the scene's number."""
HEADROOM_M = 10.0
"""Height of the flight volume above the highest object under open sky."""

_Spread = tuple[float, float]

_COMPOSERS = {"mixed": compose_mixed, "outdoor": compose_outdoor, "indoor": compose_indoor}


_N_COARSE: dict[SceneDomain, _Spread] = {
    "mixed": (29.0, 3.5),
    "outdoor": (31.0, 4.0),
    "indoor": (27.0, 4.0),
}
_N_FINE: dict[SceneDomain, _Spread] = {
    "mixed": (119.0, 12.0),
    "outdoor": (108.5, 12.0),
    "indoor": (108.5, 12.0),
}
"""Mean and spread of the numbers of objects at which a scene is full.

Mixed scenes have more fine objects, because their rooms are as full as other rooms, in addition to
the objects outdoors.
"""
_UNDER_SKY: tuple[_Spread, ...] = ((61.5, 8.0), (14.0, 2.5), (12.5, 1.2), (20.0, 5.0))
_N_AREAS: dict[SceneDomain, tuple[_Spread, ...]] = {
    "mixed": _UNDER_SKY,
    "outdoor": _UNDER_SKY,
    "indoor": ((44.9, 8.0), (12.0, 2.5), (5.8, 1.2), (20.0, 5.0)),
}
"""Mean and spread of the most areas that a scene keeps: small, medium, large, perching.

Scenes with fewer areas keep all; the averages over all domains equal the paper's. Rooms offer fewer
areas than sites do, and hardly any to large drones, which need open floors or roofs.
"""
_OF_ALL: tuple[_Spread, ...] = ((31.0, 4.0), (108.5, 12.0), *_N_AREAS["indoor"])


@dataclass(frozen=True, slots=True)
class Budget:
    """Number of objects that a scene should have, and the most areas that it keeps."""

    n_coarse: int
    n_fine: int
    areas: AreaLimits


def curate_scene(index: int) -> Scene:
    """Return scene `index` of the procedural corpus; equal on every call.

    Args:
        index: Number of the scene, which is its seed and decides on its domain.

    Raises:
        NoGroundError: If no site of its theme has the parcels that it needs.
        NoStartError: If no place is open for the home pad.
    """
    # Streams of their own: the land changes nothing of the layout, and the size nothing of both.
    scene = raise_relief(curate_layout(index), _streams(index)[2])
    areas = derive_interaction_areas(scene, limits=_budget(index).areas)
    return replace(scene, interaction_areas=areas)


def most_landing_areas(index: int) -> int:
    """Return the greatest number of landing areas that scene `index` may have."""
    limits = _budget(index).areas
    return limits.small + limits.medium + limits.large


def curate_layout(index: int) -> Scene:
    """Return scene `index` on flat ground and without its areas.

    Areas take ten times as long as everything else together, so callers that only need the layout
    save most of the time.
    """
    budget = _budget(index)
    layout = _streams(index)[0]
    builder = Builder(f"corpus-{index:04d}")
    domain = scene_domain(index)
    composition = _COMPOSERS[domain](builder, layout)
    places = composition.places
    fill([place.structures() for place in places], lambda: builder.n_coarse >= budget.n_coarse)
    # The pad comes between structures and details: it needs solid ground, and nothing may block it.
    pad = composition.place_start()
    n_fine = round(composition.fulness * budget.n_fine)
    fill([place.details() for place in places], lambda: builder.n_fine >= n_fine)
    return _finish(builder, composition, pad, index)


def _streams(index: int) -> list[np.random.Generator]:
    """Randomness of a scene's layout, its size and its land, each a stream of its own."""
    streams = np.random.SeedSequence((_SEED_SPACE, index)).spawn(3)
    return [np.random.default_rng(stream) for stream in streams]


def _budget(index: int) -> Budget:
    return draw_budget(_streams(index)[1], scene_domain(index))


def draw_budget(rng: np.random.Generator, domain: SceneDomain | None = None) -> Budget:
    """Draw counts about the paper's averages, within two and a half spreads.

    Args:
        rng: Draws the counts.
        domain: Domain whose grammar is to be filled. None gives the averages over all scenes, for
            models that were trained before domains had budgets of their own.
    """
    rows = _OF_ALL if domain is None else (_N_COARSE[domain], _N_FINE[domain], *_N_AREAS[domain])
    means, spreads = np.array(rows).T
    counts = np.rint(means + spreads * rng.standard_normal(len(means)).clip(-2.5, 2.5))
    n_coarse, n_fine, *areas = (int(count) for count in counts)
    small, medium, large, perching = areas
    return Budget(
        n_coarse, n_fine, AreaLimits(small=small, medium=medium, large=large, perching=perching)
    )


def _finish(builder: Builder, composition: Composition, pad: Placed, index: int) -> Scene:
    domain = scene_domain(index)
    x, y, ceiling = composition.extent_max_enu_m
    top = max(obj.bbox.p[2] + obj.bbox.s[2] / 2 for obj in builder.objects)
    # An indoor scene ends at its roof; outdoors a drone may fly over everything.
    if domain != "indoor":
        ceiling = float(max(ceiling, ceil(top + HEADROOM_M)))
    return Scene(
        scene_id=builder.scene_id,
        domain=domain,
        seed=index,
        extent_min_enu_m=composition.extent_min_enu_m,
        extent_max_enu_m=(x, y, ceiling),
        start_position_enu_m=(round(pad.frame.x, 4), round(pad.frame.y, 4), round(pad.top, 4)),
        start_yaw_rad=round(start_yaw(pad), 6),
        latitude_deg=LATITUDE_DEG,
        longitude_deg=LONGITUDE_DEG,
        altitude_m=ALTITUDE_M,
        objects=tuple(builder.objects),
        theme=composition.theme,
    )
