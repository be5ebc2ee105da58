"""The rows as figures, for a terminal, for Markdown and as JSON."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from rich.table import Table

from ablation.measure import SceneOutcome
from ablation.rows import Row, TrainedRow
from ablation.store import Outcome, valid_shares

Figures = Mapping[str, float]
"""Figures by name; what a row has no part of is not there."""

_COLUMNS = {
    "valid": ("valid, %", 1),
    "gain": ("change", 1),
    "free": ("free, %", 1),
    "supported": ("supported, %", 1),
    "moved_m": ("moved, m", 2),
    "dropped": ("dropped, %", 2),
    "step_cpu_s": ("CPU s a step", 2),
    "scene_cpu_s": ("CPU s a scene", 2),
}
_GAINS = {"gain": "gain_noise"}
"""Differences with their standard errors over the scenes."""


@dataclass(frozen=True)
class Line:
    """A row with what was measured."""

    row: Row
    figures: Figures


def line(row: Row, outcome: Outcome, base: Outcome | None) -> Line:
    """Figures of a row, and its gain on the row that it is held against; None for a base line."""
    figures = {"valid": float(valid_shares(outcome.scenes).mean())}
    if base is not None:
        figures |= _gain(outcome.scenes, base.scenes)
    figures |= _shares(outcome.scenes)
    if outcome.step_cpu_s is not None:
        figures["step_cpu_s"] = outcome.step_cpu_s
    return Line(row, figures)


def _gain(scenes: Sequence[SceneOutcome], base: Sequence[SceneOutcome]) -> dict[str, float]:
    """Mean difference in percent of a scene's objects, and its standard error."""
    gain = valid_shares(scenes) - valid_shares(base)
    noise = float(gain.std(ddof=1) / len(gain) ** 0.5) if len(gain) > 1 else 0.0
    return {"gain": float(gain.mean()), _GAINS["gain"]: noise}


def _shares(scenes: Sequence[SceneOutcome]) -> dict[str, float]:
    n = sum(scene.n_objects for scene in scenes)
    return {
        "free": 100 * sum(scene.n_free for scene in scenes) / n,
        "supported": 100 * sum(scene.n_supported for scene in scenes) / n,
        "moved_m": float(np.mean([s.moved_m for s in scenes if s.n_dropped < s.n_objects] or [0])),
        "dropped": 100 * sum(scene.n_dropped for scene in scenes) / n,
        "scene_cpu_s": float(np.median([scene.cpu_s for scene in scenes])),
    }


def rich_table(title: str, lines: Sequence[Line]) -> Table:
    """The rows for a terminal."""
    table = Table("row", "what differs", title=title, title_justify="left")
    shown = _shown(lines)
    for name in shown:
        table.add_column(_COLUMNS[name][0], justify="right")
    for each in lines:
        table.add_row(each.row.name, _what(each.row), *(_cell(each, name) for name in shown))
    return table


def markdown_table(lines: Sequence[Line]) -> str:
    """The rows for a page of the documentation."""
    shown = _shown(lines)
    heads = ["row", "what differs", *(_COLUMNS[name][0] for name in shown)]
    body = (
        [f"`{each.row.name}`", _what(each.row), *(_cell(each, name) for name in shown)]
        for each in lines
    )
    rows = (heads, ["---"] * len(heads), *body)
    return "".join(f"| {' | '.join(cells)} |\n" for cells in rows)


def plain(lines: Sequence[Line]) -> list[dict[str, str | float]]:
    """The rows for JSON: percents, metres and seconds, rounded."""
    return [
        {"row": each.row.name, "what": each.row.what, "against": each.row.against}
        | {name: round(value, 4) for name, value in each.figures.items()}
        for each in lines
    ]


def _shown(lines: Sequence[Line]) -> list[str]:
    """Columns that any of the rows has."""
    return [name for name in _COLUMNS if any(name in each.figures for each in lines)]


def _what(row: Row) -> str:
    """With the row that it is held against, where that is not the first of its table."""
    is_usual = not isinstance(row, TrainedRow) or row.against == "default"
    return row.what if is_usual else f"{row.what}; against `{row.against}`"


def _cell(each: Line, name: str) -> str:
    if name not in each.figures:
        return ""
    value, digits = each.figures[name], _COLUMNS[name][1]
    if name in _GAINS:
        return f"{value:+.{digits}f} ± {each.figures[_GAINS[name]]:.{digits}f}"
    return f"{value:.{digits}f}"
