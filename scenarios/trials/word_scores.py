"""Scores of a flight to a goal in words, as usual in vision-and-language navigation.

| score | meaning |
|---|---|
| navigation error | distance from the end of the flight to the nearest point of the place |
| oracle error | least distance to it at any time of the flight |
| SPL | success, weighted by the shortest path over the longer one of that and the flown path |

Sources: Anderson et al. 2018, "On Evaluation of Embodied Navigation Agents" (SPL); Anderson et al.
2018, "Vision-and-Language Navigation" (navigation error, oracle success).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from jaxtyping import Float

from aeroscene.scene import InteractionArea


@dataclass(frozen=True, kw_only=True, slots=True)
class WordScores:
    """Scores of one flight; all are None if nothing was flown."""

    navigation_error_m: float | None = None
    oracle_error_m: float | None = None
    path_m: float | None = None
    """Length of the flown path, with climb and descent."""


def score_words(
    flown_enu_m: Float[np.ndarray, "n 3"], areas: Sequence[InteractionArea]
) -> WordScores:
    """Score a flight.

    Args:
        flown_enu_m: True positions of the vehicle, close to each other.
        areas: Areas of the place that the text means.
    """
    if not len(flown_enu_m) or not areas:
        return WordScores()
    # The nearest point of the nearest area, at each time.
    away_m = np.min([_away_m(flown_enu_m, area) for area in areas], axis=0)
    path_m = np.linalg.norm(np.diff(flown_enu_m, axis=0), axis=1).sum()
    return WordScores(
        navigation_error_m=float(away_m[-1]),
        oracle_error_m=float(away_m.min()),
        path_m=float(path_m),
    )


def nearest_area(
    position_enu_m: Float[np.ndarray, " 3"], areas: Sequence[InteractionArea]
) -> InteractionArea:
    """Return the area that is nearest to a position."""
    away_m = [float(_away_m(position_enu_m[None], area)[0]) for area in areas]
    return areas[int(np.argmin(away_m))]


def spl(*, success: bool, way_m: float, path_m: float) -> float:
    """Return the success weighted by path length, 0 to 1.

    Args:
        success: True if the flight ended as it should.
        way_m: Length of the shortest path.
        path_m: Length of the flown path.
    """
    # The longer of both lengths: a flown path may be a little shorter than the cells' one.
    return float(success) * way_m / max(way_m, path_m, 1e-9)


def _away_m(points_enu_m: Float[np.ndarray, "n 3"], area: InteractionArea) -> np.ndarray:
    """Return the distance of points from an area, whose height is that of its centroid."""
    outline = shapely.Polygon([(x, y) for x, y, _ in area.polygon])
    shapely.prepare(outline)
    aside_m = shapely.distance(outline, shapely.points(points_enu_m[:, :2]))
    return np.hypot(aside_m, points_enu_m[:, 2] - area.centroid[2])
