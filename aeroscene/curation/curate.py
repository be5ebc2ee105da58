"""From the number of a corpus scene to the scene."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import ceil

import numpy as np

from aeroscene.corpus import scene_domain
from aeroscene.curation.builder import Builder, Placed
from aeroscene.curation.composers import compose_indoor, compose_mixed, compose_outdoor
from aeroscene.curation.composition import Composition, fill
from aeroscene.curation.start import start_yaw
from aeroscene.landing import derive_landing_areas
from aeroscene.scene import Scene

# The geodetic origin that PX4's simulations use (Zurich), so that scripts written for it fit.
_LATITUDE_DEG = 47.397742
_LONGITUDE_DEG = 8.545594
_ALTITUDE_M = 488.0
_SEED_SPACE = 2026
"""Entropy of the corpus beside the scene's number."""
_HEADROOM_M = 10.0
"""Flight volume above the highest thing, where the sky is open."""

_COMPOSERS = {"mixed": compose_mixed, "outdoor": compose_outdoor, "indoor": compose_indoor}


@dataclass(frozen=True, slots=True)
class Budget:
    """How many objects a scene should have."""

    n_coarse: int
    n_fine: int


def curate_scene(index: int) -> Scene:
    """Scene `index` of the procedural corpus; equal on every call."""
    streams = np.random.SeedSequence((_SEED_SPACE, index)).spawn(2)
    layout, size = (np.random.default_rng(stream) for stream in streams)
    budget = _draw_budget(size)
    builder = Builder(f"corpus-{index:04d}")
    domain = scene_domain(index)
    composition = _COMPOSERS[domain](builder, layout)
    places = composition.places
    fill([place.structures() for place in places], lambda: builder.n_coarse >= budget.n_coarse)
    pad = composition.place_start()
    fill([place.details() for place in places], lambda: builder.n_fine >= budget.n_fine)
    scene = _finish(builder, composition, pad, index)
    return replace(scene, interaction_areas=derive_landing_areas(scene))


def _draw_budget(rng: np.random.Generator) -> Budget:
    """Counts about the paper's averages, 34 coarse and 112 fine, each scene its own."""
    n_coarse, n_fine = rng.normal((34.0, 112.0), (6.0, 22.0)).clip((22, 60), (48, 170))
    return Budget(round(float(n_coarse)), round(float(n_fine)))


def _finish(builder: Builder, composition: Composition, pad: Placed, index: int) -> Scene:
    domain = scene_domain(index)
    x, y, ceiling = composition.extent_max_enu_m
    top = max(obj.bbox.p[2] + obj.bbox.s[2] / 2 for obj in builder.objects)
    if domain != "indoor":
        ceiling = float(max(ceiling, ceil(top + _HEADROOM_M)))
    return Scene(
        scene_id=builder.scene_id,
        domain=domain,
        seed=index,
        extent_min_enu_m=composition.extent_min_enu_m,
        extent_max_enu_m=(x, y, ceiling),
        start_position_enu_m=(round(pad.frame.x, 4), round(pad.frame.y, 4), round(pad.top, 4)),
        start_yaw_rad=round(start_yaw(pad), 6),
        latitude_deg=_LATITUDE_DEG,
        longitude_deg=_LONGITUDE_DEG,
        altitude_m=_ALTITUDE_M,
        objects=tuple(builder.objects),
    )
