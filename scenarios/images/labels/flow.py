"""Dense optical flow between two poses, from depth, and from how each mover moves meanwhile."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from jaxtyping import Float, Int, UInt8

from scenarios.images.labels.projection import NEAR_M, Pinhole

NO_FLOW, HIDDEN, SEEN = 0, 1, 2
"""Kinds of pixels: without flow; the point is hidden or outside in the second image; it is seen."""
MOST_FLOW_PX = 511.0
"""Greatest flow along an axis; KITTI's images hold no more."""
_SAME_SHARE, _SAME_M = 0.02, 0.05
"""Share of a depth, and length, by which the second image may differ for the same point."""

RigidMotion = tuple[np.ndarray, np.ndarray]
"""Rotation (3, 3) and translation (3,) of a mover in ENU between the images."""


def optical_flow(
    first: Pinhole,
    second: Pinhole,
    depth_m: Float[np.ndarray, "h w"],
    second_depth_m: Float[np.ndarray, "h w"],
    ids: Int[np.ndarray, "h w"],
    motions: Mapping[int, RigidMotion],
) -> tuple[Float[np.ndarray, "h w 2"], UInt8[np.ndarray, "h w"]]:
    """Return how far the point of each pixel has moved in a second image.

    Points of the sky are at infinity, so that only the turn of the camera moves them.

    Args:
        first: Camera of the image.
        second: Camera of the second image, with the same lens.
        depth_m: Depth of the image, inf in the sky.
        second_depth_m: Depth of the second image.
        ids: Object of each pixel of the image.
        motions: Motion of each mover by its id.

    Returns:
        Flow in pixels to the right and down, and the kind of each pixel; 0 without flow.
    """
    is_sky = np.isinf(depth_m)
    rays = first.rays()
    points = rays * np.where(is_sky, 1.0, depth_m)[..., None]
    turn = first.pose.rotation_enu_from_optical
    back = second.pose.rotation_enu_from_optical.T
    # One rotation and one shift for all that stands: rays of the sky get the rotation alone.
    moved = points @ (back @ turn).T
    shift = back @ (first.pose.position_enu_m - second.pose.position_enu_m)
    moved[~is_sky] += shift
    for number, (rotation, translation) in motions.items():
        rows, columns = np.nonzero((ids == number) & ~is_sky)
        if len(rows):
            world = points[rows, columns] @ turn.T + first.pose.position_enu_m
            moved[rows, columns] = second.to_optical(world @ rotation.T + translation)
    ahead_m = moved[..., 2]
    is_ahead = ahead_m > NEAR_M
    moved[~is_ahead] = (0.0, 0.0, 1.0)
    target = second.pixels(moved)
    height, width = depth_m.shape
    grid = np.stack(np.meshgrid(np.arange(width), np.arange(height)), axis=-1)
    flow = target - grid
    kind = np.where(is_ahead & (np.abs(flow) <= MOST_FLOW_PX).all(axis=-1), HIDDEN, NO_FLOW)
    column, row = np.rint(target).astype(np.int64).transpose(2, 0, 1)
    is_inside = (column >= 0) & (column < width) & (row >= 0) & (row < height)
    there_m = second_depth_m[np.where(is_inside, row, 0), np.where(is_inside, column, 0)]
    with np.errstate(invalid="ignore"):
        is_same = np.abs(there_m - ahead_m) <= _SAME_SHARE * ahead_m + _SAME_M
    is_same = np.where(is_sky, np.isinf(there_m), is_same)
    kind[(kind == HIDDEN) & is_inside & is_same] = SEEN
    flow[kind == NO_FLOW] = 0.0
    return flow.astype(np.float32), kind.astype(np.uint8)
