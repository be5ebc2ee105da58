"""Landing and perching areas drawn into a picture, where nothing hides them.

The renderer knows nothing of areas, which are no solids. So each is projected as a polygon, and
shown at the pixels at which the plane of the polygon is not behind the depth that the renderer
found.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from PIL import Image, ImageDraw

from aeroscene.scene import InteractionArea
from flightsim.cameras import RgbdFrame

_RGB = {"small": (64, 150, 255), "medium": (60, 214, 110), "large": (255, 168, 40)}
_PERCHING_RGB = (226, 90, 226)
_FILL = 0.45  # opacity of the inside; outlines are opaque
_OVER = 4
"""Masks are drawn larger by this and shrunk: smooth edges."""
_IN_FRONT_M = 0.25
"""An area that lies this far behind what the picture shows is still drawn: grass, thin decor."""
# Areas with a corner nearer than this, or behind the eye, have no projection and are left out.
_NEAR_M = 0.1


def with_areas(frame: RgbdFrame, areas: Iterable[InteractionArea]) -> np.ndarray:
    """Draw the outlines of areas, filled in the colours of their classes, over a picture.

    Args:
        frame: Picture with depth and camera; it is not changed.
        areas: Areas in the frame's scene.

    Returns:
        (h, w, 3) uint8.
    """
    rgb = frame.rgb.copy()
    for area in areas:
        colour = _PERCHING_RGB if area.kind == "perching" else _RGB[area.drone_class]
        corners_px, depth_m = _projected(frame, np.array(area.polygon))
        if depth_m.min() < _NEAR_M:
            continue
        _draw(rgb, frame, corners_px, np.array(area.polygon), colour)
    return rgb


def _projected(frame: RgbdFrame, points_enu_m: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    # Rows of vectors: from the right the rotation acts as its inverse, ENU to optical.
    local = (points_enu_m - frame.position_enu_m) @ frame.rotation_enu_from_optical
    depth_m = local[:, 2]
    nearest = np.maximum(depth_m, 1e-6)
    u = frame.fx * local[:, 0] / nearest + frame.cx
    v = frame.fy * local[:, 1] / nearest + frame.cy
    return np.stack([u, v], axis=1), depth_m


def _draw(
    rgb: np.ndarray,
    frame: RgbdFrame,
    corners_px: np.ndarray,
    polygon_enu_m: np.ndarray,
    colour: tuple[int, int, int],
) -> None:
    height, width = frame.depth_m.shape
    # Corners this far outside belong to an area that lies almost in the plane of the eye.
    if np.abs(corners_px).max() > 1e5:
        return
    masks = [Image.new("L", (_OVER * width, _OVER * height)) for _ in range(2)]
    # A pixel's centre has whole coordinates, and Pillow counts from the pixel's corner.
    ring = [(x, y) for x, y in ((corners_px + 0.5) * _OVER).tolist()]
    ImageDraw.Draw(masks[0]).polygon(ring, fill=255)
    # The first edge is drawn twice, so that the first corner gets a joint too.
    ImageDraw.Draw(masks[1]).line([*ring, *ring[:2]], fill=255, width=2 * _OVER, joint="curve")
    inside, edge = (np.asarray(mask.reduce(_OVER)) for mask in masks)
    visible = _is_visible(frame, polygon_enu_m)
    for mask, share in ((inside, _FILL), (edge, 1.0)):
        blend = (mask / 255 * share * visible)[..., None]
        rgb[:] = (rgb * (1 - blend) + np.array(colour) * blend + 0.5).astype(np.uint8)


def _is_visible(frame: RgbdFrame, polygon_enu_m: np.ndarray) -> np.ndarray:
    """Pixels (h, w), bool, at which the polygon's plane is not behind what the picture shows."""
    middle = polygon_enu_m.mean(axis=0)
    # The direction in which the corners spread least is the normal of their plane.
    _, _, axes = np.linalg.svd(polygon_enu_m - middle)
    normal = axes[2]
    # Depth at which the ray of a pixel meets the plane; rays along it divide by zero.
    height, width = frame.depth_m.shape
    x = (np.arange(width) - frame.cx) / frame.fx
    y = (np.arange(height)[:, None] - frame.cy) / frame.fy
    right, down, forward = frame.rotation_enu_from_optical.T @ normal
    slope = x * right + y * down + forward
    with np.errstate(divide="ignore", invalid="ignore"):
        depth_m = ((middle - frame.position_enu_m) @ normal) / slope
    # A negative depth, behind the eye, passes too; no polygon's mask covers such pixels.
    return depth_m < frame.depth_m + _IN_FRONT_M
