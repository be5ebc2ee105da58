"""Matches a depth image to the surfaces that earlier ones showed.

In a place without a map, the first images are the best map there is. Every image that fits, or
shows something new, adds its points to those surfaces at its matched pose. So the estimate stays
tied to where the flight began, for as long as each image overlaps with earlier ones.
"""

from __future__ import annotations

import math

import numpy as np
from jaxtyping import Float

from autonomy.jit import kernel
from autonomy.perception.depth_image import DepthImage
from autonomy.perception.match import Match, RegistrationResult, determined, no_match, viewed
from autonomy.perception.point_spread import sample_points
from autonomy.perception.registration import INLIER_SIGMAS, View
from autonomy.perception.seen_surfaces import Surfaces, add_points, no_surfaces, plane_at
from autonomy.types import Vector3

_N_INDEPENDENT = 150.0
"""Independent measurements that an image is worth. Unlike a given map, one that was seen errs as
the images do, so more of them is independent."""
_GOOD_SIGMA_M = 0.06
"""Deviation up to which a point counts whole for a direction. A few that err more may all lie on
one surface that was seen wrongly."""
_LEAST_KNOWN = 60
"""Number of points that must lie in cells whose surface is known."""
_WIDTHS_M = np.array([0.4, 0.3, 0.2, 0.2, 0.2, 0.2])
"""Widths of the biweight, step by step. The last steps repeat, so that the search comes to rest:
the rest of a step would count as a measurement once the prior is removed."""
_LEARN_STRIDE = 3
_LEARN_SIGMA_M = 0.12
"""Deviation above which a point adds nothing to a surface."""


class SurfaceMatcher:
    """Matches depth images to the surfaces seen so far, and adds to them."""

    def __init__(self, low_enu_m: Vector3, high_enu_m: Vector3) -> None:
        """Start with nothing seen of a volume.

        Args:
            low_enu_m: Lower corner of the volume.
            high_enu_m: Upper corner of the volume.
        """
        self._surfaces = no_surfaces(low_enu_m, high_enu_m)

    def match(
        self, image: DepthImage, x: Float[np.ndarray, " 4"], covariance: Float[np.ndarray, "4 4"]
    ) -> Match:
        """Match an image, posed by the estimate, given the prior of offset and yaw."""
        view = viewed(image, x, covariance, _N_INDEPENDENT)
        if isinstance(view, Match):
            return view
        fitted = fit(view, _WIDTHS_M, self._surfaces)
        n_known, cost, share, residual_m, information, support = judge(view, fitted, self._surfaces)
        if n_known < _LEAST_KNOWN:
            return no_match(
                f"{n_known} points lie where surfaces are known; wanted: {_LEAST_KNOWN}"
            )
        found = RegistrationResult(
            x=fitted,
            cost=cost,
            inlier_share=share,
            residual_m=residual_m,
            information=information,
            support=support,
        )
        return determined(view, found)

    def learn(self, image: DepthImage, x: Float[np.ndarray, " 4"]) -> None:
        """Add the points of an image, posed by the estimate, at its offset and yaw."""
        points, sigmas = sample_points(image.pixels, _LEARN_STRIDE, image.inverse_depth_sigma_pm)
        points = points[sigmas < _LEARN_SIGMA_M]
        c, s = math.cos(x[3]), math.sin(x[3])
        turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        add_points(points @ turn.T + (np.array(image.position_enu_m) + x[:3]), self._surfaces)


@kernel
def fit(view: View, widths: Float[np.ndarray, " k"], surfaces: Surfaces) -> Float[np.ndarray, " 4"]:
    """Find the offset and yaw that lay the points onto surfaces, starting at the prior.

    The method is Gauss-Newton with Tukey's biweight, whose width shrinks from step to step, as in
    `registration`.
    """
    points, sigmas, camera, prior, prior_information, worth = view
    x = prior.copy()
    j = np.zeros(4)
    for width in widths:
        information = prior_information.copy()
        slope = prior_information @ (x - prior)
        for i in range(len(points)):
            d, spread = _deviation(points[i], camera, x, surfaces, j)
            if spread == 0.0:
                continue
            sigma = math.sqrt(sigmas[i] ** 2 + spread**2)
            cut = max(width, INLIER_SIGMAS * sigma)
            if abs(d) >= cut:
                continue
            weight = worth * (1.0 - (d / cut) ** 2) ** 2 / max(sigma, width / INLIER_SIGMAS) ** 2
            for a in range(4):
                slope[a] += weight * d * j[a]
                for b in range(4):
                    information[a, b] += weight * j[a] * j[b]
        x -= np.linalg.solve(information, slope)
    return x


@kernel
def judge(
    view: View, x: Float[np.ndarray, " 4"], surfaces: Surfaces
) -> tuple[int, float, float, float, Float[np.ndarray, "4 4"], Float[np.ndarray, "3 3"]]:
    """Judge how well points lie on surfaces.

    Returns:
        The number of points in cells whose surface is known, then of these: half the sum of squared
            deviations, as `worth` counts them; the share that lies at the surface; their mean
            distance in m; the information about offset and yaw; and how many good points lie across
            each direction.
    """
    points, sigmas, camera, _, _, worth = view
    information, support = np.zeros((4, 4)), np.zeros((3, 3))
    cost, away, n_inliers, n_known = 0.0, 0.0, 0, 0
    j = np.zeros(4)
    for i in range(len(points)):
        d, spread = _deviation(points[i], camera, x, surfaces, j)
        if spread == 0.0:
            continue
        n_known += 1
        sigma = math.sqrt(sigmas[i] ** 2 + spread**2)
        deviation = abs(d) / sigma
        if deviation >= INLIER_SIGMAS:
            cost += 0.5 * worth * INLIER_SIGMAS**2
            continue
        cost += 0.5 * worth * deviation**2
        n_inliers += 1
        away += abs(d)
        weight = worth * (1.0 - (deviation / INLIER_SIGMAS) ** 2) ** 2 / sigma**2
        for a in range(4):
            for b in range(4):
                information[a, b] += weight * j[a] * j[b]
        count = min(1.0, (_GOOD_SIGMA_M / sigma) ** 2)
        for a in range(3):
            for b in range(3):
                support[a, b] += count * j[a] * j[b]
    n = max(n_inliers, 1)
    return n_known, cost, n_inliers / max(n_known, 1), away / n, information, support


@kernel
def _deviation(
    point: np.ndarray, camera: np.ndarray, x: np.ndarray, surfaces: Surfaces, j: np.ndarray
) -> tuple[float, float]:
    """Distance of a point from its cell's plane, and the deviation of that; 0 without a plane.

    The derivative of the distance by offset and yaw is written to `j`.
    """
    c, s = math.cos(x[3]), math.sin(x[3])
    east = c * point[0] - s * point[1]
    north = s * point[0] + c * point[1]
    d, j[0], j[1], j[2], spread = plane_at(
        camera[0] + x[0] + east, camera[1] + x[1] + north, camera[2] + x[2] + point[2], surfaces
    )
    j[3] = j[1] * east - j[0] * north
    return d, spread
