"""Registration of a depth image with the surfaces of a map: offset (3) and yaw.

    symbol   name                                            unit
    c        camera, by the estimate                         m
    v_i      point i from the camera, by the estimate        m
    o, a     offset and yaw sought                           m, rad
    d_i, n_i signed distance of c + o + Rz(a) v_i, and its gradient

    J(o, a) = sum_i rho(d_i / s_i) + 1/2 (x - x0)^T P^-1 (x - x0),   x = (o, a)

is minimised by Gauss-Newton. The map is made of solids, not of points, so distances to surfaces
replace the pairs of points of the usual ICP. Each point pulls along the normal of the surface that
it lies at, so a level floor does not determine east and north, and the prior x0, P decides there.
rho is Tukey's biweight, whose width shrinks from step to step: first all points pull, at last only
those that the map explains.

Source: Chen and Medioni 1992, "Object modelling by registration of multiple range images" (distance
along normals); Fitzgibbon 2003, "Robust registration of 2D and 3D point sets" (distance fields).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from autonomy.jit import kernel
from autonomy.perception.solid_index import Grid, nearest_plane

INLIER_SIGMAS = 3.0
"""Standard deviations from the nearest surface beyond which the map does not explain a point."""
_SIGHT_EVERY = 4
"""Step between the lines of sight that are followed."""
_SIGHT_STEP_M = 0.05  # least step of a march along a line of sight
_GRAZING = 0.05
"""Cosine between normal and line of sight above which a surface is seen from behind."""
_BACKWARDS_M = (0.06, 0.12, 0.25, 0.5, 0.9)
"""Steps from a point in a solid back towards the camera, to find the side that was seen."""


class View(NamedTuple):
    """Points of an image, and the prior of offset and yaw."""

    points: Float[np.ndarray, "n 3"]
    """Points relative to the camera, ENU by the estimate, m."""
    sigmas: Float[np.ndarray, " n"]
    """Standard deviation of the distance of each from its surface, m."""
    camera: Float[np.ndarray, " 3"]
    """Position of the camera by the estimate, ENU, m."""
    prior: Float[np.ndarray, " 4"]
    information: Float[np.ndarray, "4 4"]
    """Inverse of the prior's covariance."""
    worth: float
    """Number of independent measurements that a point stands for; neighbours err alike."""


@kernel
def register(
    view: View, start: Float[np.ndarray, " 4"], widths: Float[np.ndarray, " k"], grid: Grid
) -> Float[np.ndarray, " 4"]:
    """Find the offset and yaw that lay the points onto surfaces.

    Args:
        view: Points and prior.
        start: Offset and yaw to begin from.
        widths: Widths of the biweight, step by step, m; a point's own width is the least.
        grid: Solids of the map.
    """
    points, sigmas, camera, prior, prior_information, worth = view
    x = start.copy()
    for width in widths:
        information = prior_information.copy()
        slope = prior_information @ (x - prior)
        c, s = math.cos(x[3]), math.sin(x[3])
        j = np.zeros(4)
        for i in range(len(points)):
            east = c * points[i, 0] - s * points[i, 1]
            north = s * points[i, 0] + c * points[i, 1]
            d, j[0], j[1], j[2] = _surface(camera, x, east, north, points[i, 2], grid)
            cut = max(width, INLIER_SIGMAS * sigmas[i])
            if abs(d) >= min(cut, grid.reach):
                continue
            # Derivative by the yaw: a turn moves the point by (-north, east).
            j[3] = j[1] * east - j[0] * north
            weight = (
                worth * (1.0 - (d / cut) ** 2) ** 2 / max(sigmas[i], width / INLIER_SIGMAS) ** 2
            )
            for a in range(4):
                slope[a] += weight * d * j[a]
                for b in range(4):
                    information[a, b] += weight * j[a] * j[b]
        x -= np.linalg.solve(information, slope)
    return x


@kernel
def appraise(
    view: View, x: Float[np.ndarray, " 4"], grid: Grid
) -> tuple[float, float, float, Float[np.ndarray, "4 4"], Float[np.ndarray, "3 3"]]:
    """Judge how well points lie on surfaces.

    Returns:
        Half the sum of squared deviations, with the deviations of unexplained points cut off, as
        `worth` counts them; the share of points that are explained, which lie at a surface and in
        sight; their mean distance in m; the information about offset and yaw; and a matrix (3, 3)
        whose eigenvalues are the numbers of points that lie across its directions.
    """
    points, sigmas, camera, _, _, worth = view
    information, support = np.zeros((4, 4)), np.zeros((3, 3))
    cost, away, n_inliers = 0.0, 0.0, 0
    n_sights, n_blocked = 0, 0
    c, s = math.cos(x[3]), math.sin(x[3])
    j = np.zeros(4)
    for i in range(len(points)):
        east = c * points[i, 0] - s * points[i, 1]
        north = s * points[i, 0] + c * points[i, 1]
        d, j[0], j[1], j[2] = _surface(camera, x, east, north, points[i, 2], grid)
        deviation = abs(d) / sigmas[i]
        if i % _SIGHT_EVERY == 0 and deviation < INLIER_SIGMAS:
            n_sights += 1
            if _is_blocked(camera, x, east, north, points[i, 2], sigmas[i], grid):
                n_blocked += 1
        if deviation >= INLIER_SIGMAS:
            cost += 0.5 * worth * INLIER_SIGMAS**2
            continue
        cost += 0.5 * worth * deviation**2
        n_inliers += 1
        away += abs(d)
        j[3] = j[1] * east - j[0] * north
        weight = worth * (1.0 - (deviation / INLIER_SIGMAS) ** 2) ** 2 / sigmas[i] ** 2
        for a in range(4):
            for b in range(4):
                information[a, b] += weight * j[a] * j[b]
        for a in range(3):
            for b in range(3):
                support[a, b] += j[a] * j[b]
    # Only every few lines are followed; their share stands for all explained points.
    blocked = n_blocked / max(n_sights, 1) * n_inliers
    cost += 0.5 * worth * INLIER_SIGMAS**2 * blocked
    share = (n_inliers - blocked) / len(points)
    return cost, share, away / max(n_inliers, 1), information, support


