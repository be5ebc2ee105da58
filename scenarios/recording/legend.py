"""Legend of a recording: an image that explains the colours in the scene.

rerun's viewer has legends for plots only, not for scenes in 3D. Its text documents have no colours
either, so the legend is drawn as an image.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import rerun as rr

from scenarios.recording import layout
from scenarios.recording.contact_log import CONTACT_RGB
from scenarios.recording.landing_log import CHOICE_RGB, SAFE_RGB, TOUCHDOWN_RGB, UNSAFE_RGB
from scenarios.recording.plan_log import FLOWN_RGB, PLANNED_RGB, REPLACED_RGB
from scenarios.recording.scene import DRONE_CLASS_RGB, PERCHING_RGB
from scenarios.recording.track_log import TRACK_RGB
from scenarios.recording.vehicle_recorder import EXECUTED_RGB

Row = tuple[tuple[int, int, int], str]
"""A colour, 0 to 255 each, and its meaning."""

AREA_ROWS: tuple[Row, ...] = (
    *(
        (rgb, f"area to land on, up to a {drone_class} drone")
        for drone_class, rgb in DRONE_CLASS_RGB.items()
    ),
    (PERCHING_RGB, "area to perch on"),
)
FLIGHT_ROWS: tuple[Row, ...] = (
    (EXECUTED_RGB, "trajectory, flown"),
    (PLANNED_RGB, "trajectory, planned"),
    (FLOWN_RGB, "earlier plan, as far as it was flown"),
    (REPLACED_RGB, "earlier plan, the part that was replaced"),
    (TRACK_RGB, "seen to move by the pilot"),
    (SAFE_RGB, "landing map: safe"),
    (UNSAFE_RGB, "landing map: unsafe"),
    (TOUCHDOWN_RGB, "point to touch down on"),
    (CHOICE_RGB, "point chosen earlier"),
    (CONTACT_RGB, "contact"),
)
_PAPER_RGB, _INK_RGB = (24, 27, 32), (225, 228, 232)
_WIDTH_PX, _ROW_PX, _LETTERS_PX, _SWATCH_PX = 440, 34, 20, 18


def log_legend(stream: rr.RecordingStream, rows: Sequence[Row]) -> None:
    """Write the legend, which never changes.

    Args:
        stream: Recording.
        rows: Rows from top to bottom.
    """
    stream.log(layout.LEGEND, rr.Image(draw_legend(rows)).compress(jpeg_quality=90), static=True)


def draw_legend(rows: Sequence[Row]) -> np.ndarray:
    """Return an image with a swatch and a line of text for each row, uint8 (height, width, 3)."""
    # Only recordings with a scene have a legend, so Pillow is not loaded for the others.
    from PIL import Image, ImageDraw, ImageFont

    image = Image.new("RGB", (_WIDTH_PX, _ROW_PX * len(rows)), _PAPER_RGB)
    draw, font = ImageDraw.Draw(image), ImageFont.load_default(_LETTERS_PX)
    edge = (_ROW_PX - _SWATCH_PX) // 2
    for number, (rgb, text) in enumerate(rows):
        top = number * _ROW_PX
        swatch = (edge, top + edge, edge + _SWATCH_PX, top + edge + _SWATCH_PX)
        draw.rectangle(swatch, fill=rgb)
        middle = (2 * edge + _SWATCH_PX + 4, top + _ROW_PX // 2)
        draw.text(middle, text, font=font, fill=_INK_RGB, anchor="lm")
    return np.asarray(image)
