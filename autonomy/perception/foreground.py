"""Foreground: the pixels of a depth image that show what the map does not have, and their blobs.

A pixel is explained if the map has a surface near its point, or near some point on its line of
sight that it may as well be showing: depth errs along that line, by its square.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from autonomy.jit import kernel
from autonomy.perception.cell_distances import CellDistances, StaticDistance
from autonomy.perception.depth_image import DepthImage

STRIDE_PX = 2
"""Every second pixel of every second row is looked at."""
_SIGMAS = 4.0
_ALONG_SIGHT = (-0.5, 0.5, -1.0, 1.0)
_BRIDGED = 2


@dataclass(frozen=True, kw_only=True, eq=False)
class Foreground:
    """Samples of an image, row by row."""

    points_enu_m: Float[np.ndarray, "n 3"]
    pixels: Int[np.ndarray, "n 2"]
    """Row and column, of the image."""
    depth_m: Float[np.ndarray, " n"]
    static_distance_m: Float[np.ndarray, " n"]
    """To what the map has."""


def find_foreground(
    image: DepthImage,
    cells: CellDistances,
    static_distance_m: StaticDistance,
    *,
    within_m: float,
    range_m: float,
    inverse_sigma_pm: float,
) -> Foreground:
    """Samples of an image that the map does not explain.

    Args:
        image: Posed by the estimate.
        cells: Remembers distances.
        static_distance_m: The map.
        within_m: A surface of the map explains what is so near: map, pose and cells err.
        range_m: Depth beyond which nothing is looked at.
        inverse_sigma_pm: Standard deviation of inverse depth.
    """
    eye = np.array(image.position_enu_m, dtype=float)
    points, pixels, depth_m = sample(
        np.ascontiguousarray(image.depth_m, dtype=np.float32),
        np.array([image.fx, image.fy, image.cx, image.cy], dtype=float),
        eye,
        np.ascontiguousarray(image.rotation_enu_from_optical, dtype=float),
        range_m,
    )
    distance_m = cells.at(points, static_distance_m)
    is_far = distance_m > within_m
    points, pixels, depth_m = points[is_far], pixels[is_far], depth_m[is_far]
    distance_m = distance_m[is_far]
    # Sight lines, as long as depth may err.
    error = _SIGMAS * inverse_sigma_pm * depth_m[:, None] * (points - eye)
    is_doubtful = distance_m <= within_m + np.linalg.norm(error, axis=1)
    is_explained = np.zeros(len(points), dtype=bool)
    for share in _ALONG_SIGHT:
        doubtful = np.flatnonzero(is_doubtful & ~is_explained)
        there = points[doubtful] + share * error[doubtful]
        is_explained[doubtful] = cells.at(there, static_distance_m) <= within_m
    kept = ~is_explained
    return Foreground(
        points_enu_m=points[kept],
        pixels=pixels[kept],
        depth_m=depth_m[kept],
        static_distance_m=distance_m[kept],
    )


def find_blobs(
    foreground: Foreground,
    shape: tuple[int, int],
    *,
    gap_m: float,
    inverse_sigma_pm: float,
    beyond_m: float,
    least_samples: int,
) -> list[Int[np.ndarray, " k"]]:
    """Samples that belong together, as indices, the largest blob first.

    Args:
        foreground: Of an image.
        shape: Of that image.
        gap_m: Neighbours whose depth differs by less, and what noise adds, are of one blob.
        inverse_sigma_pm: Standard deviation of inverse depth.
        beyond_m: A blob is one if some of its samples are farther than this from the map,
        least_samples: and if so many are.
    """
    labels = connect(
        foreground.pixels // STRIDE_PX,
        foreground.depth_m,
        (shape[0] + STRIDE_PX - 1) // STRIDE_PX,
        (shape[1] + STRIDE_PX - 1) // STRIDE_PX,
        gap_m,
        _SIGMAS * inverse_sigma_pm,
    )
    order = np.argsort(labels, kind="stable")
    borders = np.flatnonzero(np.diff(labels[order])) + 1
    is_beyond = foreground.static_distance_m > beyond_m
    blobs = [
        blob
        for blob in np.split(order, borders)
        if np.count_nonzero(is_beyond[blob]) >= least_samples
    ]
    return sorted(blobs, key=len, reverse=True)


@kernel
def sample(
    depth: Float[np.ndarray, "h w"],
    intrinsics: Float[np.ndarray, " 4"],
    position: Float[np.ndarray, " 3"],
    rotation: Float[np.ndarray, "3 3"],
    farthest: float,
) -> tuple[Float[np.ndarray, "n 3"], Int[np.ndarray, "n 2"], Float[np.ndarray, " n"]]:
    """Point, pixel and depth of every sample with a measurement."""
    fx, fy, cx, cy = intrinsics[0], intrinsics[1], intrinsics[2], intrinsics[3]
    most = (depth.shape[0] // STRIDE_PX + 1) * (depth.shape[1] // STRIDE_PX + 1)
    points, pixels = np.empty((most, 3)), np.empty((most, 2), dtype=np.int64)
    depths = np.empty(most)
    n = 0
    for v in range(0, depth.shape[0], STRIDE_PX):
        y = (v - cy) / fy
        for u in range(0, depth.shape[1], STRIDE_PX):
            d = depth[v, u]
            if 0.0 < d <= farthest:
                x = (u - cx) / fx
                for i in range(3):
                    ray = rotation[i, 0] * x + rotation[i, 1] * y + rotation[i, 2]
                    points[n, i] = position[i] + d * ray
                pixels[n, 0], pixels[n, 1] = v, u
                depths[n] = d
                n += 1
    return points[:n], pixels[:n], depths[:n]


@kernel
def connect(
    places: Int[np.ndarray, "n 2"],
    depths: Float[np.ndarray, " n"],
    n_rows: int,
    n_columns: int,
    gap: float,
    inverse_error: float,
) -> Int[np.ndarray, " n"]:
    """Label of the blob of each sample: the number of its first sample.

    Samples up to two apart hang together where their depths are alike: thin parts have holes.

    Args:
        places: Row and column of each sample on the grid of samples, row by row.
        depths: Of the samples.
        n_rows: Of the grid.
        n_columns: Of the grid.
        gap: Alike is what differs by less,
        inverse_error: and by this times the square of depth.
    """
    at = np.full((n_rows, n_columns), -1, dtype=np.int64)
    parent = np.arange(len(places))
    for i in range(len(places)):
        row, column = places[i]
        at[row, column] = i
        for r in range(max(row - _BRIDGED, 0), row + 1):
            for c in range(max(column - _BRIDGED, 0), min(column + _BRIDGED + 1, n_columns)):
                j = at[r, c]
                if j < 0 or j == i:
                    continue
                if abs(depths[i] - depths[j]) < gap + inverse_error * depths[i] * depths[i]:
                    a, b = _root(parent, i), _root(parent, j)
                    parent[max(a, b)] = min(a, b)
    for i in range(len(places)):
        parent[i] = _root(parent, i)
    return parent


@kernel
def _root(parent: Int[np.ndarray, " n"], i: int) -> int:
    while parent[i] != i:
        parent[i] = parent[parent[i]]
        i = parent[i]
    return i
