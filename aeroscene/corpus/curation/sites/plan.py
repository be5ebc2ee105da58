"""Layout of a site, given the name of a plan."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import cos, floor, pi, sin

import numpy as np

from aeroscene.corpus.curation.builder import Builder
from aeroscene.corpus.curation.frame import Frame
from aeroscene.corpus.curation.site import PARKING_LANE_M, Site
from aeroscene.corpus.curation.sites.curve import lay_curve
from aeroscene.corpus.curation.sites.green import lay_green_edge, lay_paths
from aeroscene.corpus.curation.sites.grid import (
    lay_cross,
    lay_cul_de_sac,
    lay_loop,
    lay_square,
    lay_tee,
    lay_through,
)
from aeroscene.corpus.curation.sites.relief import lay_canal, lay_hillside, lay_quay, lay_shore
from aeroscene.solids.shapes.forms import FORMS

Plan = Callable[[Site, np.random.Generator], None]

PLANS: Mapping[str, Plan] = {
    "through": lay_through,
    "tee": lay_tee,
    "cross": lay_cross,
    "loop": lay_loop,
    "square": lay_square,
    "cul_de_sac": lay_cul_de_sac,
    "curve": lay_curve,
    "green_edge": lay_green_edge,
    "paths": lay_paths,
    "hillside": lay_hillside,
    "quay": lay_quay,
    "canal": lay_canal,
    "shore": lay_shore,
}
"""Plans under their names."""

_LEAST_SIDE_M: Mapping[str, float] = {
    "square": 76.0,
    "loop": 66.0,
    "curve": 72.0,
    "hillside": 64.0,
    "quay": 62.0,
    "canal": 66.0,
    "shore": 60.0,
}
"""Least sides of plans that need more ground than others."""
_LEAST_LIMIT_SHARE = 0.7
"""Least limit on the drawn sides, relative to the largest."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Scale:
    """Size of a site and width of its streets: towns are dense, yards are wide."""

    side_m: tuple[float, float] = (55.0, 95.0)
    """Range of the sides of the flight volume, which stands upright around the turned plan. A plan
    that needs more ground gets it.
    """
    roads_m: tuple[float, ...] = (6.0, 6.4, 7.0)
    """Widths of carriageways without their parking lanes."""
    parking_chance: float = 0.75
    """Probability that vehicles are parked along the streets, in plans with room for them."""


_PARKED_PLANS = frozenset(("through", "tee", "cross", "loop", "curve", "quay", "shore", "hillside"))
_PARKING: tuple[tuple[int, ...], ...] = ((-1,), (1,), (-1, 1))
"""Sides of the streets on which vehicles may be parked."""
_ALIGNED_CHANCE = 0.35


def lay_out_site(builder: Builder, rng: np.random.Generator, plan: str, scale: Scale) -> Site:
    """Draw size and orientation of a site and lay a plan's streets.

    Args:
        builder: Scene that receives the streets. Nothing leaves its flight volume from now on.
        rng: Randomness of the site.
        plan: One of `PLANS`.
        scale: Size of the site and width of its streets.
    """
    yaw = _draw_yaw(rng)
    least_m = max(scale.side_m[0], _LEAST_SIDE_M.get(plan, 0.0))
    half_x, half_y = _draw_half_sides(rng, yaw, (least_m, max(least_m, scale.side_m[1])))
    is_parked = plan in _PARKED_PLANS and rng.random() < scale.parking_chance
    parking = _PARKING[int(rng.integers(len(_PARKING)))] if is_parked else ()
    site = Site(
        builder=builder,
        frame=Frame(0.0, 0.0, yaw),
        half_x=half_x,
        half_y=half_y,
        road_m=float(rng.choice(scale.roads_m)) + PARKING_LANE_M * len(parking),
        walk_m=round(float(rng.uniform(1.8, 2.9)), 2),
        parking=parking,
        style={name: str(rng.choice(list(FORMS[name]))) for name in ("road", "sidewalk")},
    )
    east, north = site.half_extent
    builder.enclose((-east, -north), (east, north))
    PLANS[plan](site, rng)
    return site


def _draw_yaw(rng: np.random.Generator) -> float:
    """Draw a heading along the axes in about a third of the cases, else in any direction."""
    if rng.random() < _ALIGNED_CHANCE:
        return float(rng.integers(4)) * pi / 2
    return round(float(rng.uniform(-pi, pi)), 3)


def _draw_half_sides(
    rng: np.random.Generator, yaw: float, side_m: tuple[float, float]
) -> tuple[float, float]:
    """Draw half sides of a plan whose upright surroundings keep within a range."""
    low, high = side_m[0] / 2, side_m[1] / 2
    # Without a least limit the smallest sites would be drawn most often.
    least = min(max(low, _LEAST_LIMIT_SHARE * high), high)
    half_x, half_y, limit = rng.uniform((low, low, least), high).tolist()
    c, s = abs(cos(yaw)), abs(sin(yaw))
    reaches = (c * half_x + s * half_y, s * half_x + c * half_y)
    # First the largest reach is limited, then the smallest one is kept above the range's low end.
    scale = max(min(1.0, limit / max(reaches)), low / min(reaches))
    scale = min(scale, high / max(reaches))
    # Decimetres, rounded down to stay within the range.
    return (floor(10 * scale * half_x) / 10, floor(10 * scale * half_y) / 10)
