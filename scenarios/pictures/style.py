"""Style of pictures: colours, sizes, and figures that belong to no window."""

from __future__ import annotations

import io
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from aeroscene.files import replacing

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

PAPER, INK, PALE, RULE = "#fafaf8", "#1c2026", "#70767e", "#dcdcd8"
PLANNED, SUPERSEDED = "#ff4fc3", "#f4c9e6"
TRUE, ESTIMATE = "#1f77b4", "#d1495b"
AREA, TOUCHDOWN = "#2fbf5f", "#ffffff"
MOVERS = ("#ff9f1c", "#2ec4b6", "#a06cff", "#e4572e", "#76b041", "#3a86ff")
SPEED_MAP, FLOWN = "plasma", "#ed7953"
DPI, VECTOR_DPI = 100, 200
"""Resolution, per inch, of PNG files and of renderings within SVG and PDF files."""


def new_figure(width_in: float, height_in: float) -> Figure:
    """Return an empty page; it belongs to no window, so no display is needed."""
    from matplotlib.figure import Figure

    return Figure(figsize=(width_in, height_in), dpi=DPI, facecolor=PAPER, layout="constrained")


def save(figure: Figure, path: Path) -> None:
    """Write a file, whole or not at all.

    Args:
        figure: Page to write.
        path: File, whose name ends in .png, .svg or .pdf.

    Raises:
        OSError: If it cannot be written.
    """
    from matplotlib import rc_context

    data, kind = io.BytesIO(), path.suffix[1:]
    # Names, versions and dates are left out, so that the same flight gives the same bytes.
    unsaid = {"png": ("Software",), "svg": ("Date",), "pdf": ("CreationDate", "Producer")}
    dpi = DPI if kind == "png" else VECTOR_DPI
    with rc_context({"svg.hashsalt": "aeroscene"}):
        figure.savefig(data, format=kind, dpi=dpi, metadata=dict.fromkeys(unsaid[kind]))
    with replacing(path) as file:
        file.write(data.getvalue())


def plain(axes: Axes) -> None:
    """Give a graph a light grid and no box."""
    axes.set_facecolor("white")
    axes.grid(visible=True, color=RULE, linewidth=0.8)
    axes.set_axisbelow(True)
    axes.tick_params(colors=PALE, labelsize=9, length=0)
    for spine in axes.spines.values():
        spine.set_color(RULE)


def title(figure: Figure, text: str) -> None:
    """Set the title of a page, at its upper left."""
    figure.suptitle(text, x=0.008, ha="left", fontsize=14, color=INK)


def heading(axes: Axes, text: str) -> None:
    """Set the title of a panel."""
    axes.set_title(text, loc="left", fontsize=11, color=INK)


def round_length_m(span_m: float) -> float:
    """Return a length of 1, 2 or 5 times a power of ten, at most a fifth of a span.

    Args:
        span_m: Length of the whole picture, greater than 0; 40 gives 5.
    """
    # The largest power of ten within a fifth of the span; 1 times it always fits.
    decade = 10.0 ** np.floor(np.log10(span_m / 5))
    return float(max(step * decade for step in (1.0, 2.0, 5.0) if step * decade <= span_m / 5))
