"""A scene as a point: its contents, and their places, sizes, headings and neighbours.

A point consists of blocks of square roots of shares, each of norm one at most. The squared distance
of two scenes is then the sum over blocks of squared Hellinger distances (times two): every block
weighs the same, and nothing has to be scaled by the data.

    block      shares of                                                                 size
    content    objects by category                                                       70
    spread     objects of a level by distance from the middle, in half widths            2 x 6
    height     objects of a level by height of the centre                                2 x 9
    size       objects of a level by place of each extent in its category's range        2 x 3 x 6
    turn       objects of a level by yaw relative to the nearest neighbour, mod quarter  2 x 6
    relation   pairs of neighbours by both levels, distance and height                   4 x 63
    direction  pairs of neighbours by both levels and direction                          4 x 8

A level is coarse or fine.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float

from aeroscene.metrics.arrays import N_CATEGORIES, SceneArrays
from aeroscene.metrics.neighbours import (
    N_DIRECTIONS,
    N_DISTANCES,
    N_HEIGHTS,
    N_NEIGHBOURS,
    neighbours_of,
)
from aeroscene.scene.catalogue import CATALOGUE

# Edges of the bins of each block.
_SPREAD_EDGES = np.array([0.2, 0.4, 0.6, 0.8, 1.0])
_HEIGHT_EDGES_M = np.array([0.1, 0.3, 0.6, 1.0, 1.6, 2.5, 4.0, 8.0])
_SIZE_EDGES = np.array([0.0, 0.25, 0.5, 0.75, 1.0])
_TURN_EDGES_RAD = np.radians([0.5, 2.0, 5.0, 12.0, 25.0])

_RANGES_M = np.array(
    [
        (category.length_m, category.width_m, category.height_m)
        for _, category in sorted(CATALOGUE.items())
    ]
)
"""Ranges of the catalogue: (categories, axes, least and greatest)."""


def layout_features(scenes: Sequence[SceneArrays]) -> Float[np.ndarray, "n f"]:
    """Return the features of scenes, one row each.

    Rows of any two scenes can be compared, whatever their numbers of objects.
    """
    return np.array([_features(arrays) for arrays in scenes])


def _features(arrays: SceneArrays) -> Float[np.ndarray, " f"]:
    level = (~arrays.is_coarse).astype(int)
    near = neighbours_of(arrays)
    levels = 2 * level[near.first] + level[near.second]
    relation = near.distance * N_HEIGHTS + near.height
    sizes = [_shares((level, column), (2, 6)) for column in _size_bins(arrays).T]
    blocks = (
        _shares((arrays.category,), (N_CATEGORIES,)),
        _shares((level, _spread_bins(arrays)), (2, 6)),
        _shares((level, np.searchsorted(_HEIGHT_EDGES_M, arrays.centre_enu_m[:, 2])), (2, 9)),
        # Three histograms share one block, so they share its norm.
        np.concatenate(sizes) / len(sizes),
        _shares((level, _turn_bins(arrays, near.second)), (2, 6)),
        _shares((levels, relation), (4, N_DISTANCES * N_HEIGHTS)),
        _shares((levels, near.direction), (4, N_DIRECTIONS)),
    )
    return np.sqrt(np.concatenate(blocks))


def _shares(bins: tuple[np.ndarray, ...], shape: tuple[int, ...]) -> np.ndarray:
    """Histogram over cells as shares; zeros if nothing is counted."""
    cells = np.ravel_multi_index(bins, shape)
    return np.bincount(cells, minlength=int(np.prod(shape))) / max(len(cells), 1)


def _spread_bins(arrays: SceneArrays) -> np.ndarray:
    low, high = arrays.extent_enu_m[:, :2]
    offset = np.abs(arrays.centre_enu_m[:, :2] - (low + high) / 2) / ((high - low) / 2)
    return np.searchsorted(_SPREAD_EDGES, offset.max(axis=1, initial=0.0))


def _size_bins(arrays: SceneArrays) -> np.ndarray:
    low, high = np.moveaxis(_RANGES_M[arrays.category], -1, 0)
    return np.searchsorted(_SIZE_EDGES, (arrays.size_m - low) / (high - low))


def _turn_bins(arrays: SceneArrays, second: np.ndarray) -> np.ndarray:
    if not len(second):
        return np.zeros(arrays.n_objects, dtype=int)
    # The first of each object's neighbours is its nearest.
    nearest = second[:: min(N_NEIGHBOURS, arrays.n_objects - 1)]
    relative = arrays.yaw_rad - arrays.yaw_rad[nearest]
    quarter = np.pi / 2
    return np.searchsorted(
        _TURN_EDGES_RAD, np.abs(relative - quarter * np.round(relative / quarter))
    )
