"""Mixed scenes: streets from which a drone can enter at least one building."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from aeroscene.corpus.curation.builder import Builder
from aeroscene.corpus.curation.composers.themes import Theme, compose_theme
from aeroscene.corpus.curation.composition import Composition
from aeroscene.corpus.curation.sites import Scale

_DENSE = Scale(side_m=(46.0, 60.0), roads_m=(5.6, 6.0, 6.4), parking_chance=0.35)
"""Towns: houses stand close, and streets are narrow."""
_SQUARE = ("square", "square", "square", "square", "market", "park")
"""Open places of a town; names that occur more often are drawn more often."""

THEMES: Mapping[str, Theme] = {
    "urban_block": Theme(
        weight=0.32,
        plans={"cross": 0.15, "tee": 0.4, "through": 0.45},
        fulness=1.08,
        always=[("offices",), _SQUARE, ("closed_block",)],
        others={
            "closed_block": 0.45,
            "shops": 0.2,
            "flats": 0.1,
            "clinic": 0.07,
            "school": 0.06,
            "parking": 0.06,
            "construction": 0.06,
        },
        scale=_DENSE,
    ),
    "residential_street": Theme(
        weight=0.24,
        plans={"curve": 0.25, "through": 0.2, "tee": 0.15, "cul_de_sac": 0.2, "loop": 0.2},
        fulness=0.98,
        always=[("furnished_house",), ("park", "school", "allotments")],
        others={"row_houses": 0.4, "houses": 0.34, "flats": 0.12, "park": 0.14},
        scale=Scale(side_m=(50.0, 68.0)),
    ),
    "industrial_yard": Theme(
        weight=0.15,
        plans={"through": 0.45, "tee": 0.35, "cul_de_sac": 0.2},
        fulness=0.98,
        always=[("warehouse",), ("offices", "yard")],
        others={"yard": 0.4, "depot": 0.25, "retail": 0.1, "construction": 0.15, "parking": 0.1},
        scale=Scale(side_m=(56.0, 82.0)),
    ),
    "campus": Theme(
        weight=0.1,
        plans={"through": 0.35, "tee": 0.4, "green_edge": 0.25},
        fulness=1.0,
        always=[("clinic", "school"), ("offices",), ("park", "sports_ground", "parking")],
        others={"offices": 0.1, "clinic": 0.2, "sports_ground": 0.25, "park": 0.25, "flats": 0.2},
        scale=Scale(side_m=(60.0, 86.0)),
    ),
    "waterfront": Theme(
        weight=0.1,
        plans={"shore": 0.5, "quay": 0.3, "canal": 0.2},
        fulness=0.98,
        always=[("offices",), ("market", "park", "square")],
        others={"closed_block": 0.35, "shops": 0.2, "flats": 0.15, "market": 0.15, "park": 0.15},
        terrace_chance=0.0,
        scale=Scale(side_m=(52.0, 70.0)),
    ),
    "hillside": Theme(
        weight=0.09,
        plans={"hillside": 1.0},
        fulness=0.92,
        always=[("furnished_house", "offices"), ("terraces",)],
        others={"houses": 0.35, "row_houses": 0.3, "flats": 0.1, "park": 0.25},
        scale=Scale(side_m=(56.0, 78.0)),
    ),
}


def compose_mixed(builder: Builder, rng: np.random.Generator) -> Composition:
    """Compose one of the themes that have a building to enter.

    Args:
        builder: Empty builder of the scene.
        rng: Randomness of the layout.

    Raises:
        NoGroundError: If no site of the drawn theme has the parcels that it needs.
    """
    return compose_theme(builder, rng, THEMES)
