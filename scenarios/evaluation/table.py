"""A finished table: JSON for programs, Markdown for pages, a plot with intervals."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from aeroscene.files import replacing
from aeroscene.metrics.scorecard import Metric
from scenarios.evaluation.leads import Lead, leads_markdown
from scenarios.evaluation.rows import Row
from scenarios.pictures.style import DPI, INK, PALE, PAPER, TRUE, plain, save

_KINDS = ("json", "md", "png")
_PLOTTED_COLUMNS = 4
_DIGITS = 3
"""Significant digits of a figure in Markdown."""


def to_plain(rows: Sequence[Row]) -> list[dict[str, Any]]:
    """Return rows as plain data for JSON, with None for a figure that could not be judged."""
    return [
        {
            "method": row.method,
            "metric": row.metric,
            "value": row.value,
            "interval_95": None if row.interval_95 is None else list(row.interval_95),
            "n": row.n,
        }
        for row in rows
    ]


def write_table(
    folder: Path,
    name: str,
    head: Mapping[str, Any],
    rows: Sequence[Row],
    metrics: Mapping[str, Metric],
    titles: Mapping[str, str],
    leads: Mapping[str, Sequence[Lead]],
) -> list[Path]:
    """Write a table in all its forms.

    Args:
        folder: Folder to write into.
        name: Name of the table, and of its files.
        head: Settings of the table: data, seed, budget, machine.
        rows: Its figures.
        metrics: Metrics by key, in the order of the table.
        titles: Titles of the methods by name, in the order of the table.
        leads: For some methods, their leads over the best of the others.

    Returns:
        The files.

    Raises:
        OSError: If a file cannot be written.
    """
    paths = [folder / f"{name}.{kind}" for kind in _KINDS]
    found = {name: msgspec.to_builtins(each) for name, each in leads.items()}
    document = {**head, "rows": to_plain(rows), "leads": found}
    with replacing(paths[0]) as file:
        file.write(json.dumps(document, indent=1).encode())
    with replacing(paths[1]) as file:
        text = markdown(rows, metrics, titles)
        for method, each in leads.items():
            text += f"\n{titles[method]}, beside the best of the others:\n\n"
            text += leads_markdown(each, titles)
        file.write(text.encode())
    draw_plot(paths[2], rows, metrics, titles)
    return paths


def markdown(rows: Sequence[Row], metrics: Mapping[str, Metric], titles: Mapping[str, str]) -> str:
    """Return the table as Markdown, with a line for each metric and a column for each method.

    Metrics are lines, because there are many more of them than methods.

    Args:
        rows: Figures of the table.
        metrics: Metrics by key, in the order of the lines; one without any figure is left out.
        titles: Titles of the methods by name, in the order of the columns.
    """
    cells = {(row.method, row.metric): row for row in rows}
    methods = [name for name in titles if any(row.method == name for row in rows)]
    head = ["metric", "unit", *(titles[name] for name in methods)]
    lines = [head, ["---"] * len(head)]
    for key, metric in metrics.items():
        found = [cells.get((name, key)) for name in methods]
        # A metric without any figure, such as flights that nobody asked for, has no line.
        if any(row is not None and row.value is not None for row in found):
            arrow = {"lower": " ↓", "higher": " ↑", None: ""}[metric.better]
            title = f"`{key}` {metric.title}{arrow}"
            lines.append([title, metric.unit, *map(_cell, found)])
    # Figures of a part of the scenes have a smaller n, so the largest is the number of scenes.
    counts = {name: max(row.n for row in rows if row.method == name) for name in methods}
    lines.append(["scenes", "", *(str(counts[name]) for name in methods)])
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


def _cell(row: Row | None) -> str:
    if row is None or row.value is None:
        return ""
    if row.interval_95 is None:
        return f"{row.value:.{_DIGITS}g}"
    low, high = row.interval_95
    return f"{_short(row.value)} ({_short(low)} to {_short(high)})"


def _short(value: float) -> str:
    return f"{value:.{_DIGITS}g}" if abs(value) < 1000 else f"{value:.0f}"


def draw_plot(
    path: Path, rows: Sequence[Row], metrics: Mapping[str, Metric], titles: Mapping[str, str]
) -> None:
    """Draw a graph for each metric, with every method and its interval.

    Args:
        path: PNG file to write.
        rows: Figures of the table; those without an interval are left out.
        metrics: Metrics by key, in the order of the graphs.
        titles: Methods by name, in the order of the lines; only the names are drawn.

    Raises:
        OSError: If it cannot be written.
    """
    from matplotlib.figure import Figure

    cells = {
        (row.method, row.metric): row
        for row in rows
        if row.value is not None and row.interval_95 is not None
    }
    methods = [name for name in titles if any(method == name for method, _ in cells)]
    shown = [key for key in metrics if any(metric == key for _, metric in cells)]
    n_lines = -(-len(shown) // _PLOTTED_COLUMNS)
    height = 0.9 + 0.22 * len(methods)
    # Margins are set by hand, because matplotlib's own layout of fifty graphs takes half a minute.
    size_in = 4.2 * _PLOTTED_COLUMNS, max(1, n_lines) * height
    figure = Figure(figsize=size_in, dpi=DPI, facecolor=PAPER)
    margin = 0.3 / max(1, n_lines)
    figure.subplots_adjust(
        left=0.11, right=0.985, bottom=margin, top=1 - margin, hspace=0.75, wspace=0.14
    )
    axes = np.atleast_1d(figure.subplots(n_lines, _PLOTTED_COLUMNS, squeeze=False)).ravel()
    for number, ax in enumerate(axes):
        if number >= len(shown):
            ax.set_visible(False)
            continue
        key = shown[number]
        plain(ax)
        for place, name in enumerate(methods):
            row = cells.get((name, key))
            if row is not None and row.value is not None and row.interval_95 is not None:
                ax.plot(row.interval_95, (place, place), color=TRUE, linewidth=2.0)
                ax.plot(row.value, place, "o", color=INK, markersize=4)
        ax.set_title(f"{key} ({metrics[key].unit})", fontsize=9, color=INK, loc="left")
        # The first method at the top, as in the table.
        ax.set_ylim(len(methods) - 0.5, -0.5)
        is_first = number % _PLOTTED_COLUMNS == 0
        ax.set_yticks(range(len(methods)), methods if is_first else [""] * len(methods))
        ax.tick_params(axis="y", labelsize=7, colors=PALE)
    save(figure, path)
