"""AirSim's kinds of images, from colours, depth and object ids."""

from __future__ import annotations

from enum import IntEnum

import numpy as np
from jaxtyping import Float, Int, UInt8

from flightsim.cameras import RgbdFrame

FARTHEST_M = 65504.0
"""Depth of the sky: the greatest number of AirSim's depth buffer."""
VISIBLE_M = 100.0
"""Depth that `DEPTH_VIS` draws white."""
BASELINE_M = 0.25
"""Distance of the second camera in `DISPARITY`."""


class ImageType(IntEnum):
    """Kinds of images, by AirSim's numbers."""

    SCENE = 0
    DEPTH_PLANAR = 1
    DEPTH_PERSPECTIVE = 2
    DEPTH_VIS = 3
    DISPARITY = 4
    SEGMENTATION = 5
    SURFACE_NORMALS = 6


DEPTHS = frozenset(
    {
        ImageType.DEPTH_PLANAR,
        ImageType.DEPTH_PERSPECTIVE,
        ImageType.DEPTH_VIS,
        ImageType.DISPARITY,
    }
)
"""Kinds whose pixels are numbers."""


def depth_values(frame: RgbdFrame, kind: ImageType) -> Float[np.ndarray, "height width"]:
    """Pixels of a kind of depth: metres, or shares from 0 to 1."""
    depth_m = frame.depth_m
    if kind is ImageType.DEPTH_VIS:
        return np.minimum(depth_m / np.float32(VISIBLE_M), np.float32(1.0))
    if kind is ImageType.DISPARITY:
        width = depth_m.shape[1]
        share = np.float32(BASELINE_M * frame.fx / width) / np.maximum(depth_m, np.float32(1e-3))
        return np.minimum(share, np.float32(1.0))
    if kind is ImageType.DEPTH_PERSPECTIVE:
        depth_m = depth_m * np.linalg.norm(_rays(frame), axis=2).astype(np.float32)
    return np.minimum(depth_m, np.float32(FARTHEST_M))


def depth_pixels(frame: RgbdFrame, kind: ImageType) -> UInt8[np.ndarray, "height width 3"]:
    """The same as grey: metres are drawn as `DEPTH_VIS` draws them."""
    values = depth_values(frame, kind)
    if kind in {ImageType.DEPTH_PLANAR, ImageType.DEPTH_PERSPECTIVE}:
        values = np.minimum(values / np.float32(VISIBLE_M), np.float32(1.0))
    grey = (255.0 * values + 0.5).astype(np.uint8)
    return np.repeat(grey[:, :, None], 3, axis=2)


def segment_pixels(
    object_ids: Int[np.ndarray, "height width"], segment_ids: dict[int, int]
) -> UInt8[np.ndarray, "height width 3"]:
    """Colour of each pixel's object, by the number that it has for segmentation."""
    seen, index = np.unique(object_ids, return_inverse=True)
    palette = np.array([segment_rgb(segment_ids.get(each, 0)) for each in seen.tolist()])
    return palette.astype(np.uint8)[index].reshape(*object_ids.shape, 3)


def segment_rgb(number: int) -> tuple[int, int, int]:
    """Colour of a number: its bits, by turns, from the highest bit of each channel on.

    Source: the colour map of the PASCAL VOC devkit.
    """
    r = g = b = 0
    for bit in range(7, -1, -1):
        r |= (number & 1) << bit
        g |= (number >> 1 & 1) << bit
        b |= (number >> 2 & 1) << bit
        number >>= 3
    return r, g, b


def normal_pixels(frame: RgbdFrame) -> UInt8[np.ndarray, "height width 3"]:
    """Normals of surfaces in the world: north, east and up from -1 to 1 as red, green and blue."""
    depth = frame.depth_m.astype(np.float64)
    is_seen = np.isfinite(depth)
    points = _rays(frame) * np.where(is_seen, depth, 0.0)[:, :, None]
    across = np.gradient(points, axis=1)
    down = np.gradient(points, axis=0)
    # In optical axes the product of right and down leads away from the camera.
    normals = -np.cross(across, down)
    length = np.linalg.norm(normals, axis=2, keepdims=True)
    normals /= np.maximum(length, 1e-12)
    east_north_up = normals @ frame.rotation_enu_from_optical.T
    north_east_up = east_north_up[:, :, [1, 0, 2]]
    pixels = np.clip(127.5 * (north_east_up + 1.0) + 0.5, 0, 255).astype(np.uint8)
    pixels[~is_seen] = 0
    return pixels


def veiled(
    frame: RgbdFrame, density_1pm: float, colour_rgb: tuple[int, int, int]
) -> UInt8[np.ndarray, "height width 3"]:
    """Colours behind fog or dust, which hide what is far by Beer and Lambert's law."""
    seen = np.exp(-density_1pm * np.minimum(frame.depth_m, FARTHEST_M))[:, :, None]
    rgb = seen * frame.rgb + (1.0 - seen) * np.array(colour_rgb)
    return (rgb + 0.5).astype(np.uint8)


def _rays(frame: RgbdFrame) -> Float[np.ndarray, "height width 3"]:
    """Direction of each pixel in optical axes, one metre deep."""
    height, width = frame.depth_m.shape
    x = (np.arange(width) - frame.cx) / frame.fx
    y = (np.arange(height) - frame.cy) / frame.fy
    rays = np.ones((height, width, 3))
    rays[:, :, 0], rays[:, :, 1] = x[None, :], y[:, None]
    return rays
