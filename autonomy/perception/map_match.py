"""Matches a depth image to a map, near the expected offset or in a search about it.

Where the offset is known to a third of a metre, one registration from there is enough. Otherwise a
lattice of offsets is scanned with a few points and the best nodes are registered; an image that two
places explain equally well is refused.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from autonomy.perception.depth_image import DepthImage
from autonomy.perception.point_spread import spread_points
from autonomy.perception.registration import View, appraise, register, scan
from autonomy.perception.solid_index import index_solids
from autonomy.planning.obstacles import Obstacles

_REACH_M = 1.0
"""Distance from which a surface pulls a point."""
_N_POINTS = 700
_N_SCANNED = 70
_LEAST_POINTS = 80
_INDEPENDENT = 25.0
"""Number of independent measurements that an image is worth, whatever its number of points."""
_LEAST_SUPPORT = 12.0
"""Number of points, of `_N_POINTS`, that must lie across a direction to determine it."""
_LEAST_INFORMATION = 1e-6
_KNOWN_M = 0.35
"""Standard deviation of the offset above which a search is needed."""
_SCAN_SIGMAS = 2.5
_MAX_SCAN_REACH_M = 5.0
_NODES_PER_REACH = 4
"""Most nodes of the lattice from its middle to its edge."""
_SCAN_STEP_M = np.array([0.5, 0.5, 0.4])
"""Least distance between nodes."""
_N_STARTS = 8
_N_PLACES = 3
_THINNING = 5
_WIDE_M = np.array([1.0, 1.0, 0.8, 0.6, 0.4])
_NARROW_M = np.array([0.6, 0.4, 0.3, 0.2, 0.2])
_SAME_M = 0.35
_DOUBTFUL_SHARE = 0.93
_RIVAL_COST = 2.0
"""Cost above the best within which a second place makes the match ambiguous."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Match:
    """Fit of one image to the map."""

    objection: str | None
    """Reason not to use the match; None if it is good."""
    is_doubtful: bool
    """Whether the map explains less of the image than it does at a right offset."""
    measured: Float[np.ndarray, " k"]
    """Measured values along `directions`."""
    directions: Float[np.ndarray, "4 k"]
    """Orthonormal directions of offset and yaw that the image determines."""
    variances: Float[np.ndarray, " k"]
    """Variances of the measured values."""
    is_angle: Bool[np.ndarray, " k"]
    """Whether each direction is that of yaw."""
    residual_m: float
    inlier_share: float


class MapMatcher:
    """Matches depth images to one map."""

    def __init__(self, obstacles: Obstacles) -> None:
        self._grid = index_solids(obstacles, reach_m=_REACH_M)

    def match(
        self, image: DepthImage, x: Float[np.ndarray, " 4"], covariance: Float[np.ndarray, "4 4"]
    ) -> Match:
        """Match an image, posed by the estimate, given the prior of offset and yaw."""
        points, sigmas = spread_points(image, _N_POINTS)
        if len(points) < _LEAST_POINTS:
            return _nothing(f"{len(points)} points measured; wanted: {_LEAST_POINTS}")
        view = View(
            points=points,
            sigmas=sigmas,
            camera=np.array(image.position_enu_m),
            prior=x,
            information=np.linalg.inv(covariance),
            worth=min(1.0, _INDEPENDENT / len(points)),
        )
        starts = [x]
        if covariance[:3, :3].diagonal().max() > _KNOWN_M**2:
            starts = self._likely_places(_thinned(view), np.sqrt(covariance.diagonal()))
        found = self._settled(view, starts, _NARROW_M)
        best = found[0]
        rival = _rival(found)
        if rival is not None:
            return _nothing(f"fits {math.dist(best.x[:3], rival.x[:3]):.1f} m away as well", best)
        return _seen(view, best)

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
            if all(np.any(np.abs(offsets[k] - s[:3]) > 1.01 * step) for s in starts[1:]):
                starts.append(np.append(offsets[k], view.prior[3]))
        places: list[np.ndarray] = []
        for found in self._settled(view, starts, _WIDE_M):
            if all(math.dist(found.x[:3], place[:3]) > _SAME_M for place in places):
                places.append(found.x)
        return places[:_N_PLACES]

    def _settled(self, view: View, starts: list[np.ndarray], widths: np.ndarray) -> list[_Found]:
        """Results of registrations from several starts, the best first."""
        return sorted((self._settle(view, s, widths) for s in starts), key=lambda f: f.cost)

    def _settle(self, view: View, start: np.ndarray, widths: np.ndarray) -> _Found:
        """Register from a start, and appraise the result."""
        x = register(view, start, widths, self._grid)
        cost, share, residual_m, information, support = appraise(view, x, self._grid)
        away = x - view.prior
        return _Found(
            x=x,
            cost=cost + 0.5 * float(away @ view.information @ away),
            inlier_share=share,
            residual_m=residual_m,
            information=information,
            support=support,
        )


@dataclass(frozen=True, kw_only=True, eq=False)
class _Found:
    """Result of one registration."""

    x: Float[np.ndarray, " 4"]
    cost: float
    inlier_share: float
    residual_m: float
    information: Float[np.ndarray, "4 4"]
    support: Float[np.ndarray, "3 3"]


def _thinned(view: View) -> View:
    """View of every few points, weighted to be worth as much as all."""
    return view._replace(
        points=np.ascontiguousarray(view.points[::_THINNING]),
        sigmas=np.ascontiguousarray(view.sigmas[::_THINNING]),
        worth=view.worth * _THINNING,
    )


def _rival(found: list[_Found]) -> _Found | None:
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


def _seen(view: View, best: _Found) -> Match:
    """Directions that enough points lie across, with measured values and variances."""
    counts, axes = np.linalg.eigh(best.support * _N_POINTS / len(view.points))
    columns = [np.append(axes[:, k], 0.0) for k in range(3) if counts[k] >= _LEAST_SUPPORT]
    level_support = np.linalg.eigvalsh(best.support[:2, :2])[-1] * _N_POINTS / len(view.points)
    has_yaw = bool(columns) and level_support >= _LEAST_SUPPORT
    if has_yaw:
        columns.append(np.array([0.0, 0.0, 0.0, 1.0]))
    if not columns:
        return _nothing("nothing of the map in view", best)
    directions = np.stack(columns, axis=1)
    # The registration contains the prior, which is removed again here.
    information = directions.T @ best.information @ directions
    covariance = np.linalg.inv(information + _LEAST_INFORMATION * np.eye(len(columns)))
    pulled = (best.information + view.information) @ (best.x - view.prior)
    measured = directions.T @ view.prior + covariance @ (directions.T @ pulled)
    return Match(
        objection=None,
        is_doubtful=best.inlier_share < _DOUBTFUL_SHARE,
        measured=measured,
        directions=directions,
        variances=covariance.diagonal(),
        is_angle=np.arange(len(columns)) == (len(columns) - 1 if has_yaw else -1),
        residual_m=best.residual_m,
        inlier_share=best.inlier_share,
    )


def _nothing(objection: str, best: _Found | None = None) -> Match:
    return Match(
        objection=objection,
        is_doubtful=best is not None and best.inlier_share < _DOUBTFUL_SHARE,
        measured=np.zeros(0),
        directions=np.zeros((4, 0)),
        variances=np.zeros(0),
        is_angle=np.zeros(0, dtype=bool),
        residual_m=math.nan if best is None else best.residual_m,
        inlier_share=0.0 if best is None else best.inlier_share,
    )
