"""Boxes seen from above: coarse ones pale, fine ones in colour."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from jaxtyping import Bool, Float, UInt8

Picture = UInt8[np.ndarray, "height width 3"]

PAPER_RGB, INK_RGB, PALE_RGB = (250, 250, 248), (28, 32, 38), (112, 118, 126)
_COARSE_RGB, _FINE_RGB = (148, 172, 200), (226, 110, 54)
_COARSE_FILL, _FINE_FILL = 0.30, 0.62
_OVER = 2
"""Drawn larger by this and shrunk: smooth edges."""
_SHIFT = 4
"""Bits of a pixel that OpenCV is given."""
_FAR_PX = 1e5
"""Corners farther off are noise and would not fit OpenCV's integers."""


@dataclass(frozen=True)
class Layout:
    """Upright boxes of one scene."""

    center_enu_m: Float[np.ndarray, "n 3"]
    heading: Float[np.ndarray, "n 2"]
    """Cosine and sine of the yaw."""
    size_m: Float[np.ndarray, "n 3"]
    is_coarse: Bool[np.ndarray, " n"]


def draw_layout(layout: Layout, width: int, half_span_m: float) -> Picture:
    """A square picture of boxes, north up, the origin in its middle.

    Args:
        layout: The boxes.
        width: Of the picture, pixels.
        half_span_m: From the middle of the picture to its border.
    """
    side = width * _OVER
    picture = np.full((side, side, 3), PAPER_RGB, dtype=np.uint8)
    scale = side / (2 * half_span_m)
    corners_px = _footprints(layout) * [scale, -scale] + side / 2
    top_m = layout.center_enu_m[:, 2] + layout.size_m[:, 2] / 2
    # Coarse ones below; among each, what is on top is seen.
    for i in np.lexsort((top_m, ~layout.is_coarse)):
        if np.abs(corners_px[i]).max() < _FAR_PX:
            _draw_box(picture, corners_px[i], is_coarse=bool(layout.is_coarse[i]))
    return cv2.resize(picture, (width, width), interpolation=cv2.INTER_AREA)


def _footprints(layout: Layout) -> Float[np.ndarray, "n 4 2"]:
    half = layout.size_m[:, None, :2] / 2
    local = half * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    c, s = layout.heading[:, :1], layout.heading[:, 1:]
    turned = [c * local[..., 0] - s * local[..., 1], s * local[..., 0] + c * local[..., 1]]
    return np.stack(turned, axis=-1) + layout.center_enu_m[:, None, :2]


def _draw_box(picture: Picture, corners_px: Float[np.ndarray, "4 2"], *, is_coarse: bool) -> None:
    rgb = np.array(_COARSE_RGB if is_coarse else _FINE_RGB)
    ring = np.round(corners_px * 2**_SHIFT).astype(np.int32)
    low = np.clip(np.floor(corners_px.min(axis=0)).astype(int) - 2, 0, len(picture))
    high = np.clip(np.ceil(corners_px.max(axis=0)).astype(int) + 3, 0, len(picture))
    part = picture[low[1] : high[1], low[0] : high[0]]
    if part.size == 0:
        return
    mask = np.zeros(part.shape[:2], np.uint8)
    ring = ring - low * 2**_SHIFT
    cv2.fillPoly(mask, [ring], 255, cv2.LINE_AA, shift=_SHIFT)
    share = (mask / 255 * (_COARSE_FILL if is_coarse else _FINE_FILL))[..., None]
    part[:] = (part * (1 - share) + rgb * share + 0.5).astype(np.uint8)
    edge = tuple(int(v) for v in rgb * 0.72)
    cv2.polylines(part, [ring], True, edge, 1, cv2.LINE_AA, shift=_SHIFT)
