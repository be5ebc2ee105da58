"""Oriented boxes against each other: penetration depth, and slices of convex solids.

Penetration depth serves where an overlap has to be removed: unlike the shared volume (`overlap`),
it is not zero for boxes that are apart, and it is in metres along the shortest way out.

| symbol | name | unit |
|---|---|---|
| p | centre, ENU | m |
| q | unit quaternion wxyz, box to world | - |
| s | full local extents | m |

Batched functions accept any number of leading axes; a single box has none.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from jaxtyping import Float
from numpy.typing import ArrayLike

from aeroscene.scene.box import rotation_matrix


def layer(
    points: Float[np.ndarray, "n 3"], normal: Float[np.ndarray, " 3"], low: float, high: float
) -> Float[np.ndarray, "k 3"]:
    """Points whose hull is the part of the hull of `points` between two parallel planes.

    Args:
        points: Points that span a convex solid.
        normal: Unit normal of the planes.
        low: Least `normal @ x` that is kept; minus infinity keeps all.
        high: Greatest `normal @ x` that is kept; infinity keeps all.
    """
    height = points @ normal
    kept = [points[(height >= low) & (height <= high)]]
    if len(kept[0]) == len(points):
        return points
    # Every pair's crossing lies in the hull, and those of its edges are among them.
    first, second = _pairs(len(points))
    for level in (low, high):
        a, b = height[first] - level, height[second] - level
        is_crossing = (a < 0) != (b < 0)
        i, j = first[is_crossing], second[is_crossing]
        share = (a[is_crossing] / (a[is_crossing] - b[is_crossing]))[:, None]
        kept.append(points[i] + share * (points[j] - points[i]))
    return np.concatenate(kept)


@cache
def _pairs(count: int) -> tuple[np.ndarray, np.ndarray]:
    return np.triu_indices(count, 1)


def penetration_depth(
    p_a: ArrayLike, q_a: ArrayLike, s_a: ArrayLike, p_b: ArrayLike, q_b: ArrayLike, s_b: ArrayLike
) -> Float[np.ndarray, "*batch"]:
    """Depth in m by which boxes overlap: the least translation that separates them.

    The value is negative for boxes that are apart: minus the widest gap along a separating axis,
    which is a lower bound of their distance. Broadcasts over leading axes.

    Args:
        p_a: Centres of the first boxes, m.
        q_a: Quaternions wxyz of the first boxes.
        s_a: Full extents of the first boxes, m.
        p_b: Centres of the second boxes.
        q_b: Quaternions of the second boxes.
        s_b: Full extents of the second boxes.

    Source: separating axes, Gottschalk, Lin and Manocha 1996, "OBBTree".
    """
    rotation_a, rotation_b = rotation_matrix(q_a), rotation_matrix(q_b)
    offset = np.asarray(p_b, dtype=float) - np.asarray(p_a, dtype=float)
    axes_a, axes_b = np.swapaxes(rotation_a, -1, -2), np.swapaxes(rotation_b, -1, -2)
    axes_a, axes_b = np.broadcast_arrays(axes_a, axes_b)
    crosses = np.cross(axes_a[..., :, None, :], axes_b[..., None, :, :])
    crosses = crosses.reshape(*crosses.shape[:-3], 9, 3)
    lengths = np.linalg.norm(crosses, axis=-1, keepdims=True)
    # Nearly parallel edges give no direction of their own: the face axes already cover them.
    units = np.where(lengths > 1e-6, crosses / np.maximum(lengths, 1e-6), axes_a[..., :1, :])
    axes = np.concatenate([axes_a, axes_b, units], axis=-2)
    reach = 0.5 * (_extent_along(axes, rotation_a, s_a) + _extent_along(axes, rotation_b, s_b))
    # The axis of least overlap is the shortest way apart; one negative entry separates the boxes.
    apart = np.abs(np.einsum("...ij,...j->...i", axes, offset))
    return (reach - apart).min(axis=-1)


def _extent_along(axes: np.ndarray, rotation: np.ndarray, s: ArrayLike) -> np.ndarray:
    return np.einsum("...ij,...j->...i", np.abs(axes @ rotation), np.asarray(s, dtype=float))
