"""`curves.png`: the losses of a training, drawn from its log.

Pillow draws it in a few lines, so that a training needs no plotting library.
"""

from __future__ import annotations

import io
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from aeroscene.files import replacing
from aeroscene.learning.training.journal import read_log

if TYPE_CHECKING:
    from PIL import ImageDraw

CURVES = "curves.png"

Points = Sequence[tuple[float, float]]

_WIDTH, _HEIGHT = 960, 420
# Margins of a panel, px.
_LEFT, _RIGHT, _TOP, _BOTTOM = 84, 200, 46, 52
_OVER = 2
"""Factor by which the picture is drawn larger and then shrunk, for smooth lines."""
_PAPER, _INK, _PALE, _RULE = "#fafaf8", "#1c2026", "#70767e", "#e2e2de"
_COLOURS = ("#1f77b4", "#d1495b", "#2e8b57", "#b8860b", "#6a4c93", "#3d5a80", "#888888")
_STAGES = ("writer", "contents", "denoiser", "prior")
_NOT_CURVES = frozenset({"stage", "step", "seconds", "gradient_norm", "learning_rate", "is_best"})
_MARKED = "held_out"
"""Curve whose least point is marked, because those weights are kept."""
_LADDER = (1.0, 2.0, 5.0)
"""Marked values of a decade."""
_FINE_DECADES = 3
"""Curves over so many decades or fewer have marks within decades."""
_SMOOTHED = 15
"""Points of the log over which a line's median is taken."""


def draw_curves(folder: Path) -> bool:
    """Draw the log of a training, into the same folder.

    Returns:
        False if there is nothing to draw.

    Raises:
        OSError: If the picture cannot be written.
    """
    from PIL import Image

    stages = _curves_by_stage(folder)
    if not stages:
        return False
    height = _HEIGHT * len(stages)
    picture = Image.new("RGB", (_WIDTH * _OVER, height * _OVER), _PAPER)
    for place, (stage, curves) in enumerate(stages.items()):
        _draw_panel(picture, place * _HEIGHT, stage, curves)
    small = picture.resize((_WIDTH, height), Image.Resampling.LANCZOS)
    data = io.BytesIO()
    small.save(data, "PNG")
    with replacing(folder / CURVES) as file:
        file.write(data.getvalue())
    return True


def _curves_by_stage(folder: Path) -> dict[str, dict[str, Points]]:
    """Return points (step, value) of everything positive, by stage and name."""
    stages: dict[str, dict[str, list[tuple[float, float]]]] = {name: {} for name in _STAGES}
    for record in read_log(folder):
        curves = stages.get(record.get("stage", ""))
        step = record.get("step")
        if curves is None or not isinstance(step, int):
            continue
        for name, value in record.items():
            if name not in _NOT_CURVES and isinstance(value, int | float) and value > 0:
                curves.setdefault(name, []).append((float(step), float(value)))
    drawn = {stage: _distinct(curves) for stage, curves in stages.items()}
    return {stage: curves for stage, curves in drawn.items() if curves}


def _distinct(curves: Mapping[str, Points]) -> dict[str, Points]:
    """Keep curves of two points or more; a total with one term is drawn once."""
    kept: dict[str, Points] = {}
    for name, points in curves.items():
        # A single point gives no line, and a total of one term repeats that term.
        if len(points) > 1 and points not in kept.values():
            kept[name] = points
    return kept


def _marks(low: float, high: float) -> list[float]:
    """Return round values from below the least of a curve to above its greatest."""
    first, last = math.floor(math.log10(low)), math.ceil(math.log10(high))
    ladder = _LADDER if last - first <= _FINE_DECADES else _LADDER[:1]
    # From 1, 2, 5 of each decade; of many decades only their powers of ten.
    marks = [step * 10.0**decade for decade in range(first, last + 2) for step in ladder]
    least = max(i for i, mark in enumerate(marks) if mark <= low)
    greatest = min(i for i, mark in enumerate(marks) if mark >= high)
    return marks[least : max(greatest, least + 1) + 1]


