"""Outdoor scenes: streets, parks, yards, shores and hillsides under open sky."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from aeroscene.corpus.curation.builder import Builder
from aeroscene.corpus.curation.composers.themes import Theme, compose_theme
from aeroscene.corpus.curation.composition import Composition
from aeroscene.corpus.curation.sites import Scale

_DENSE = Scale(side_m=(48.0, 64.0), roads_m=(5.6, 6.0, 6.4), parking_chance=0.35)
"""Towns: houses stand close, and streets are narrow."""
_SQUARE = ("square", "square", "square", "square", "market", "park")
"""Open places of a town; names that occur more often are drawn more often."""

THEMES: Mapping[str, Theme] = {
    "urban_block": Theme(
        weight=0.17,
        plans={"cross": 0.15, "tee": 0.4, "through": 0.45},
        fulness=1.0,
        always=[("closed_block",), _SQUARE, ("closed_block", "shops")],
        others={
            "closed_block": 0.5,
            "shops": 0.16,
            "flats": 0.12,
            "school": 0.06,
            "square": 0.06,
            "parking": 0.05,
            "construction": 0.05,
        },
        scale=_DENSE,
    ),
    "old_town": Theme(
        weight=0.1,
        plans={"tee": 0.4, "through": 0.35, "curve": 0.25},
        fulness=1.0,
        always=[("square",), ("closed_block",), ("shops", "row_houses")],
        others={"closed_block": 0.45, "shops": 0.25, "row_houses": 0.2, "park": 0.1},
        terrace_chance=0.0,
        scale=_DENSE,
    ),
    "residential_street": Theme(
        weight=0.15,
        plans={"curve": 0.3, "cul_de_sac": 0.2, "loop": 0.2, "tee": 0.15, "through": 0.15},
        fulness=0.95,
        always=[("row_houses", "houses"), ("park", "school", "allotments")],
        others={"row_houses": 0.4, "houses": 0.36, "park": 0.06, "flats": 0.1, "terraces": 0.08},
        scale=Scale(side_m=(48.0, 66.0)),
    ),
    "village": Theme(
        weight=0.09,
        plans={"curve": 0.35, "through": 0.3, "tee": 0.35},
        fulness=0.9,
        always=[("farm",), ("houses",), ("allotments", "park", "square")],
        others={"houses": 0.45, "farm": 0.2, "allotments": 0.2, "terraces": 0.15},
        scale=Scale(side_m=(58.0, 82.0)),
    ),
    "park": Theme(
        weight=0.11,
        plans={"green_edge": 0.45, "paths": 0.35, "curve": 0.2},
        fulness=0.8,
        always=[("park",), ("sports_ground", "allotments", "park")],
        others={
            "park": 0.3,
            "sports_ground": 0.18,
            "allotments": 0.14,
            "market": 0.1,
            "terraces": 0.14,
            "row_houses": 0.14,
        },
        scale=Scale(side_m=(55.0, 84.0)),
    ),
    "industrial_yard": Theme(
        weight=0.1,
        plans={"through": 0.4, "tee": 0.35, "cul_de_sac": 0.25},
        fulness=0.95,
        always=[("depot",), ("yard",)],
        others={"yard": 0.3, "depot": 0.3, "retail": 0.1, "construction": 0.2, "parking": 0.1},
        scale=Scale(side_m=(55.0, 82.0)),
    ),
    "retail_park": Theme(
        weight=0.08,
        plans={"through": 0.4, "tee": 0.4, "cross": 0.2},
        fulness=1.05,
        always=[("retail",), ("filling_station", "parking")],
        others={
            "retail": 0.35,
            "parking": 0.2,
            "filling_station": 0.15,
            "station": 0.15,
            "shops": 0.15,
        },
        scale=Scale(side_m=(58.0, 84.0)),
    ),
    "waterfront": Theme(
        weight=0.12,
        plans={"shore": 0.45, "quay": 0.3, "canal": 0.25},
        fulness=0.95,
        always=[("market", "park", "square"), ("closed_block", "flats")],
        others={
            "closed_block": 0.3,
            "shops": 0.2,
            "flats": 0.15,
            "row_houses": 0.15,
            "market": 0.1,
            "yard": 0.1,
        },
        terrace_chance=0.0,
        scale=Scale(side_m=(50.0, 68.0)),
    ),
    "hillside": Theme(
        weight=0.08,
        plans={"hillside": 1.0},
        fulness=0.85,
        always=[("houses", "row_houses"), ("terraces",)],
        others={"houses": 0.3, "row_houses": 0.25, "terraces": 0.2, "flats": 0.1, "park": 0.15},
        terrace_chance=0.15,
        scale=Scale(side_m=(56.0, 78.0)),
    ),
}


def compose_outdoor(builder: Builder, rng: np.random.Generator) -> Composition:
    """Compose one of the themes of the open air.

    Args:
        builder: Empty builder of the scene.
        rng: Randomness of the layout.

    Raises:
        NoGroundError: If no site of the drawn theme has the parcels that it needs.
    """
    return compose_theme(builder, rng, THEMES)
