"""Depth images as evidence: cells along a line of sight are free, the one at its end is occupied.

Each image counts once for each cell, and a hit counts more than a pass, because many lines graze
the neighbours of a surface. Lines are taken for blocks of pixels, as far as the nearest pixel of a
block and its neighbours reaches, so that neither a thin pole between two lines is called free nor a
cell that holds the edge of something; the ends of all pixels' lines count, but of those that no
pixel beside them bears out: stereo cameras match a few with something else altogether. A cell that
is partly in the shadow of something is not called free by that image, because part of that thing
may be in it.
Where a block measured nothing, as towards the sky, it counts as free as far as the nearest
measurement of its neighbourhood, at most the range.

Source: cells along a line as in Amanatides and Woo 1987, "A fast voxel traversal algorithm for ray
tracing"; bounded evidence as in Hornung et al. 2013 (OctoMap).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from autonomy.jit import kernel
from autonomy.perception.depth_image import Pixels

HIT, MISS = 3, 1
MOST_FREE, MOST_OCCUPIED = -4, 12
FREE_AT, OCCUPIED_AT = -2, 2
"""Evidence at which a cell is free, after two images that passed it, and at which it is
occupied."""
BLOCK_PX = 3
_NEIGHBOURHOOD = 6
"""Number of neighbouring blocks on each side."""
_LEAST_DEPTH_M = 0.05
_LEAST_ALIKE = 2
"""Number of the eight pixels about one that must show the same surface."""
_ALIKE_SHARE = 0.05
"""Difference of depth within one surface from pixel to pixel, as a share of depth: a pixel is
0.3 degrees wide, so this holds up to an angle of incidence of 84 degrees."""
_ALIKE_SIGMAS = 4.0


class Cells(NamedTuple):
    """Evidence about the cells of a volume, as arrays for kernels."""

    evidence: np.ndarray
    """Positive for occupied, negative for free."""
    seen_in: np.ndarray
    """Number of the last image that counted for each cell."""
    corner: np.ndarray
    """Lower corner of cell (0, 0, 0), ENU, m, (3,)."""
    resolution: float
    """Edge of a cell, m."""


@kernel
def integrate(
    cells: Cells, number: int, pixels: Pixels, max_range: float, inverse_sigma: float
) -> None:
    """Add one depth image to the evidence of cells.

    Args:
        cells: Changed in place.
        number: Number of this image, 1 to 127, different from that of the image before.
        pixels: Image as kernels take it.
        max_range: Depth beyond which nothing is believed, m.
        inverse_sigma: Standard deviation of inverse depth, 1/m.
    """
    _mark_ends(cells, number, pixels, max_range, inverse_sigma)
    nearest, sure = _nearest_of_blocks(pixels.depth)
    for is_shadow in (True, False):
        for a in range(nearest.shape[0]):
            y = (a * BLOCK_PX + 1 - pixels.cy) / pixels.fy
            for b in range(nearest.shape[1]):
                x = (b * BLOCK_PX + 1 - pixels.cx) / pixels.fx
                near, far = 0.0, max_range / math.sqrt(x * x + y * y + 1.0)
                if is_shadow:
                    near = nearest[a, b]
                else:
                    far = min(far, sure[a, b])
                    far -= 2.0 * inverse_sigma * far * far
                if near < far:
                    _pass(cells, number, pixels, x, y, near, far, is_shadow)


@kernel
def _mark_ends(
    cells: Cells, number: int, pixels: Pixels, max_range: float, inverse_sigma: float
) -> None:
    """Mark the cells in which lines of sight end as occupied; see `integrate`."""
    depth, fx, fy, cx, cy, eye, rotation = pixels
    evidence, seen_in, corner, resolution = cells
    for v in range(depth.shape[0]):
        y = (v - cy) / fy
        for u in range(depth.shape[1]):
            d = depth[v, u]
            if not (_LEAST_DEPTH_M < d < np.inf):
                continue
            x = (u - cx) / fx
            # An end that may be two cells off is no evidence.
            if d * math.sqrt(x * x + y * y + 1.0) > max_range:
                continue
            if 2.0 * inverse_sigma * d * d > resolution:
                continue
            p = eye[0] + d * (rotation[0, 0] * x + rotation[0, 1] * y + rotation[0, 2])
            q = eye[1] + d * (rotation[1, 0] * x + rotation[1, 1] * y + rotation[1, 2])
            r = eye[2] + d * (rotation[2, 0] * x + rotation[2, 1] * y + rotation[2, 2])
            i = math.floor((p - corner[0]) / resolution)
            j = math.floor((q - corner[1]) / resolution)
            k = math.floor((r - corner[2]) / resolution)
            # Most pixels end where another one did, so what takes longest comes last.
            if (
                _is_inside(i, j, k, evidence)
                and seen_in[i, j, k] != number
                and _is_borne_out(depth, v, u, inverse_sigma)
            ):
                seen_in[i, j, k] = number
                evidence[i, j, k] = min(evidence[i, j, k] + HIT, MOST_OCCUPIED)


@kernel
def _is_borne_out(depth: np.ndarray, v: int, u: int, inverse_sigma: float) -> bool:
    """Whether enough pixels about one show the same surface as it does."""
    d = depth[v, u]
    most = _ALIKE_SHARE * d + _ALIKE_SIGMAS * inverse_sigma * d * d
    n_alike = 0
    for row in range(max(v - 1, 0), min(v + 2, depth.shape[0])):
        for column in range(max(u - 1, 0), min(u + 2, depth.shape[1])):
            n_alike += abs(depth[row, column] - d) <= most
    # It is like itself, too.
    return n_alike > _LEAST_ALIKE


@kernel
def _is_inside(i: int, j: int, k: int, cells: np.ndarray) -> bool:
    return 0 <= i < cells.shape[0] and 0 <= j < cells.shape[1] and 0 <= k < cells.shape[2]


@kernel
def _nearest_of_blocks(
    depth: Float[np.ndarray, "h w"],
) -> tuple[Float[np.ndarray, "a b"], Float[np.ndarray, "a b"]]:
    """Least depth of each block of pixels, inf without any, and of it and those beside it.

    In the second a block without any counts as the least of its wider neighbourhood.
    """
    rows, columns = depth.shape[0] // BLOCK_PX, depth.shape[1] // BLOCK_PX
    nearest = np.full((rows, columns), np.inf, dtype=np.float32)
    for v in range(rows * BLOCK_PX):
        for u in range(columns * BLOCK_PX):
            d = depth[v, u]
            if _LEAST_DEPTH_M < d < nearest[v // BLOCK_PX, u // BLOCK_PX]:
                nearest[v // BLOCK_PX, u // BLOCK_PX] = d
    wider = _least_around(nearest, _NEIGHBOURHOOD)
    filled = np.where(nearest < np.inf, nearest, wider)
    return nearest, _least_around(filled, 1)


@kernel
def _least_around(values: Float[np.ndarray, "a b"], reach: int) -> Float[np.ndarray, "a b"]:
    """Least value of a square about each entry."""
    rows, columns = values.shape
    along, least = np.empty_like(values), np.empty_like(values)
    for a in range(rows):
        for b in range(columns):
            lowest = values[a, b]
            for c in range(max(b - reach, 0), min(b + reach + 1, columns)):
                lowest = min(lowest, values[a, c])
            along[a, b] = lowest
    for a in range(rows):
        least[a] = along[a]
        for c in range(max(a - reach, 0), min(a + reach + 1, rows)):
            for b in range(columns):
                least[a, b] = min(least[a, b], along[c, b])
    return least


@kernel
def _pass(
    cells: Cells,
    number: int,
    pixels: Pixels,
    x: float,
    y: float,
    near: float,
    far: float,
    is_shadow: bool,
) -> None:
    """Mark the cells that a line of sight passes before its end as free.

    Those in a shadow are left as they are, and count as seen.
    """
    evidence, seen_in, _, _ = cells
    i, i_last, i_turn, i_ahead, i_between = _crossings(cells, pixels, 0, x, y, near, far)
    j, j_last, j_turn, j_ahead, j_between = _crossings(cells, pixels, 1, x, y, near, far)
    k, k_last, k_turn, k_ahead, k_between = _crossings(cells, pixels, 2, x, y, near, far)
    was_inside = False
    for _ in range(abs(i_last - i) + abs(j_last - j) + abs(k_last - k)):
        if _is_inside(i, j, k, evidence):
            was_inside = True
            if seen_in[i, j, k] != number:
                seen_in[i, j, k] = number
                if not is_shadow:
                    evidence[i, j, k] = max(evidence[i, j, k] - MISS, MOST_FREE)
        elif was_inside:
            # A straight line does not come back.
            return
        # Which axis is next cannot be foretold, so choices of values are faster than branches.
        is_i = i_ahead <= j_ahead and i_ahead <= k_ahead
        is_j = not is_i and j_ahead < i_ahead and j_ahead <= k_ahead
        is_k = not is_i and not is_j
        i += i_turn if is_i else 0
        j += j_turn if is_j else 0
        k += k_turn if is_k else 0
        i_ahead += i_between if is_i else 0.0
        j_ahead += j_between if is_j else 0.0
        k_ahead += k_between if is_k else 0.0


@kernel
def _crossings(
    cells: Cells, pixels: Pixels, axis: int, x: float, y: float, near: float, far: float
) -> tuple[int, int, int, float, float]:
    """First and last cell of a line of sight along an axis, and where it crosses between cells.

    Returns:
        First cell, last cell, step from cell to cell, and as shares of the line the way to the
        first crossing and from one to the next.
    """
    rotation = pixels.rotation
    ray = rotation[axis, 0] * x + rotation[axis, 1] * y + rotation[axis, 2]
    ray = ray / cells.resolution
    at = (pixels.eye[axis] - cells.corner[axis]) / cells.resolution + near * ray
    way = (far - near) * ray
    cell, last = math.floor(at), math.floor(at + way)
    if way == 0.0:
        return cell, last, -1, np.inf, np.inf
    between = 1.0 / abs(way)
    if way > 0.0:
        return cell, last, 1, between * (cell + 1 - at), between
    return cell, last, -1, between * (at - cell), between