@kernel
def scan(
    points: Float[np.ndarray, "n 3"],
    camera: Float[np.ndarray, " 3"],
    center: Float[np.ndarray, " 4"],
    reach: Float[np.ndarray, " 3"],
    step: Float[np.ndarray, " 3"],
    grid: Grid,
) -> tuple[Float[np.ndarray, "m 3"], Float[np.ndarray, " m"]]:
    """Find offsets on a lattice, and the mean distance of points from surfaces at each of them.

    Distances are cut off at the grid's reach; the mean is infinite if the camera would be in a
    solid. The lattice extends by `reach` from `center`, an offset with the yaw, along each axis.
    """
    n = np.zeros(3, dtype=np.int64)
    for i in range(3):
        n[i] = math.floor(reach[i] / step[i])
    total = (2 * n[0] + 1) * (2 * n[1] + 1) * (2 * n[2] + 1)
    offsets, costs = np.empty((total, 3)), np.full(total, np.inf)
    c, s = math.cos(center[3]), math.sin(center[3])
    k = 0
    for a in range(-n[0], n[0] + 1):
        for b in range(-n[1], n[1] + 1):
            for e in range(-n[2], n[2] + 1):
                offset = offsets[k]
                offset[0] = center[0] + a * step[0]
                offset[1] = center[1] + b * step[1]
                offset[2] = center[2] + e * step[2]
                if _surface(camera, offset, 0.0, 0.0, 0.0, grid)[0] > 0.0:
                    away = 0.0
                    for i in range(len(points)):
                        east = c * points[i, 0] - s * points[i, 1]
                        north = s * points[i, 0] + c * points[i, 1]
                        d = _surface(camera, offset, east, north, points[i, 2], grid)[0]
                        away += min(abs(d), grid.reach)
                    costs[k] = away / len(points)
                k += 1
    return offsets, costs


@kernel
def _surface(
    camera: Float[np.ndarray, " 3"],
    x: Float[np.ndarray, " k"],
    east: float,
    north: float,
    up: float,
    grid: Grid,
) -> tuple[float, float, float, float]:
    """Signed distance of a point to the nearest surface that the camera can see, and its normal.

    A point that lies far into a thin wall is nearest to the far side, which the camera cannot have
    seen. The near side is found from a little nearer to the camera, and its plane continued. A
    point beyond an edge, with no solid on the line of sight, is drawn to the edge.
    """
    at_x, at_y, at_z = camera[0] + x[0] + east, camera[1] + x[1] + north, camera[2] + x[2] + up
    d, n, m, o, _ = nearest_plane(at_x, at_y, at_z, grid)
    away = math.sqrt(east * east + north * north + up * up)
    if away == 0.0 or d >= grid.reach or n * east + m * north + o * up <= _GRAZING * away:
        return d, n, m, o
    behind, is_through = (d, n, m, o), d < 0.0
    for back in _BACKWARDS_M:
        share = min(back / away, 1.0)
        near_x, near_y, near_z = at_x - share * east, at_y - share * north, at_z - share * up
        d, n, m, o, _ = nearest_plane(near_x, near_y, near_z, grid)
        is_through = is_through or d < 0.0
        along = n * east + m * north + o * up
        if is_through and d < grid.reach and along < 0.0:
            return d + share * along, n, m, o
    return (grid.reach, 0.0, 0.0, 0.0) if is_through else behind


@kernel
def _is_blocked(
    camera: Float[np.ndarray, " 3"],
    x: Float[np.ndarray, " 4"],
    east: float,
    north: float,
    up: float,
    sigma: float,
    grid: Grid,
) -> bool:
    """Return whether a solid stands between the camera and a point."""
    away = math.sqrt(east * east + north * north + up * up)
    end = away - 2.0 * INLIER_SIGMAS * sigma
    deep = -INLIER_SIGMAS * sigma
    t = 0.0
    while t < end:
        s = t / away
        d = nearest_plane(
            camera[0] + x[0] + s * east,
            camera[1] + x[1] + s * north,
            camera[2] + x[2] + s * up,
            grid,
        )[0]
        if d < max(deep, -0.08):
            return True
        t += max(d, _SIGHT_STEP_M)
    return False
