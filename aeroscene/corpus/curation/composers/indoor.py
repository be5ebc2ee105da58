"""Indoor scenes: a building whose outer walls and roof bound the flight volume."""

from __future__ import annotations

from dataclasses import replace
from math import pi

import numpy as np

from aeroscene.corpus.curation.builder import Builder
from aeroscene.corpus.curation.composition import Composition
from aeroscene.corpus.curation.draw import Draw
from aeroscene.corpus.curation.frame import Frame
from aeroscene.corpus.curation.indoor.building import ROOF_M, raise_building
from aeroscene.corpus.curation.indoor.floor_plan import FloorPlan
from aeroscene.corpus.curation.indoor.place import IndoorPlace
from aeroscene.corpus.curation.indoor.themes import FINISHES, TALL_M, THEMES, Theme
from aeroscene.solids.shapes.materials import WALL_COLOURS


def compose_indoor(builder: Builder, rng: np.random.Generator) -> Composition:
    """Draw a theme, raise its floor plan, and let one place fill it.

    Args:
        builder: Empty builder of the scene.
        rng: Randomness of the layout.
    """
    # Streams of their own: a change to furniture then leaves plans and walls as they were.
    choice, layout, walls, furniture = rng.spawn(4)
    weights = np.array([theme.weight for theme in THEMES])
    theme = THEMES[int(choice.choice(len(THEMES), p=weights / weights.sum()))]
    turn = int(choice.integers(4))
    plan = draw_plan(Draw(layout), theme)
    building = raise_building(builder, Draw(walls), Frame(0.0, 0.0, turn * pi / 2), plan)
    place = IndoorPlace(builder, Draw(furniture), building, theme.features)
    # Odd quarter turns exchange the building's length and width.
    x, y = plan.size if turn % 2 == 0 else plan.size[::-1]
    return Composition(
        theme=theme.name,
        places=[place],
        extent_min_enu_m=(-x / 2, -y / 2, 0.0),
        extent_max_enu_m=(x / 2, y / 2, round(plan.height + ROOF_M, 4)),
        fulness=theme.fulness,
        place_start=place.place_start,
    )


def draw_plan(draw: Draw, theme: Theme) -> FloorPlan:
    """Draw size, height and zones of a building of a theme."""
    length_m, width_m, roof_m = theme.size_m
    is_tall = draw.chance(theme.tall_chance)
    share = theme.tall_share if is_tall else 1.0
    size = (_half_metres(draw, length_m, share), _half_metres(draw, width_m))
    # A tall building needs room for two storeys; halls of tall themes have it anyway.
    low, high = TALL_M if is_tall and roof_m[1] < TALL_M[0] else roof_m
    # Whole quarter metres, the pitch of the grid that plans and maps use.
    height = 0.25 * draw.count(round(4 * low), round(4 * high))
    programme = replace(theme.programme, is_tall=is_tall)
    return FloorPlan(
        name=theme.category,
        size=size,
        height=height,
        zones=theme.planner(draw, size, height, programme),
        finishes={kind: draw.one_of(options) for kind, options in FINISHES.items()},
        colour=draw.one_of((*WALL_COLOURS, "brick")),
    )


def _half_metres(draw: Draw, span: tuple[float, float], share: float = 1.0) -> float:
    return 0.5 * draw.count(round(2 * share * span[0]), round(2 * share * span[1]))
