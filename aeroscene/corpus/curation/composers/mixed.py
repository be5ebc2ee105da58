"""Mixed scenes: streets from which a drone can enter at least one building."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from aeroscene.corpus.curation.builder import Builder
from aeroscene.corpus.curation.composers.themes import OPEN, Theme, compose_theme
from aeroscene.corpus.curation.composition import Composition

THEMES: Mapping[str, Theme] = {
    "urban_block": Theme(
        weight=0.34,
        plans={"cross": 0.25, "tee": 0.25, "square": 0.15, "through": 0.2, "curve": 0.15},
        fulness=1.08,
        always=[("offices",), OPEN],
        others={
            "flats": 0.3,
            "offices": 0.04,
            "houses": 0.12,
            "market": 0.12,
            "parking": 0.12,
            "park": 0.1,
            "school": 0.08,
            "construction": 0.06,
        },
    ),
    "residential_street": Theme(
        weight=0.24,
        plans={"curve": 0.25, "through": 0.2, "tee": 0.15, "cul_de_sac": 0.2, "loop": 0.2},
        fulness=0.95,
        always=[("furnished_house",), ("park", "school")],
        others={"houses": 0.6, "furnished_house": 0.06, "flats": 0.14, "park": 0.2},
    ),
    "industrial_yard": Theme(
        weight=0.18,
        plans={"through": 0.45, "tee": 0.35, "cul_de_sac": 0.2},
        fulness=0.95,
        always=[("warehouse",), ("offices", "yard")],
        others={"yard": 0.4, "depot": 0.2, "parking": 0.2, "construction": 0.2},
    ),
    "waterfront": Theme(
        weight=0.13,
        plans={"shore": 0.5, "quay": 0.3, "canal": 0.2},
        fulness=0.95,
        always=[("offices",), ("market", "park")],
        others={"offices": 0.04, "market": 0.25, "flats": 0.35, "park": 0.3},
        terrace_chance=0.0,
    ),
    "hillside": Theme(
        weight=0.11,
        plans={"hillside": 1.0},
        fulness=0.9,
        always=[("furnished_house", "offices"), ("terraces",)],
        others={"houses": 0.5, "flats": 0.2, "park": 0.3},
    ),
}


def compose_mixed(builder: Builder, rng: np.random.Generator) -> Composition:
    """One of the themes with a building to enter."""
    return compose_theme(builder, rng, THEMES)
