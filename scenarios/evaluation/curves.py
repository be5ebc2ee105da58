"""Learning curves of all methods of a table, which show whether each was trained long enough.

All methods of a table have the same budget. A method that was stopped while it still learned could
do better with more time, and the reader of a table can see that here.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from scenarios.pictures.style import INK, PALE, TRUE, heading, new_figure, plain, save

CURVES = "curves.png"
_COLUMNS = 3
_PANEL_IN = 3.6, 2.3


def draw_learning_curves(path: Path, curves: Mapping[str, Sequence[tuple[float, float]]]) -> bool:
    """Draw the held-out loss of each training over its CPU minutes, with the least one ringed.

    Each method has a loss of its own, so the heights of two panels cannot be compared.

    Args:
        path: Picture to write.
        curves: CPU seconds and loss at each evaluation, by the title of the training.

    Returns:
        True if there was a curve of at least two points, and the picture was written.

    Raises:
        OSError: If the picture cannot be written.
    """
    # A single point is no curve: training was too short to be evaluated twice.
    curves = {title: points for title, points in curves.items() if len(points) > 1}
    if not curves:
        return False
    n_columns = min(_COLUMNS, len(curves))
    n_lines = -(-len(curves) // n_columns)
    figure = new_figure(n_columns * _PANEL_IN[0], n_lines * _PANEL_IN[1])
    axes = figure.subplots(n_lines, n_columns, squeeze=False).ravel()
    # The last line of panels may not be full.
    for ax in axes[len(curves) :]:
        ax.set_visible(False)
    for ax, (title, points) in zip(axes, curves.items(), strict=False):
        seconds, losses = np.array(points).T
        plain(ax)
        ax.plot(seconds / 60.0, losses, color=TRUE, linewidth=1.5)
        best = int(losses.argmin())
        ax.plot(seconds[best] / 60.0, losses[best], "o", color=INK, fillstyle="none")
        heading(ax, title)
        ax.set_xlabel("CPU minutes", fontsize=8, color=PALE)
        ax.set_ylabel("held-out loss", fontsize=8, color=PALE)
    save(figure, path)
    return True
