"""Statistics of a dataset, and the diversity of its scenes beside other layouts.

Diversity is measured by distances of layouts to their nearest other layout. A larger set has nearer
neighbours by chance alone. To compare sets of different sizes, as many layouts as the smallest set
has are drawn from each.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager, closing
from dataclasses import asdict, dataclass
from functools import partial
from typing import Any

import numpy as np

from aeroscene.corpus.summary import Entry, SceneSet
from aeroscene.metrics.diversity import (
    Layout,
    category_entropy_bits,
    category_names,
    layout_distances,
    layout_of,
    mean_nearest_among,
    nearest,
)
from aeroscene.metrics.paper_table import INCONSISTENCIES, Row, missing_categories, paper_table
from aeroscene.processes import run_all
from aeroscene.scene.catalogue import CATALOGUE

Bar = Callable[[str, int, str], AbstractContextManager[Callable[[], object]]]
"""Function that opens a progress bar by title, count and unit. The context gives the function to
call after each item."""

_DRAWS_SEED = 0


@dataclass(frozen=True, kw_only=True, slots=True)
class Diversity:
    """Diversity of the layouts of one set."""

    name: str
    n_layouts: int
    n_categories: int
    entropy_bits: float
    """Entropy of the category of an object drawn from the whole set."""
    nearest_mean: float | None
    """Mean distance of a layout to its nearest other, in layout radii; None for a single layout."""
    nearest_least: float | None
    closest: tuple[str, str] | None
    """The two most similar layouts."""
    n_compared: int
    """Number of layouts drawn for the next figure: that of the smallest set."""
    nearest_mean_compared: float | None
    """Mean distance to the nearest among that many, comparable between sets of different size."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Statistics:
    """Figures of `dataset stats`."""

    rows: tuple[Row, ...]
    domains: Mapping[str, int]
    """Number of scenes of each domain."""
    categories: Mapping[str, int]
    """Number of objects of each category, all 70."""
    scenes_with: Mapping[str, int]
    """Number of scenes with each category."""
    missing: tuple[str, ...]
    diversity: tuple[Diversity, ...]
    """Diversity of the scenes, then of each set beside them."""

    def to_plain(self) -> dict[str, Any]:
        """Return the statistics as plain data, with the rows of the paper's table first."""
        n_scenes = sum(self.domains.values())
        return {
            **{row.key: row.to_plain() for row in self.rows},
            "domains": {
                name: {"scenes": count, "share": count / n_scenes}
                for name, count in self.domains.items()
            },
            "categories": {
                name: {"objects": count, "scenes": self.scenes_with[name]}
                for name, count in self.categories.items()
            },
            "missing_categories": list(self.missing),
            "diversity": [asdict(diversity) for diversity in self.diversity],
            "paper_inconsistencies": list(INCONSISTENCIES),
        }


def statistics(
    dataset: SceneSet[Entry], beside: Mapping[str, Sequence[Layout]], jobs: int, bar: Bar
) -> Statistics:
    """Read and count all scenes.

    Args:
        dataset: Scenes to count, at least one.
        beside: Other sets of layouts by name, each with at least one layout.
        jobs: Number of processes.
        bar: Function that opens a progress bar for each long part.

    Raises:
        SceneError: If a scene cannot be read.
    """
    layouts: list[Layout] = []
    read = partial(_read_layout, dataset.select(()))
    with (
        bar("reading scenes", len(dataset.entries), "scenes") as advance,
        closing(run_all(read, dataset.entries, jobs)) as results,
    ):
        for layout in results:
            layouts.append(layout)
            advance()
    counts = Counter(name for layout in layouts for name in layout.categories)
    # Sets, because a category counts once for each scene that has it.
    names = [set(layout.categories) for layout in layouts]
    indices = [entry.index for entry in dataset.entries]
    return Statistics(
        rows=paper_table(dataset.entries, dict(zip(indices, names, strict=True))),
        domains=dict(sorted(Counter(entry.domain for entry in dataset.entries).items())),
        categories={c.name: counts[c.name] for c in CATALOGUE.values()},
        scenes_with={c.name: sum(c.name in s for s in names) for c in CATALOGUE.values()},
        missing=tuple(missing_categories(counts)),
        diversity=_compare({dataset.title: layouts, **beside}, bar),
    )


def _read_layout(reader: SceneSet[Entry], entry: Entry) -> Layout:
    return layout_of(reader.read(entry))


def _compare(sets: Mapping[str, Sequence[Layout]], bar: Bar) -> tuple[Diversity, ...]:
    n_compared = min(map(len, sets.values()))
    n_steps = sum(len(category_names(layouts)) for layouts in sets.values())
    with bar("comparing layouts", n_steps, "categories") as advance:
        return tuple(
            _diversity(name, layouts, layout_distances(layouts, advance), n_compared)
            for name, layouts in sets.items()
        )


def _diversity(
    name: str, layouts: Sequence[Layout], distances: np.ndarray, n_compared: int
) -> Diversity:
    nearest_radii, index = nearest(distances)
    first = int(nearest_radii.argmin())
    is_alone = len(layouts) == 1  # without a neighbour to measure
    # A fixed seed, so that the figures of a set do not change from call to call.
    rng = np.random.default_rng(_DRAWS_SEED)
    return Diversity(
        name=name,
        n_layouts=len(layouts),
        n_categories=len(category_names(layouts)),
        entropy_bits=category_entropy_bits(layouts),
        nearest_mean=None if is_alone else float(nearest_radii.mean()),
        nearest_least=None if is_alone else float(nearest_radii.min()),
        closest=None if is_alone else (layouts[first].name, layouts[int(index[first])].name),
        n_compared=n_compared,
        nearest_mean_compared=(
            None if n_compared == 1 else mean_nearest_among(distances, n_compared, rng)
        ),
    )
