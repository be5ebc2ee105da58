"""Foreground: the pixels of a depth image that the map does not explain, and their blobs.

Anything that moves shows as pixels off the map. A fixed distance would not do: far pixels err by
metres. A pixel is explained if the map has a surface near its point, or near a point on its line of
sight within the error of depth, which grows with its square.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from autonomy.jit import kernel
from autonomy.perception.cell_distances import CellDistances, StaticDistance
from autonomy.perception.depth_image import DepthImage, sample

_STRIDE_PX, _FINE_PX = 2, 150.0
"""Step between the sampled pixels and rows, and focal length in pixels from which they are small
enough for such a step. At 10 m a small drone has five pixels in a view of 107 degrees."""
_SIGMAS = 4.0
# Places along the error of depth at which a surface is sought, as shares of it; near ones first.
_ALONG_SIGHT = (-0.5, 0.5, -1.0, 1.0)
_BRIDGED = 2  # samples apart that still belong together


@dataclass(frozen=True, kw_only=True, eq=False)
class Foreground:
    """Samples of an image that the map does not explain, row by row."""

    points_enu_m: Float[np.ndarray, "n 3"]
    stride_px: int
    """Step between the sampled pixels and rows."""
    pixels: Int[np.ndarray, "n 2"]
    """Row and column of each sample in the image."""
    depth_m: Float[np.ndarray, " n"]
    static_distance_m: Float[np.ndarray, " n"]
    """Distance from each point to the nearest surface of the map."""


def find_foreground(
    image: DepthImage,
    cells: CellDistances,
    static_distance_m: StaticDistance,
    *,
    within_m: float,
    range_m: float,
) -> Foreground:
    """Find the samples of an image, up to a range, that the map does not explain.

    Args:
        image: Image, posed in the frame of the map.
        cells: Cache of distances to the map.
        static_distance_m: Function that fills the cache.
        within_m: Distance within which a surface explains a point: the error of map, pose and
            cells.
        range_m: Greatest depth.
    """
    stride_px = _STRIDE_PX if image.fx >= _FINE_PX else 1
    points, pixels, depth_m = sample(image.pixels, stride_px, range_m)
    distance_m = cells.at(points, static_distance_m)
    far = np.flatnonzero(distance_m > within_m)
    points, pixels, depth_m, distance_m = points[far], pixels[far], depth_m[far], distance_m[far]
    # Parts of the lines of sight within the error of depth.
    sight = points - image.pixels.eye
    error = _SIGMAS * image.inverse_depth_sigma_pm * depth_m[:, None] * sight
    is_doubtful = distance_m <= within_m + np.linalg.norm(error, axis=1)
    is_explained = np.zeros(len(points), dtype=bool)
    for share in _ALONG_SIGHT:
        doubtful = np.flatnonzero(is_doubtful & ~is_explained)
        if not len(doubtful):
            break
        there = points[doubtful] + share * error[doubtful]
        is_explained[doubtful] = cells.at(there, static_distance_m) <= within_m
    kept = ~is_explained
    return Foreground(
        points_enu_m=points[kept],
        stride_px=stride_px,
        pixels=pixels[kept],
        depth_m=depth_m[kept],
        static_distance_m=distance_m[kept],
    )


def find_blobs(
    foreground: Foreground, image: DepthImage, *, gap_m: float, beyond_m: float, least_samples: int
) -> list[Int[np.ndarray, " k"]]:
    """Group samples that belong together, as indices, the largest blob first.

    Neighbours whose depths differ by less than `gap_m` plus noise belong to one blob. A blob counts
    if at least `least_samples` of its samples are farther than `beyond_m` from the map.
    """
    stride_px, error = foreground.stride_px, _SIGMAS * image.inverse_depth_sigma_pm
    n_rows, n_columns = (-(-n // stride_px) for n in image.depth_m.shape)
    places = foreground.pixels // stride_px
    labels = connect(places, foreground.depth_m, n_rows, n_columns, gap_m, error)
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
def connect(
    places: Int[np.ndarray, "n 2"],
    depths: Float[np.ndarray, " n"],
    n_rows: int,
    n_columns: int,
    gap: float,
    inverse_error: float,
) -> Int[np.ndarray, " n"]:
    """Label each sample, row by row, with the number of the first sample of its blob.

    Samples up to two apart, because thin parts have holes, belong together if their depths differ
    by less than `gap` plus `inverse_error` times the square of depth. The labels come from a
    union-find, so that one pass over the samples is enough.
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
        # Halving the path keeps later searches short.
        parent[i] = parent[parent[i]]
        i = parent[i]
    return i
