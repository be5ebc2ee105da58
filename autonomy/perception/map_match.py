"""Matches a depth image to a map, near the expected offset or in a search about it.

A registration converges only from nearby, and a search over all offsets would be slow. If the
offset is known to a third of a metre, one registration from there is enough. Otherwise a lattice of
offsets is scanned with a few points and the best nodes are registered. An image that two places
explain equally well is refused.
"""

from __future__ import annotations

import math

import numpy as np
from jaxtyping import Float

from autonomy.perception.depth_image import DepthImage
from autonomy.perception.match import Match, RegistrationResult, determined, no_match, viewed
from autonomy.perception.registration import View, appraise, register, scan
from autonomy.perception.solid_index import index_solids
from autonomy.planning.obstacles import Obstacles

_REACH_M = 1.0
"""Distance from which a surface pulls a point."""
# Independent measurements that an image is worth; points that the scan uses.
_N_INDEPENDENT = 25.0
_N_SCANNED = 70
_KNOWN_M = 0.35
"""Standard deviation of the offset above which a search is needed."""
_SCAN_SIGMAS = 2.5
_MAX_SCAN_REACH_M = 5.0
_NODES_PER_REACH = 4
"""Greatest number of nodes of the lattice from its middle to its edge."""
_SCAN_STEP_M = np.array([0.5, 0.5, 0.4])
"""Least distance between nodes."""
# Nodes that are registered with few points, and results that are registered with all.
_N_STARTS = 8
_N_PLACES = 3
_THINNING = 5
# Widths of the biweight, step by step, m: wide from a node of the lattice, narrow at the end.
_WIDE_M = np.array([1.0, 1.0, 0.8, 0.6, 0.4])
_NARROW_M = np.array([0.6, 0.4, 0.3, 0.2, 0.2])
_SAME_M = 0.35
_RIVAL_COST = 2.0
"""A second place whose cost is within this of the best makes the match ambiguous."""


class MapMatcher:
    """Matches depth images to one given map.

    Args:
        obstacles: Solids of the map.
    """

    def __init__(self, obstacles: Obstacles) -> None:
        self._grid = index_solids(obstacles, reach_m=_REACH_M)

    def match(
        self, image: DepthImage, x: Float[np.ndarray, " 4"], covariance: Float[np.ndarray, "4 4"]
    ) -> Match:
        """Match an image, posed by the estimate, given the prior of offset and yaw."""
        view = viewed(image, x, covariance, _N_INDEPENDENT)
        if isinstance(view, Match):
            return view
        starts = [x]
        if covariance[:3, :3].diagonal().max() > _KNOWN_M**2:
            starts = self._likely_places(_thinned(view), np.sqrt(covariance.diagonal()))
        found = self._settled(view, starts, _NARROW_M)
        best = found[0]
        rival = _rival(found)
        if rival is not None:
            return no_match(f"fits {math.dist(best.x[:3], rival.x[:3]):.1f} m away as well", best)
        return determined(view, best)

    def learn(self, image: DepthImage, x: Float[np.ndarray, " 4"]) -> None:
        """Learn nothing, because the map was given."""

    def _likely_places(self, view: View, deviations: np.ndarray) -> list[np.ndarray]:
        """Best nodes of a lattice about the prior, registered with a few points."""
        points = np.ascontiguousarray(view.points[:: max(1, len(view.points) // _N_SCANNED)])
        reach = np.minimum(_SCAN_SIGMAS * deviations[:3], _MAX_SCAN_REACH_M)
        step = np.maximum(reach / _NODES_PER_REACH, _SCAN_STEP_M)
        offsets, costs = scan(points, view.camera, view.prior, reach, step, self._grid)
        starts = [view.prior]
        for k in np.argsort(costs, kind="stable"):
            if len(starts) > _N_STARTS or not np.isfinite(costs[k]):
                break
            # Neighbours of a chosen node would lead to the same place.
            if all(np.any(np.abs(offsets[k] - s[:3]) > 1.01 * step) for s in starts[1:]):
                starts.append(np.append(offsets[k], view.prior[3]))
        places: list[np.ndarray] = []
        for found in self._settled(view, starts, _WIDE_M):
            if all(math.dist(found.x[:3], place[:3]) > _SAME_M for place in places):
                places.append(found.x)
        return places[:_N_PLACES]

    def _settled(
        self, view: View, starts: list[np.ndarray], widths: np.ndarray
    ) -> list[RegistrationResult]:
        """Results of registrations from several starts, the best first."""
        return sorted((self._settle(view, s, widths) for s in starts), key=lambda f: f.cost)

    def _settle(self, view: View, start: np.ndarray, widths: np.ndarray) -> RegistrationResult:
        """Register from a start, and appraise the result."""
        x = register(view, start, widths, self._grid)
        cost, share, residual_m, information, support = appraise(view, x, self._grid)
        away = x - view.prior
        return RegistrationResult(
            x=x,
            # Half the prior's Mahalanobis distance: the same unit as the points' cost.
            cost=cost + 0.5 * float(away @ view.information @ away),
            inlier_share=share,
            residual_m=residual_m,
            information=information,
            support=support,
        )


def _thinned(view: View) -> View:
    """View of every few points, weighted to be worth as much as all."""
    return view._replace(
        points=np.ascontiguousarray(view.points[::_THINNING]),
        sigmas=np.ascontiguousarray(view.sigmas[::_THINNING]),
        worth=view.worth * _THINNING,
    )


def _rival(found: list[RegistrationResult]) -> RegistrationResult | None:
    """Another place that fits about as well as the best, but lies outside its uncertainty."""
    best = found[0]
    for other in found[1:]:
        if other.cost > best.cost + _RIVAL_COST:
            return None
        away = other.x - best.x
        is_ruled_out = float(away @ best.information @ away) > 2.0 * _RIVAL_COST + 4.0
        if is_ruled_out and math.dist(other.x[:3], best.x[:3]) > _SAME_M:
            return other
    return None
