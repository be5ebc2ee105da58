"""Volume that boxes share, exactly and for many pairs at once.

Collision rates and the metrics count overlaps of thousands of pairs, where sampling points would be
slow and inexact. Upright boxes, nearly all of them, share a prism: the footprint of one, clipped by
the four sides of the other, times the height that they have in common. For tilted boxes, every face
is clipped by the six sides of the other box, and the remaining faces bound the shared solid:

    V = 1/3 sum over faces f of area(f) n_f . x_f     x_f any point of the face (divergence theorem)

Source: polygons are clipped after Sutherland and Hodgman 1974, "Reentrant polygon clipping".
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Float, Int

from aeroscene.scene.box import (
    CORNER_SIGNS,
    UPRIGHT_TOLERANCE,
    OrientedBox,
    box_corners,
    rotation_matrix,
)

_SAME_M = 1e-9
"""Distance below which two faces count as one. Back to back they bound nothing; if they face the
same way, the first box's face counts and the second's does not.
"""


def _rings() -> list[list[int]]:
    """Corners of each face in order around it; faces go -x, +x, -y, +y, -z, +z."""
    rings = []
    for axis in range(3):
        side = [(axis + 1) % 3, (axis + 2) % 3]
        for sign in (-1, 1):
            corners = np.flatnonzero(CORNER_SIGNS[:, axis] == sign)
            angle = np.arctan2(*CORNER_SIGNS[corners][:, side].T)
            rings.append(corners[np.argsort(angle)].tolist())
    return rings


_RINGS = np.array(_rings())
_FOOTPRINT = [0, 1, 3, 2]


def near_pairs(
    p: Float[np.ndarray, "n 3"], q: Float[np.ndarray, "n 4"], s: Float[np.ndarray, "n 3"]
) -> tuple[Int[np.ndarray, " pairs"], Int[np.ndarray, " pairs"]]:
    """Find pairs of boxes, each once, whose enclosing boxes along the axes of the world overlap.

    This cheap test comes before `pair_iou`: pairs that it leaves out cannot share a volume.
    """
    corners = box_corners(p, q, s)
    low, high = corners.min(axis=1), corners.max(axis=1)
    is_near = np.triu(np.ones((len(p), len(p)), dtype=bool), 1)
    for axis in range(3):
        is_near &= low[:, None, axis] < high[None, :, axis]
        is_near &= low[None, :, axis] < high[:, None, axis]
    first, second = np.nonzero(is_near)
    return first, second


def iou(first: OrientedBox, second: OrientedBox) -> float:
    """Exact intersection over union of the volumes of two boxes, 0 to 1."""
    boxes = (first.p, first.q, first.s, second.p, second.q, second.s)
    return float(pair_iou(*(np.array([values]) for values in boxes))[0])


def pair_iou(
    p_a: Float[np.ndarray, "n 3"],
    q_a: Float[np.ndarray, "n 4"],
    s_a: Float[np.ndarray, "n 3"],
    p_b: Float[np.ndarray, "n 3"],
    q_b: Float[np.ndarray, "n 4"],
    s_b: Float[np.ndarray, "n 3"],
) -> Float[np.ndarray, " n"]:
    """Exact intersection over union of pairs of boxes.

    Args:
        p_a: Centres, m.
        q_a: Unit quaternions wxyz.
        s_a: Full extents, m.
        p_b: Centres of the other boxes.
        q_b: Rotations of the other boxes.
        s_b: Full extents of the other boxes.
    """
    boxes = (p_a, q_a, s_a, p_b, q_b, s_b)
    tilt = np.maximum(*(np.hypot(q[:, 1], q[:, 2]) for q in (q_a, q_b)))
    is_upright = tilt < UPRIGHT_TOLERANCE
    shared = np.zeros(len(p_a))
    for chosen, shared_by in ((is_upright, _shared_upright), (~is_upright, _shared_tilted)):
        if chosen.any():
            shared[chosen] = shared_by(*(array[chosen] for array in boxes))
    # Faces that touch leave a rounding error of either sign.
    shared = np.maximum(shared, 0.0)
    return shared / (s_a.prod(axis=1) + s_b.prod(axis=1) - shared)


def _shared_upright(
    p_a: np.ndarray,
    q_a: np.ndarray,
    s_a: np.ndarray,
    p_b: np.ndarray,
    q_b: np.ndarray,
    s_b: np.ndarray,
) -> np.ndarray:
    low = np.maximum(p_a[:, 2] - s_a[:, 2] / 2, p_b[:, 2] - s_b[:, 2] / 2)
    high = np.minimum(p_a[:, 2] + s_a[:, 2] / 2, p_b[:, 2] + s_b[:, 2] / 2)
    # About the first box's centre, where rounding is least.
    polygons = box_corners(np.zeros_like(p_a), q_a, s_a)[:, _FOOTPRINT, :2]
    axes = rotation_matrix(q_b)[:, :2, :2]
    middle = (p_b - p_a)[:, :2]
    for axis in range(2):
        for sign in (-1.0, 1.0):
            normal = sign * axes[:, :, axis]
            offset = np.einsum("ni,ni->n", normal, middle) + s_b[:, axis] / 2
            polygons = _clip(polygons, normal, offset)
    x, y = polygons[..., 0], polygons[..., 1]
    area = 0.5 * (x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1)).sum(axis=1)
    return np.abs(area) * np.maximum(high - low, 0.0)


def _shared_tilted(
    p_a: np.ndarray,
    q_a: np.ndarray,
    s_a: np.ndarray,
    p_b: np.ndarray,
    q_b: np.ndarray,
    s_b: np.ndarray,
) -> np.ndarray:
    origin, apart = np.zeros_like(p_a), p_b - p_a
    first, second = (origin, q_a, s_a), (apart, q_b, s_b)
    return _bounded(first, second, alike_m=_SAME_M) + _bounded(second, first, alike_m=-_SAME_M)


_Boxes = tuple[np.ndarray, np.ndarray, np.ndarray]


def _bounded(faces_of: _Boxes, within: _Boxes, alike_m: float) -> np.ndarray:
    """Part of the divergence theorem's sum that the faces of one box contribute.

    Args:
        faces_of: The boxes whose faces are clipped.
        within: The boxes that clip them.
        alike_m: How far beyond a side a face may lie that looks the same way.
    """
    volume = np.zeros(len(faces_of[0]))
    corners = box_corners(*faces_of)
    normals, offsets = _planes(faces_of)
    sides, reach = _planes(within)
    is_alike = np.einsum("nfi,nsi->nfs", normals, sides) > 0.0
    margin_m = np.where(is_alike, alike_m, -_SAME_M)
    for face, ring in enumerate(_RINGS):
        polygons = corners[:, ring]
        for side in range(6):
            polygons = _clip(polygons, sides[:, side], reach[:, side] + margin_m[:, face, side])
        # The corners of the face are relative to its first one: repeated corners then add zero
        # area.
        edges = polygons - polygons[:, :1]
        doubled = np.cross(edges, np.roll(edges, -1, axis=1)).sum(axis=1)
        volume += np.linalg.norm(doubled, axis=1) / 2 * offsets[:, face] / 3
    return volume


def _planes(boxes: _Boxes) -> tuple[Float[np.ndarray, "n 6 3"], Float[np.ndarray, "n 6"]]:
    """Outward normals of the six faces, and the distance of each face along its normal."""
    p, q, s = boxes
    axes = np.swapaxes(rotation_matrix(q), -1, -2)
    normals = np.stack([-axes, axes], axis=2).reshape(-1, 6, 3)
    offsets = np.einsum("nfi,ni->nf", normals, p) + np.repeat(s / 2, 2, axis=1)
    return normals, offsets


def _clip(
    polygons: Float[np.ndarray, "n k d"],
    normal: Float[np.ndarray, "n d"],
    offset: Float[np.ndarray, " n"],
) -> Float[np.ndarray, "n k+1 d"]:
    """Clip convex polygons by a line or plane; the inner side `normal . x <= offset` remains.

    Arrays need one number of corners for all polygons. A polygon with fewer corners therefore
    repeats its first one, and one that is gone has equal corners throughout.
    """
    # Negative heights lie inside; a corner at height 0 is kept.
    height = np.einsum("nkd,nd->nk", polygons, normal) - offset[:, None]
    following, height_then = np.roll(polygons, -1, axis=1), np.roll(height, -1, axis=1)
    is_inside = height <= 0
    is_crossing = is_inside != np.roll(is_inside, -1, axis=1)
    # The divisor is replaced where no edge crosses, to avoid 0 / 0; those shares are not used.
    share = height / np.where(is_crossing, height - height_then, 1.0)
    crossings = polygons + share[..., None] * (following - polygons)
    n, k, d = polygons.shape
    corners = np.stack([polygons, crossings], axis=2).reshape(n, 2 * k, d)
    is_kept = np.stack([is_inside, is_crossing], axis=2).reshape(n, 2 * k)
    # A stable sort moves the kept corners to the front without changing their order. Clipping a
    # convex polygon by one line adds at most one corner.
    order = np.argsort(~is_kept, axis=1, kind="stable")[:, : k + 1]
    is_kept = np.take_along_axis(is_kept, order, axis=1)
    corners = np.take_along_axis(corners, order[..., None], axis=1)
    first = np.where(is_kept[:, :1, None], corners[:, :1], 0.0)
    return np.where(is_kept[..., None], corners, first)
