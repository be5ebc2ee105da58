"""Sampled scenes of all methods side by side, like the paper's figures."""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from PIL import Image

from aeroscene.files import replacing
from scenarios.evaluation.drawing import STAGES, Draw
from scenarios.evaluation.renders import PIXELS, Photographer
from scenarios.pictures.lettering import INK_RGB, PALE_RGB, PAPER_RGB, write

GALLERY = "scenes.png"
N_SHOWN = 4
_GAP_PX, _HEAD_PX, _SIDE_PX = 6, 26, 250


def draw_gallery(
    path: Path,
    draws: Mapping[str, Sequence[Draw]],
    stages: Mapping[str, str],
    camera: Photographer,
) -> None:
    """Draw a row for each method, with the same draws in the columns, each in all views.

    The first draws are shown, because a choice of good ones would be no comparison.

    Args:
        path: Picture to write.
        draws: Draws by the title of their method.
        stages: Stage that is shown, by the same titles.
        camera: Camera that takes the pictures.

    Raises:
        OSError: If it cannot be written.
    """
    step_px, n_views = PIXELS + _GAP_PX, len(camera.views)
    width_px = _SIDE_PX + N_SHOWN * n_views * step_px
    sheet = np.full((_HEAD_PX + len(draws) * step_px, width_px, 3), PAPER_RGB, dtype=np.uint8)
    for number in range(N_SHOWN):
        place = (_SIDE_PX + number * n_views * step_px, 5)
        write(sheet, f"draw {number}", place, 14, PALE_RGB)
    for line, (title, found) in enumerate(draws.items()):
        top_px = _HEAD_PX + line * step_px
        for part, text in enumerate(_lines(title)):
            write(sheet, text, (8, top_px + 8 + 20 * part), 15, INK_RGB)
        for number, draw in enumerate(found[:N_SHOWN]):
            scene = draw.scene(stages[title])
            if scene is None:
                continue  # A draw that was rejected leaves its place empty.
            for view, picture in enumerate(camera.pictures(scene)):
                left_px = _SIDE_PX + (number * n_views + view) * step_px
                sheet[top_px : top_px + PIXELS, left_px : left_px + PIXELS] = picture
    data = io.BytesIO()
    Image.fromarray(sheet).save(data, "PNG", optimize=True)
    with replacing(path) as file:
        file.write(data.getvalue())


def _lines(title: str) -> list[str]:
    """Return a title in lines that fit beside the pictures."""
    lines = [""]
    for word in title.split():
        if len(lines[-1]) + len(word) > 28:
            lines.append("")
        lines[-1] = f"{lines[-1]} {word}".strip()
    return lines


def shown_stage(name: str) -> str:
    """Return the stage that a name of the table stands for; see `rows.stage_name`."""
    return STAGES[1] if name.endswith("+projection") else STAGES[0]
