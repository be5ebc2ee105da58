"""`aeroscene dataset stats`: counts of a dataset beside the figures of the paper."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

import numpy as np
from rich.box import SIMPLE_HEAD
from rich.table import Table
from rich.text import Text

from aeroscene.corpus.dataset import DatasetError
from aeroscene.metrics.diversity import Layout
from aeroscene.metrics.paper_table import INCONSISTENCIES, Row
from aeroscene.processes import default_jobs
from scenarios.cli.command_line import EXIT_DONE, default_hint, print_json
from scenarios.cli.dataset.options import JOBS, Data, SceneNumbers, open_scenes
from scenarios.cli.progress import progress_bar
from scenarios.cli.terminal import Terminal, styled, terminal
from scenarios.dataset.stats import Diversity, Statistics, statistics

_CATEGORY_COLUMNS = 4


@dataclass(frozen=True, kw_only=True)
class StatsCfg:
    """Count the objects and areas of a dataset, and print them beside the paper's figures.

    Domains, categories and diversity follow. The unit of layout distance is the layout's radius:
    the root mean square distance of its objects from their mean, seen from above.
    """

    data: Data = ""
    """Folder of a corpus or of scene files, or "shipped" for the scenes that come with the package;
    by default the folder corpus if there is one, else shipped."""
    beside: Annotated[tuple[Path, ...], default_hint("none")] = ()
    """Neutral layout files (.jsonl or .jsonl.gz) whose diversity is shown beside the dataset's."""
    scenes: SceneNumbers = ""
    """Only these scenes: A:B without B, single ones, joined by commas; all by default."""
    jobs: Annotated[int, JOBS] = field(default_factory=default_jobs)
    """Processes; the default is the number of cores."""
    json: bool = False
    """Print one JSON object: a key for each row of the table with value, paper, deviation, train
    and test; then domains, categories, missing_categories, diversity, paper_inconsistencies."""


def run(cfg: StatsCfg) -> int:
    """Count the scenes and print the statistics as tables or as one JSON object."""
    dataset = open_scenes(cfg.data, cfg.scenes)
    beside = {_set_name(path): _read_layouts(path) for path in cfg.beside}
    found = statistics(dataset, beside, cfg.jobs, progress_bar)
    if cfg.json:
        print_json(found.to_plain())
    else:
        _print(terminal(), dataset.title, found)
    return EXIT_DONE


def _set_name(path: Path) -> str:
    return path.name.removesuffix(".gz").removesuffix(".jsonl")


def _read_layouts(path: Path) -> Sequence[Layout]:
    from aeroscene.layouts.neutral_format import read_neutral

    layouts = [
        Layout(
            found.scene_id,
            tuple(obj.category for obj in found.objects),
            np.array([obj.p for obj in found.objects], dtype=float).reshape(-1, 3),
        )
        for found in read_neutral(path)
    ]
    if not layouts:
        raise DatasetError(f"layout file {str(path)!r} holds no layout; valid: one a line")
    return layouts


def _print(console: Terminal, title: str, found: Statistics) -> None:
    console.print(_paper_table(title, found.rows))
    console.print("The paper's table disagrees with itself:")
    for text in INCONSISTENCIES:
        console.print(f"  {text}", style="dim", soft_wrap=True)
    console.print()
    n_scenes = sum(found.domains.values())
    shares = (f"{name} {count} ({count / n_scenes:.0%})" for name, count in found.domains.items())
    console.print(styled(("Domains", "bold"), f"  {', '.join(shares)}"))
    console.print()
    console.print(_category_table(found.categories))
    if found.missing:
        console.print(styled(("None of", "bold red"), f"  {', '.join(found.missing)}"))
    console.print()
    console.print(_diversity_table(found.diversity))
    ours = found.diversity[0]
    if ours.closest is not None:
        console.print(f"Most alike in the {title}: {' and '.join(ours.closest)}")
    console.print(
        "entropy: of the category of an object, bits. nearest: distance to the nearest other "
        "layout of the set, mean and least, in layout radii; among as many as the smallest set "
        f"has, {ours.n_compared}, since neighbours are nearer where there are more.",
        style="dim",
    )


def _table(title: str) -> Table:
    return Table(
        title=title,
        title_justify="left",
        title_style="bold",
        box=SIMPLE_HEAD,
        pad_edge=False,
        padding=(0, 0, 0, 1),
    )


def _paper_table(title: str, rows: Sequence[Row]) -> Table:
    table = _table(f"The {title} beside the paper's dataset")
    table.add_column("", no_wrap=True)
    for heading in ("train", "paper", "test", "paper", "total", "paper", "off by"):
        table.add_column(heading, justify="right", style="dim" if heading == "paper" else None)
    for row in rows:
        cells: list[str] = []
        for column, paper in row.paper.items():
            cells += [_figure(row.ours[column], row.is_average), f"{paper:,.0f}"]
        table.add_row(row.title, *cells, _deviation(row))
    return table


def _figure(value: float | None, is_average: bool) -> str:
    if value is None:
        return "-"
    return f"{value:,.1f}" if is_average else f"{value:,.0f}"


def _deviation(row: Row) -> Text:
    # Totals depend on the number of scenes; only averages can be held against the paper's.
    if row.deviation is None or not row.is_average:
        return styled()
    style = "green" if row.is_met else "bold red"
    return styled((f"{row.deviation:+.1%}", style))


def _category_table(categories: Mapping[str, int]) -> Table:
    table = _table("Objects of each category")
    table.show_header = False
    for _ in range(_CATEGORY_COLUMNS):
        table.add_column(no_wrap=True)
        table.add_column(justify="right")
    cells = [(name, f"{count:,}") for name, count in categories.items()]
    n_rows = -(-len(cells) // _CATEGORY_COLUMNS)  # rounded up
    for number in range(n_rows):
        table.add_row(*(text for cell in cells[number::n_rows] for text in cell))
    return table


def _diversity_table(sets: Sequence[Diversity]) -> Table:
    table = _table("Diversity")
    table.add_column("", no_wrap=True)
    among = f"among {sets[0].n_compared}"
    for heading in ("layouts", "categories", "entropy", "nearest", "least", among):
        table.add_column(heading, justify="right", no_wrap=True)
    for one in sets:
        distances = (one.nearest_mean, one.nearest_least, one.nearest_mean_compared)
        table.add_row(
            one.name,
            f"{one.n_layouts:,}",
            str(one.n_categories),
            f"{one.entropy_bits:.2f}",
            *("-" if value is None else f"{value:.3f}" for value in distances),
        )
    return table
