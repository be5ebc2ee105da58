"""Depth images as evidence: cells along a line of sight are free, the one at its end is occupied.

An image is first drawn into marks on a block of cells of its own, and then added to the map in one
pass. So each image counts once for each cell, however many of its lines meet there, and the map's
own memory, which is far apart for neighbouring columns, is visited once. A hit counts more than a
pass, because many lines graze the neighbours of a surface.

- Ends of lines count for every pixel, except pixels whose depth too few of their neighbours share:
  stereo cameras match a few pixels with something else altogether.
- Passes are drawn by one line for a block of 3 x 3 pixels, up to the nearest depth of that block
  and the blocks beside it. Otherwise a thin pole between two lines, or a cell that holds the edge
  of something, would be called free.
- Shadows are drawn from the nearest depth of a block to the range. A cell that is partly in a
  shadow is not called free by that image, because part of the thing that casts it may be in the
  cell.
- A block without a measurement, as towards the sky, is free up to the nearest depth of a wider
  neighbourhood, at most the range.

Source: cells along a line as in Amanatides and Woo 1987, "A fast voxel traversal algorithm for ray
tracing"; bounded evidence as in Hornung et al. 2013 (OctoMap).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from autonomy.jit import kernel
from autonomy.perception.depth_image import DepthImage, Pixels

HIT, MISS = 3, 1
"""Evidence that an image adds to a cell in which a line ends, or takes from one that lines pass."""
MOST_FREE, MOST_OCCUPIED = -4, 12
"""Bounds of evidence, so that a cell that has changed is soon known to have."""
FREE_AT, OCCUPIED_AT = -2, 2
"""Evidence at which a cell is free, after two images that passed it, and at which it is
occupied."""
BLOCK_PX = 3
"""Width and height of a block of pixels: 12 cm at 8 m, where cells have 25 cm."""
ENDED, PASSED, SHADED = 1, 2, 4
"""Marks of a cell in one image: a line of sight ends in it, passes it, or is in a shadow there."""
_BORDER_CELLS = 2
"""Cells that a block has beyond the image on each side: rounding may lead a line a cell astray."""
_NEIGHBOURHOOD = 6
"""Number of neighbouring blocks on each side whose depth stands for a block that measured
nothing."""
_LEAST_DEPTH_M = 0.05
"""Depth up to which a pixel counts as not measured."""
_LEAST_ALIKE = 2
"""Number of the eight neighbouring pixels that must show the same surface."""
_ALIKE_SHARE = 0.05
"""Difference of depth within one surface from pixel to pixel, as a share of depth: a pixel is
0.3 degrees wide, so this holds up to an angle of incidence of 84 degrees."""
_ALIKE_SIGMAS = 4.0
"""Standard deviations of depth by which pixels of one surface may differ besides."""


class Frame(NamedTuple):
    """Block of cells that one image may show, as arrays for kernels.

    Its marks lie close together in memory, unlike the cells of the map. It may reach beyond the
    map, so that drawing needs no look at borders.
    """

    corner: np.ndarray
    """Lower corner of cell (0, 0, 0) of the map, ENU, m, (3,)."""
    resolution: float
    """Edge of a cell, m."""
    first: np.ndarray
    """First cell of the block in the map, (3,); the block may reach beyond the map."""
    marks: np.ndarray
    """`ENDED`, `PASSED` and `SHADED` of each cell of the block, zeros before the image."""


def frame_for(
    image: DepthImage, corner: Float[np.ndarray, " 3"], resolution_m: float, max_range_m: float
) -> Frame:
    """Return the block of all cells in which a line of sight of an image may be.

    Args:
        image: Depth image, posed in the map.
        corner: Lower corner of cell (0, 0, 0) of the map, ENU, m.
        resolution_m: Edge of a cell, m.
        max_range_m: Length of the longest line of sight, m.
    """
    eye = np.array(image.position_enu_m)
    ends = np.array([eye, *image.corners_enu_m(max_range_m)])
    # The pyramid reaches as deep as the range in its middle, so its corners are farther away.
    low = np.maximum(ends.min(axis=0), eye - max_range_m)
    high = np.minimum(ends.max(axis=0), eye + max_range_m)
    first = np.floor((low - corner) / resolution_m).astype(np.int64) - _BORDER_CELLS
    beyond = np.floor((high - corner) / resolution_m).astype(np.int64) + 1 + _BORDER_CELLS
    marks = np.zeros(tuple((beyond - first).tolist()), dtype=np.uint8)
    return Frame(corner, resolution_m, first, marks)


@kernel
def integrate(frame: Frame, pixels: Pixels, max_range: float, inverse_sigma: float) -> None:
    """Mark where the lines of sight of a depth image end, pass, and are in a shadow.

    Args:
        frame: Block of cells; its marks are changed in place.
        pixels: Image as kernels take it.
        max_range: Distance beyond which nothing counts, m.
        inverse_sigma: Standard deviation of inverse depth, 1/m.
    """
    _mark_ends(frame, pixels, max_range, inverse_sigma)
    nearest, sure = _nearest_of_blocks(pixels.depth)
    for a in range(nearest.shape[0]):
        y = (a * BLOCK_PX + 1 - pixels.cy) / pixels.fy
        for b in range(nearest.shape[1]):
            x = (b * BLOCK_PX + 1 - pixels.cx) / pixels.fx
            most = max_range / math.sqrt(x * x + y * y + 1.0)
            near = nearest[a, b]
            # Nothing was measured where it is infinite: then there is no shadow.
            if near < most:
                _mark_line(frame, pixels, x, y, near, most, SHADED)
            far = min(most, sure[a, b])
            # Two standard deviations nearer than measured, so that noise calls no surface free.
            far -= 2.0 * inverse_sigma * far * far
            if far > 0.0:
                _mark_line(frame, pixels, x, y, 0.0, far, PASSED)


@kernel
def weigh(frame: Frame, evidence: np.ndarray, was_free: np.ndarray) -> None:
    """Add the marks of an image to the evidence of the map's cells.

    Args:
        frame: Block of cells with the marks of one image.
        evidence: Evidence of each cell of the map, changed in place.
        was_free: Whether each cell was free since it last surely stood, changed in place.
    """
    first, marks = frame.first, frame.marks
    i_low, j_low, k_low = max(first[0], 0), max(first[1], 0), max(first[2], 0)
    i_high = min(first[0] + marks.shape[0], evidence.shape[0])
    j_high = min(first[1] + marks.shape[1], evidence.shape[1])
    k_high = min(first[2] + marks.shape[2], evidence.shape[2])
    for i in range(i_low, i_high):
        for j in range(j_low, j_high):
            for k in range(k_low, k_high):
                mark = marks[i - first[0], j - first[1], k - first[2]]
                each = evidence[i, j, k]
                if mark & ENDED:
                    each = min(each + HIT, MOST_OCCUPIED)
                    evidence[i, j, k] = each
                # A cell that is also in a shadow has two marks, and keeps its evidence.
                elif mark == PASSED:
                    each = max(each - MISS, MOST_FREE)
                    evidence[i, j, k] = each
                # Of all cells, not the marked ones alone: others are set free without an image.
                is_free = was_free[i, j, k] | (each <= FREE_AT)
                was_free[i, j, k] = is_free & (each < MOST_OCCUPIED)


@kernel
def _mark_ends(frame: Frame, pixels: Pixels, max_range: float, inverse_sigma: float) -> None:
    """Mark the cells in which lines of sight end; see `integrate` for the arguments."""
    depth, fx, fy, cx, cy, eye, rotation = pixels
    corner, resolution, first, marks = frame
    # The part of each ray that depends on the column alone is computed once.
    rays = np.empty((3, depth.shape[1]))
    for u in range(depth.shape[1]):
        x = (u - cx) / fx
        for axis in range(3):
            rays[axis, u] = rotation[axis, 0] * x
    for v in range(depth.shape[0]):
        y = (v - cy) / fy
        y_i, y_j, y_k = rotation[0, 1] * y, rotation[1, 1] * y, rotation[2, 1] * y
        for u in range(depth.shape[1]):
            d = depth[v, u]
            # Depth is at most the distance, and costs no root.
            if not (_LEAST_DEPTH_M < d <= max_range):
                continue
            # An end that may be two cells off is no evidence.
            if 2.0 * inverse_sigma * d * d > resolution:
                continue
            x = (u - cx) / fx
            if d * math.sqrt(x * x + y * y + 1.0) > max_range:
                continue
            p = eye[0] + d * (rays[0, u] + y_i + rotation[0, 2])
            q = eye[1] + d * (rays[1, u] + y_j + rotation[1, 2])
            r = eye[2] + d * (rays[2, u] + y_k + rotation[2, 2])
            i = math.floor((p - corner[0]) / resolution) - first[0]
            j = math.floor((q - corner[1]) / resolution) - first[1]
            k = math.floor((r - corner[2]) / resolution) - first[2]
            # Most pixels end where another one did, so what takes longest comes last.
            if not marks[i, j, k] and _is_borne_out(depth, v, u, inverse_sigma):
                marks[i, j, k] = ENDED


@kernel
def _is_borne_out(depth: np.ndarray, v: int, u: int, inverse_sigma: float) -> bool:
    """Return whether enough of the pixels around one show the same surface."""
    d = depth[v, u]
    most = _ALIKE_SHARE * d + _ALIKE_SIGMAS * inverse_sigma * d * d
    n_alike = 0
    for row in range(max(v - 1, 0), min(v + 2, depth.shape[0])):
        for column in range(max(u - 1, 0), min(u + 2, depth.shape[1])):
            n_alike += abs(depth[row, column] - d) <= most
    # The count contains the pixel itself, so one more than the least number is wanted.
    return n_alike > _LEAST_ALIKE


@kernel
def _nearest_of_blocks(
    depth: Float[np.ndarray, "h w"],
) -> tuple[Float[np.ndarray, "a b"], Float[np.ndarray, "a b"]]:
    """Return the least depth of each block of pixels, and of each block and the eight around it.

    The first is infinite for a block without a measurement. In the second, such a block counts as
    the least of its wider neighbourhood.
    """
    rows, columns = depth.shape[0] // BLOCK_PX, depth.shape[1] // BLOCK_PX
    nearest = np.full((rows, columns), np.inf, dtype=np.float32)
    for v in range(rows * BLOCK_PX):
        for u in range(columns * BLOCK_PX):
            d = depth[v, u]
            if _LEAST_DEPTH_M < d < nearest[v // BLOCK_PX, u // BLOCK_PX]:
                nearest[v // BLOCK_PX, u // BLOCK_PX] = d
    wider = _least_around(nearest, _NEIGHBOURHOOD)
    # Only holes are filled: a block that measured something counts as it is.
    filled = np.where(nearest < np.inf, nearest, wider)
    return nearest, _least_around(filled, 1)


@kernel
def _least_around(values: Float[np.ndarray, "a b"], reach: int) -> Float[np.ndarray, "a b"]:
    """Return the least value of a square around each entry, along rows first and then columns."""
    rows, columns = values.shape
    along, least = np.empty_like(values), np.empty_like(values)
    for a in range(rows):
        for b in range(columns):
            lowest = values[a, b]
            for c in range(max(b - reach, 0), min(b + reach + 1, columns)):
                lowest = min(lowest, values[a, c])
            along[a, b] = lowest
    # A square's least value is the least over rows of the least along each.
    for a in range(rows):
        least[a] = along[a]
        for c in range(max(a - reach, 0), min(a + reach + 1, rows)):
            for b in range(columns):
                least[a, b] = min(least[a, b], along[c, b])
    return least


@kernel
def _mark_line(
    frame: Frame, pixels: Pixels, x: float, y: float, near: float, far: float, mark: int
) -> None:
    """Mark the cells from one depth of a line of sight to before the cell at another depth.

    Args:
        frame: Block of cells; its marks are changed in place.
        pixels: Image, for its pose.
        x: Slope of the line to the right of the optical axis.
        y: Slope of the line below the optical axis.
        near: Depth at which the line begins, m.
        far: Depth at which it ends, m; the cell there is not marked.
        mark: Mark to add to each cell.
    """
    shape = frame.marks.shape
    marks = frame.marks.reshape(-1)
    i, i_last, i_turn, i_ahead, i_between = _crossings(frame, pixels, 0, x, y, near, far)
    j, j_last, j_turn, j_ahead, j_between = _crossings(frame, pixels, 1, x, y, near, far)
    k, k_last, k_turn, k_ahead, k_between = _crossings(frame, pixels, 2, x, y, near, far)
    # One index into the block, because three of them take longer than the rest of a step.
    at = (i * shape[1] + j) * shape[2] + k
    i_turn *= shape[1] * shape[2]
    j_turn *= shape[2]
    for _ in range(abs(i_last - i) + abs(j_last - j) + abs(k_last - k)):
        marks[at] |= mark
        # Which axis is next cannot be foretold, so choices of values are faster than branches.
        is_i = i_ahead <= j_ahead and i_ahead <= k_ahead
        is_j = not is_i and j_ahead < i_ahead and j_ahead <= k_ahead
        is_k = not is_i and not is_j
        at += i_turn if is_i else (j_turn if is_j else k_turn)
        i_ahead += i_between if is_i else 0.0
        j_ahead += j_between if is_j else 0.0
        k_ahead += k_between if is_k else 0.0


@kernel
def _crossings(
    frame: Frame, pixels: Pixels, axis: int, x: float, y: float, near: float, far: float
) -> tuple[int, int, int, float, float]:
    """Return the first and last cell of a line of sight along an axis, and where it crosses cells.

    Returns:
        First cell and last cell in the block, step from cell to cell, and as shares of the line the
        way to the first crossing and from one to the next; infinite if it never crosses.
    """
    rotation = pixels.rotation
    ray = rotation[axis, 0] * x + rotation[axis, 1] * y + rotation[axis, 2]
    ray = ray / frame.resolution
    at = (pixels.eye[axis] - frame.corner[axis]) / frame.resolution + near * ray
    way = (far - near) * ray
    cell, last = math.floor(at), math.floor(at + way)
    first = frame.first[axis]
    if way == 0.0:
        return cell - first, last - first, -1, np.inf, np.inf
    between = 1.0 / abs(way)
    if way > 0.0:
        return cell - first, last - first, 1, between * (cell + 1 - at), between
    return cell - first, last - first, -1, between * (at - cell), between