class _Axes:
    """Conversion of steps and values (logarithmic) to pixels."""

    def __init__(self, curves: Mapping[str, Points], top_px: int) -> None:
        steps = [step for points in curves.values() for step, _ in points]
        values = [value for points in curves.values() for _, value in points]
        self.last = max(steps)
        self.marks = _marks(min(values), max(values))
        self.low, self.high = math.log10(self.marks[0]), math.log10(self.marks[-1])
        self.top_px = top_px + _TOP
        self.bottom_px = top_px + _HEIGHT - _BOTTOM

    def x(self, step: float) -> float:
        return _OVER * (_LEFT + (_WIDTH - _LEFT - _RIGHT) * step / max(self.last, 1.0))

    def y(self, value: float) -> float:
        share = (math.log10(value) - self.low) / (self.high - self.low)
        return _OVER * (self.bottom_px - share * (self.bottom_px - self.top_px))


def _draw_panel(picture, top_px: int, stage: str, curves: Mapping[str, Points]) -> None:
    from PIL import ImageDraw

    draw = ImageDraw.Draw(picture)
    axes = _Axes(curves, top_px)
    _write(draw, _LEFT, top_px + 14, f"{stage}: losses by step", 17, _INK)
    for mark in axes.marks:
        y = axes.y(mark)
        draw.line([(axes.x(0), y), (axes.x(axes.last), y)], fill=_RULE, width=_OVER)
        _write(draw, 24, y / _OVER - 8, f"{mark:g}", 13, _PALE)
    for share in (0.0, 0.25, 0.5, 0.75, 1.0):
        step = share * axes.last
        text = f"{step:,.0f}"
        _write(draw, axes.x(step) / _OVER - 3.4 * len(text), axes.bottom_px + 10, text, 13, _PALE)
    for number, (name, points) in enumerate(curves.items()):
        colour = _COLOURS[number % len(_COLOURS)]
        line = [(axes.x(step), axes.y(value)) for step, value in _smooth(points)]
        draw.line(line, fill=colour, width=2 * _OVER, joint="curve")
        y = axes.top_px + 24 * number
        draw.rectangle(_scaled(_WIDTH - _RIGHT + 20, y, 16, 4), fill=colour)
        text = f"{name.replace('_', ' ')} {points[-1][1]:.3g}"
        _write(draw, _WIDTH - _RIGHT + 44, y - 7, text, 13, _INK)
        if name == _MARKED:
            _mark_least(draw, axes, points, colour)


def _mark_least(draw: ImageDraw.ImageDraw, axes: _Axes, points: Points, colour: str) -> None:
    """Draw a ring at the least point of a curve, with its step."""
    step, value = min(points, key=lambda point: point[1])
    x, y, radius = axes.x(step), axes.y(value), 5 * _OVER
    box = (x - radius, y - radius, x + radius, y + radius)
    draw.ellipse(box, outline=colour, width=2 * _OVER)
    text = f"least {value:.3g} at {step:,.0f}"
    left_px = min(x / _OVER, _WIDTH - _RIGHT - 6.5 * len(text))
    _write(draw, left_px, y / _OVER + 8, text, 13, colour)


def _smooth(points: Points) -> list[tuple[float, float]]:
    """Running median of points, because single steps are noisy."""
    values = np.array([value for _, value in points])
    half = _SMOOTHED // 2 if len(points) > 4 * _SMOOTHED else 0
    return [
        (step, float(np.median(values[max(0, i - half) : i + half + 1])))
        for i, (step, _) in enumerate(points)
    ]


def _scaled(x: float, y: float, width: float, height: float) -> tuple[float, float, float, float]:
    return (_OVER * x, _OVER * y, _OVER * (x + width), _OVER * (y + height))


def _write(
    draw: ImageDraw.ImageDraw, x: float, y: float, text: str, size: int, colour: str
) -> None:
    from PIL import ImageFont

    draw.text((_OVER * x, _OVER * y), text, fill=colour, font=ImageFont.load_default(_OVER * size))
