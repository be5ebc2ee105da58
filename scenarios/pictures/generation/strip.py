"""How a scene came about, as a strip of pictures: noise, layouts, the scene.

The paper's figure of the generation sequence.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np

from aeroscene.files import replacing
from aeroscene.scene import Scene
from scenarios.dataset.sheet import ASPECT, draw_scene
from scenarios.pictures.generation.layout_view import (
    INK_RGB,
    PAPER_RGB,
    Layout,
    Picture,
    draw_layout,
)

N_MOMENTS = 5
"""Pictures of the denoising."""
_WIDTH = 300
_GAP_PX = 10
_TITLE_PX = 30
_FONT = cv2.FONT_HERSHEY_SIMPLEX


def chosen_steps(n_steps: int) -> tuple[int, ...]:
    """Steps to be drawn, the first and the last among them, more densely towards the end."""
    shares = 1.0 - (1.0 - np.linspace(0.0, 1.0, N_MOMENTS)) ** 1.5
    return tuple(dict.fromkeys(np.round(shares * (n_steps - 1)).astype(int).tolist()))


def layout_of(scene: Scene) -> Layout:
    """The boxes of a scene."""
    boxes = [obj.bbox for obj in scene.objects]
    yaw = np.array([box.yaw_rad for box in boxes])
    return Layout(
        center_enu_m=np.array([box.p for box in boxes]),
        heading=np.stack([np.cos(yaw), np.sin(yaw)], axis=1),
        size_m=np.array([box.s for box in boxes]),
        is_coarse=np.array([obj.is_coarse for obj in scene.objects]),
    )


def draw_strip(
    moments: Sequence[tuple[str, Layout]], half_span_m: float, scene: Scene | None, out: Path
) -> None:
    """Draw layouts beside each other, and then the scene that came of them.

    Args:
        moments: Titles and layouts, the noise first.
        half_span_m: From the middle of a layout's picture to its border.
        scene: The finished scene; None where it was rejected.
        out: PNG file, written whole or not at all.

    Raises:
        OSError: If the file cannot be written.
    """
    cells = [_titled(t, draw_layout(layout, _WIDTH, half_span_m)) for t, layout in moments]
    if scene is not None:
        cells.append(_titled("feasible", draw_layout(layout_of(scene), _WIDTH, half_span_m)))
        cells.append(_titled("scene", draw_scene(scene, round(_WIDTH * ASPECT))))
    gap = np.full((cells[0].shape[0], _GAP_PX, 3), PAPER_RGB, np.uint8)
    row = np.hstack([part for cell in cells for part in (gap, cell)] + [gap])
    is_encoded, png = cv2.imencode(".png", cv2.cvtColor(row, cv2.COLOR_RGB2BGR))
    assert is_encoded
    with replacing(out) as file:
        file.write(png.tobytes())


def _titled(title: str, picture: Picture) -> Picture:
    strip = np.full((_TITLE_PX, picture.shape[1], 3), PAPER_RGB, np.uint8)
    cv2.putText(strip, title, (2, 20), _FONT, 0.5, INK_RGB, 1, cv2.LINE_AA)
    foot = np.full((_GAP_PX, picture.shape[1], 3), PAPER_RGB, np.uint8)
    return np.vstack([strip, picture, foot])
