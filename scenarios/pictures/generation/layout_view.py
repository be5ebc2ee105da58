"""Boxes of a scene seen from above: coarse ones pale, fine ones in colour.

Layouts in the middle of a denoising cannot be rendered as scenes, because boxes overlap and float.
Flat boxes show them at any stage.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float
from PIL import Image, ImageDraw

from scenarios.pictures.lettering import PAPER_RGB, Picture

_COARSE_RGB, _FINE_RGB = (148, 172, 200), (226, 110, 54)
_COARSE_ALPHA, _FINE_ALPHA = 76, 158
_EDGE_SHADE = 0.72
_OVER = 4
"""Supersampling factor, which smooths edges."""
_FAR_PX = 1e5
"""Greatest coordinate of a corner that is drawn; boxes farther away are noise."""


@dataclass(frozen=True)
class Layout:
    """Upright boxes of one scene."""

    center_enu_m: Float[np.ndarray, "n 3"]
    heading: Float[np.ndarray, "n 2"]
    """Cosine and sine of the yaw."""
    size_m: Float[np.ndarray, "n 3"]
    is_coarse: Bool[np.ndarray, " n"]


def draw_layout(layout: Layout, width: int, half_span_m: float) -> Picture:
    """Return a square picture of boxes, north up, the origin in its middle.

    Args:
        layout: Boxes to draw.
        width: Width of the picture, pixels.
        half_span_m: Distance from the middle of the picture to its border.
    """
    side = width * _OVER
    picture = Image.new("RGB", (side, side), PAPER_RGB)
    draw = ImageDraw.Draw(picture, "RGBA")
    scale = side / (2 * half_span_m)
    # Pixels count downwards, north points up.
    corners_px = _footprints(layout) * [scale, -scale] + side / 2
    top_m = layout.center_enu_m[:, 2] + layout.size_m[:, 2] / 2
    # Coarse boxes come first, and within each level the lower ones, so that higher ones are seen.
    for i in np.lexsort((top_m, ~layout.is_coarse)):
        if np.abs(corners_px[i]).max() < _FAR_PX:
            _draw_box(draw, corners_px[i], is_coarse=bool(layout.is_coarse[i]))
    return np.array(picture.reduce(_OVER))


def _footprints(layout: Layout) -> Float[np.ndarray, "n 4 2"]:
    half = layout.size_m[:, None, :2] / 2
    local = half * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    c, s = layout.heading[:, :1], layout.heading[:, 1:]
    turned = [c * local[..., 0] - s * local[..., 1], s * local[..., 0] + c * local[..., 1]]
    return np.stack(turned, axis=-1) + layout.center_enu_m[:, None, :2]


def _draw_box(
    draw: ImageDraw.ImageDraw, corners_px: Float[np.ndarray, "4 2"], *, is_coarse: bool
) -> None:
    rgb, alpha = (_COARSE_RGB, _COARSE_ALPHA) if is_coarse else (_FINE_RGB, _FINE_ALPHA)
    ring = [(x, y) for x, y in corners_px.tolist()]
    edge = tuple(round(_EDGE_SHADE * value) for value in rgb)
    draw.polygon(ring, fill=(*rgb, alpha))
    # Two corners are repeated, so that the last joint is rounded like the others.
    draw.line([*ring, *ring[:2]], fill=edge, width=_OVER // 2, joint="curve")
