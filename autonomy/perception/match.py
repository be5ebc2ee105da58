"""Match of a depth image with surfaces: the directions of offset and yaw that it determines.

A level floor says nothing about east and north. Fusing such an image in all directions would make
the anchor sure of a guess, so a match carries only the directions that the image supports.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from jaxtyping import Bool, Float

from autonomy.perception.depth_image import DepthImage
from autonomy.perception.point_spread import spread_points
from autonomy.perception.registration import View

N_POINTS = 700
# Fewer points, of `N_POINTS` sampled, make no match.
_LEAST_POINTS = 80
_LEAST_SUPPORT = 12.0
"""Number of points, of `N_POINTS`, that must lie across a direction to determine it."""
# Keeps the matrix invertible in a direction that the image does not determine.
_LEAST_INFORMATION = 1e-6
_DOUBTFUL_SHARE = 0.93  # inlier share below which a match is doubted; a right offset explains more


@dataclass(frozen=True, kw_only=True, eq=False)
class Match:
    """Fit of one image to the map."""

    objection: str | None
    """Reason not to use the match; None if it is good."""
    is_doubtful: bool
    """True if the map explains less of the image than it does at a right offset."""
    measured: Float[np.ndarray, " k"]
    """Measured values along `directions`."""
    directions: Float[np.ndarray, "4 k"]
    """Orthonormal directions of offset and yaw that the image determines."""
    variances: Float[np.ndarray, " k"]
    """Variances of the measured values."""
    is_angle: Bool[np.ndarray, " k"]
    """True for the direction that is the yaw."""
    residual_m: float
    inlier_share: float


class Matcher(Protocol):
    """Interface of the matchers that an anchor can use: `MapMatcher` and `SurfaceMatcher`."""

    def match(
        self, image: DepthImage, x: Float[np.ndarray, " 4"], covariance: Float[np.ndarray, "4 4"]
    ) -> Match:
        """Match an image, posed by the estimate, given the prior of offset and yaw."""
        ...

    def learn(self, image: DepthImage, x: Float[np.ndarray, " 4"]) -> None:
        """Add an image, posed by the estimate, whose offset and yaw are known by now."""
        ...


@dataclass(frozen=True, kw_only=True, eq=False)
class RegistrationResult:
    """Result of one registration."""

    x: Float[np.ndarray, " 4"]
    cost: float
    inlier_share: float
    residual_m: float
    information: Float[np.ndarray, "4 4"]
    support: Float[np.ndarray, "3 3"]


def viewed(
    image: DepthImage,
    x: Float[np.ndarray, " 4"],
    covariance: Float[np.ndarray, "4 4"],
    n_independent: float,
) -> View | Match:
    """Points of an image with the prior of offset and yaw; no match if there are too few.

    Args:
        image: The image, posed by the estimate.
        x: Prior of offset and yaw.
        covariance: Covariance of these.
        n_independent: Number of independent measurements that the image is worth, whatever its
            number of points, because neighbours err alike.
    """
    points, sigmas = spread_points(image, N_POINTS)
    if len(points) < _LEAST_POINTS:
        return no_match(f"{len(points)} points measured; wanted: {_LEAST_POINTS}")
    return View(
        points=points,
        sigmas=sigmas,
        camera=np.array(image.position_enu_m),
        prior=x,
        information=np.linalg.inv(covariance),
        worth=min(1.0, n_independent / len(points)),
    )


def determined(view: View, best: RegistrationResult) -> Match:
    """Match with the directions that enough points support: measured values and variances."""
    counts, axes = np.linalg.eigh(best.support * N_POINTS / len(view.points))
    columns = [np.append(axes[:, k], 0.0) for k in range(3) if counts[k] >= _LEAST_SUPPORT]
    level_support = np.linalg.eigvalsh(best.support[:2, :2])[-1] * N_POINTS / len(view.points)
    has_yaw = bool(columns) and level_support >= _LEAST_SUPPORT
    if has_yaw:
        columns.append(np.array([0.0, 0.0, 0.0, 1.0]))
    if not columns:
        return no_match("nothing of the map in view", best)
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


def no_match(objection: str, best: RegistrationResult | None = None) -> Match:
    """Match that determines nothing, with the reason and the best place that was found."""
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
