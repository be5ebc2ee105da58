"""Generation of a scene as two rows of pictures: noise, layouts, the finished scene.

It corresponds to the paper's figure of the generation sequence.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from PIL import Image

from aeroscene.files import replacing
from aeroscene.scene import Scene
from scenarios.pictures.generation.layout_view import Layout, draw_layout
from scenarios.pictures.lettering import INK_RGB, PAPER_RGB, Picture, write
from scenarios.pictures.sheet import draw_scene, tile

N_MOMENTS = 5
"""Number of pictures of the denoising."""
_COLUMNS = 4
_WIDTH = 300
_TITLE_PX, _LETTERS_PX = 32, 20
_SWATCH_PX, _WORDS_PX = 22, 16
_COARSE = "coarse objects: ground, buildings, storeys, rooms; darker where they overlap"
_FINE = "fine objects"
_VIEW = "from above, north up; T is noise, 0 the layout"


def chosen_steps(n_steps: int) -> tuple[int, ...]:
    """Return the steps to draw: the first, the last, and more of the later ones.

    Args:
        n_steps: Number of denoising steps.

    Returns:
        Indices in ascending order; fewer than `N_MOMENTS` if there are fewer steps.
    """
    # Most of the layout appears late, when the noise is small.
    shares = 1.0 - (1.0 - np.linspace(0.0, 1.0, N_MOMENTS)) ** 1.5
    return tuple(dict.fromkeys(np.round(shares * (n_steps - 1)).astype(int).tolist()))


def layout_of(scene: Scene) -> Layout:
    """Return the boxes of a scene."""
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
    """Draw layouts one after the other, and then the finished scene.

    Args:
        moments: Titles and layouts, the noise first.
        half_span_m: Distance from the middle of a layout's picture to its border.
        scene: The finished scene; None if it was rejected.
        out: PNG file, written whole or not at all.

    Raises:
        OSError: If the file cannot be written.
    """
    cells = [_titled(t, draw_layout(layout, _WIDTH, half_span_m)) for t, layout in moments]
    if scene is not None:
        # The same scene twice: as boxes beside the layouts, and as it is rendered.
        cells.append(_titled("feasible", draw_layout(layout_of(scene), _WIDTH, half_span_m)))
        cells.append(_titled("scene", draw_scene(scene, _WIDTH, aspect=1.0)))
    sheet = tile(cells, _COLUMNS)
    sheet = np.vstack([sheet, _legend(sheet.shape[1])])
    with replacing(out) as file:
        Image.fromarray(sheet).save(file, format="png", optimize=True)


def _legend(width: int) -> Picture:
    """Return a row that explains the colours; each swatch is drawn like a box of the layouts."""
    row = np.full((2 * _SWATCH_PX, width, 3), PAPER_RGB, np.uint8)
    left = _SWATCH_PX // 2
    for is_coarse, words in ((True, _COARSE), (False, _FINE)):
        box = Layout(np.zeros((1, 3)), np.eye(1, 2), np.ones((1, 3)), np.array([is_coarse]))
        swatch = draw_layout(box, _SWATCH_PX, 0.6)
        free = row[: len(swatch), left : left + _SWATCH_PX]
        free[:] = swatch[:, : free.shape[1]]
        write(row, words, (left + _SWATCH_PX + 6, 2), _WORDS_PX, INK_RGB)
        # A letter is about 0.46 times as wide as high, on average.
        left += 2 * _SWATCH_PX + round(_WORDS_PX * 0.46 * len(words))
    write(row, _VIEW, (left, 2), _WORDS_PX, INK_RGB)
    return row


def _titled(title: str, picture: Picture) -> Picture:
    head = np.full((_TITLE_PX, picture.shape[1], 3), PAPER_RGB, np.uint8)
    write(head, title, (2, (_TITLE_PX - _LETTERS_PX) // 2), _LETTERS_PX, INK_RGB)
    return np.vstack([head, picture])
