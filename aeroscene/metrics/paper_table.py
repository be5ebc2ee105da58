"""The paper's table of its dataset, with our corpus in the same rows.

Source: AeroScene, table "Statistics of our dataset".
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from statistics import fmean
from typing import Any, Literal

from aeroscene.corpus.summary import SceneSummary
from aeroscene.scene.catalogue import CATALOGUE, Level, by_name

Column = Literal["train", "test", "total"]
COLUMNS: tuple[Column, ...] = ("train", "test", "total")
TOLERANCE = 0.05
"""Greatest relative deviation of an average of the corpus from the paper's."""

# They limit how closely any corpus can follow the table.
INCONSISTENCIES = (
    "160,010 objects in 1,016 scenes are 157 a scene, not 149 (train 151, test 185, not 152)",
    "42 small, 12 medium and 5 large landing areas add up to 59, not 54",
    "34 coarse and 112 fine objects add up to 146, not 149",
)
"""Statements of the paper's table that disagree with each other."""


@dataclass(frozen=True, slots=True)
class Row:
    """One row of the table."""

    key: str
    """Name of the row in `--json`."""
    title: str
    paper: Mapping[Column, float]
    ours: Mapping[Column, float | None]
    """Our figures; None if the corpus has no scene of the split."""
    is_average: bool
    """True for an average that should agree with the paper's, within the tolerance."""

    @property
    def deviation(self) -> float | None:
        """Relative deviation of the total from the paper's; None without scenes."""
        value = self.ours["total"]
        return None if value is None else value / self.paper["total"] - 1.0

    @property
    def is_met(self) -> bool:
        """True if the total is within the tolerance."""
        return self.deviation is not None and abs(self.deviation) <= TOLERANCE

    def to_plain(self) -> dict[str, Any]:
        """Return the row as plain data: total, deviation, then both splits."""
        splits = {
            split: {"value": self.ours[split], "paper": self.paper[split]}
            for split in ("train", "test")
        }
        return {
            "value": self.ours["total"],
            "paper": self.paper["total"],
            "deviation": self.deviation,
            **splits,
        }


_Count = Callable[[SceneSummary], int]

# Key, title, the paper's train, test and total, and the count in a scene.
_AVERAGES: tuple[tuple[str, str, tuple[float, float, float], _Count], ...] = (
    ("objects_per_scene", "Objects / scene", (149, 152, 149), lambda e: e.n_objects),
    ("coarse_per_scene", "  coarse", (35, 32, 34), lambda e: e.n_coarse),
    ("fine_per_scene", "  fine", (111, 114, 112), lambda e: e.n_fine),
    ("landing_areas_per_scene", "Areas / scene", (55, 53, 54), lambda e: e.n_landing),
    ("small_areas_per_scene", "  small", (42, 43, 42), lambda e: e.n_small),
    ("medium_areas_per_scene", "  medium", (11, 13, 12), lambda e: e.n_medium),
    ("large_areas_per_scene", "  large", (4, 4, 5), lambda e: e.n_large),
)
_CATEGORIES: tuple[tuple[str, str, Level, int], ...] = (
    ("coarse_categories", "Coarse categories", "coarse", 23),
    ("fine_categories", "Fine categories", "fine", 47),
)


def paper_table(
    entries: Sequence[SceneSummary], categories: Mapping[int, Collection[str]]
) -> tuple[Row, ...]:
    """Return the rows for the scenes of a manifest.

    Args:
        entries: Scenes of the manifest.
        categories: Names of the categories of each scene, by the scene's number.
    """
    groups: dict[Column, list[SceneSummary]] = {
        "train": [entry for entry in entries if entry.split == "train"],
        "test": [entry for entry in entries if entry.split == "test"],
        "total": list(entries),
    }
    counts = (
        _row("scenes", "Scenes", (812, 204, 1016), groups, len),
        _row("objects", "Objects", (122_356, 37_654, 160_010), groups, _n_objects),
    )
    averages = (
        # `count=count` binds the present value: a closure would see the last one.
        _row(key, title, paper, groups, lambda group, count=count: fmean(map(count, group)), True)
        for key, title, paper, count in _AVERAGES
    )
    appearing = (
        _row(
            key, title, (paper,) * 3, groups, partial(_n_names, categories=categories, level=level)
        )
        for key, title, level, paper in _CATEGORIES
    )
    return (*counts, *averages, *appearing)


def _row(
    key: str,
    title: str,
    paper: Sequence[float],
    groups: Mapping[Column, list[SceneSummary]],
    value: Callable[[list[SceneSummary]], float],
    is_average: bool = False,
) -> Row:
    ours: dict[Column, float | None] = {
        column: value(group) if group else None for column, group in groups.items()
    }
    return Row(key, title, dict(zip(COLUMNS, paper, strict=True)), ours, is_average)


def _n_objects(entries: Sequence[SceneSummary]) -> int:
    return sum(entry.n_objects for entry in entries)


def _n_names(
    entries: Sequence[SceneSummary], categories: Mapping[int, Collection[str]], level: Level
) -> int:
    names = {name for entry in entries for name in categories[entry.index]}
    return sum(by_name()[name].level == level for name in names)


def missing_categories(names: Collection[str]) -> list[str]:
    """Return the categories of the catalogue that are not among these names."""
    return [category.name for category in CATALOGUE.values() if category.name not in names]
