"""Outdoor scenes: streets, parks, yards, shores and hillsides under open sky."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from aeroscene.corpus.curation.builder import Builder
from aeroscene.corpus.curation.composers.themes import OPEN, Theme, compose_theme
from aeroscene.corpus.curation.composition import Composition

THEMES: Mapping[str, Theme] = {
    "urban_block": Theme(
        weight=0.18,
        plans={"cross": 0.3, "tee": 0.25, "square": 0.2, "curve": 0.15, "through": 0.1},
        fulness=0.98,
        always=[("flats",), OPEN],
        others={
            "flats": 0.34,
            "market": 0.14,
            "parking": 0.12,
            "park": 0.12,
            "school": 0.12,
            "station": 0.08,
            "construction": 0.08,
        },
    ),
    "residential_street": Theme(
        weight=0.17,
        plans={"curve": 0.3, "cul_de_sac": 0.25, "loop": 0.25, "tee": 0.1, "through": 0.1},
        fulness=0.85,
        always=[("houses",), ("park", "school")],
        others={"houses": 0.66, "park": 0.1, "school": 0.08, "flats": 0.08, "terraces": 0.08},
    ),
    "park": Theme(
        weight=0.14,
        plans={"green_edge": 0.45, "paths": 0.35, "curve": 0.2},
        fulness=0.75,
        always=[("park",)],
        others={"park": 0.38, "market": 0.16, "terraces": 0.2, "school": 0.14, "houses": 0.12},
    ),
    "industrial_yard": Theme(
        weight=0.13,
        plans={"through": 0.4, "tee": 0.35, "cul_de_sac": 0.25},
        fulness=0.9,
        always=[("depot",), ("yard",)],
        others={"yard": 0.3, "depot": 0.25, "parking": 0.2, "construction": 0.25},
    ),
    "car_park": Theme(
        weight=0.1,
        plans={"through": 0.4, "tee": 0.4, "cross": 0.2},
        fulness=1.0,
        always=[("parking",), ("parking",)],
        others={"parking": 0.34, "station": 0.22, "market": 0.22, "flats": 0.22},
    ),
    "waterfront": Theme(
        weight=0.15,
        plans={"shore": 0.4, "quay": 0.35, "canal": 0.25},
        fulness=0.9,
        always=[("market", "park"), ("flats",)],
        others={"market": 0.26, "flats": 0.3, "park": 0.22, "houses": 0.12, "yard": 0.1},
        terrace_chance=0.0,
    ),
    "hillside": Theme(
        weight=0.13,
        plans={"hillside": 1.0},
        fulness=0.8,
        always=[("houses",), ("terraces",)],
        others={"houses": 0.4, "terraces": 0.2, "flats": 0.15, "park": 0.25},
        terrace_chance=0.15,
    ),
}


def compose_outdoor(builder: Builder, rng: np.random.Generator) -> Composition:
    """One of the themes of the open air."""
    return compose_theme(builder, rng, THEMES)
