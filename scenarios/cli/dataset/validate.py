"""`aeroscene dataset validate`: every rule of a scene checked on every scene of a dataset."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, Any

from rich.table import Table

from aeroscene.corpus.summary import SceneSet
from aeroscene.processes import default_jobs
from aeroscene.ranges import SEEDS, Range
from scenarios.cli.command_line import EXIT_DONE, EXIT_NEGATIVE, print_json
from scenarios.cli.dataset.options import JOBS, Data, SceneNumbers, open_scenes
from scenarios.cli.progress import progress_bar
from scenarios.cli.terminal import Terminal, styled, terminal
from scenarios.dataset.drop_test import LEAST_SHARE, DropReport, drop_all
from scenarios.dataset.validate import Report, first_of_each_kind, validate_all

_MOST_DROPS = 1_000_000
_EXAMPLES = 5
"""Number of examples shown of each kind of finding, of failed drops and of unreadable files."""


@dataclass(frozen=True, kw_only=True)
class ValidateCfg:
    """Check every scene of a dataset against its own rules.

    overlap: boxes with an IoU above 0.01, neither of which carries the other. floating: nothing
    below or beside it holds it. outside: beyond the flight volume. unreachable: a start or an area
    that no drone of its class can reach. unlandable: an area that is not as stated.

    Exit status 0 if all is well, 1 with findings or too many bad drops, 2 for files that cannot be
    read.
    """

    data: Data = ""
    """Folder of a corpus or of scene files, or "shipped" for the scenes that come with the package;
    by default the folder corpus if there is one, else shipped."""
    drops: Annotated[int, Range(0, _MOST_DROPS)] = 0
    """Also let an unpowered Iris fall from 0.3 m on this many random landing areas: it must come
    to rest on them, level within their slope and 2 degrees."""
    seed: Annotated[int, SEEDS] = 0
    """Seed of the areas that the Iris falls on, and of its headings."""
    scenes: SceneNumbers = ""
    """Only these scenes: A:B without B, single ones, joined by commas; all by default."""
    skip_invalid: bool = False
    """Continue after a file that cannot be read, name it and count it."""
    jobs: Annotated[int, JOBS] = field(default_factory=default_jobs)
    """Processes; the default is the number of cores."""
    json: bool = False
    """Print one JSON object: scenes, findings by kind, details, invalid, and drops if asked for."""


def run(cfg: ValidateCfg) -> int:
    """Check every scene, drop vehicles if asked to, and print the findings.

    Returns:
        0 if there are no findings and enough drops came to rest, else 1.
    """
    dataset = open_scenes(cfg.data, cfg.scenes)
    with progress_bar("checking scenes", len(dataset.entries)) as advance:
        report = validate_all(dataset, cfg.jobs, advance, skip_invalid=cfg.skip_invalid)
    drops = _drop(cfg, report.readable) if cfg.drops else None
    if cfg.json:
        extra = {} if drops is None else {"drops": drops.to_plain()}
        print_json({**report.to_plain(), **extra})
    else:
        _print(terminal(), report, drops)
    is_good = not report.findings and (drops is None or drops.share >= LEAST_SHARE)
    return EXIT_DONE if is_good else EXIT_NEGATIVE


def _drop(cfg: ValidateCfg, dataset: SceneSet[Any]) -> DropReport:
    # Each landing area is used at most once, so there may be fewer drops than asked for.
    n_drops = min(cfg.drops, sum(entry.n_landing for entry in dataset.entries))
    with progress_bar("dropping", n_drops, "drops") as advance:
        return drop_all(dataset, cfg.drops, cfg.seed, cfg.jobs, advance)


def _print(console: Terminal, report: Report, drops: DropReport | None) -> None:
    for line in report.invalid[:_EXAMPLES]:
        console.print(styled(("unreadable", "bold red"), f": {line}"), soft_wrap=True)
    if report.invalid:
        console.print(f"{len(report.invalid)} scenes could not be read and were left out")
    table = Table("findings", title=f"{report.n_scenes:,} scenes", title_justify="left")
    table.add_column("count", justify="right")
    table.add_column("in scenes", justify="right")
    for kind, count in report.counts().items():
        scenes = {finding.scene_id for finding in report.findings if finding.kind == kind}
        style = "bold red" if count else "green"
        table.add_row(kind, styled((f"{count:,}", style)), f"{len(scenes):,}")
    console.print(table)
    for found in first_of_each_kind(report.findings, _EXAMPLES):
        where = [found.scene_id]
        where += [] if found.object_id is None else [f"object {found.object_id}"]
        where += [] if found.area_id is None else [f"area {found.area_id}"]
        line = f"{found.kind}: {', '.join(where)}: {found.detail}"
        console.print(line, soft_wrap=True)
    if drops is not None:
        _print_drops(console, drops)


def _print_drops(console: Terminal, report: DropReport) -> None:
    style = "green" if report.share >= LEAST_SHARE else "bold red"
    n_good = len(report.drops) - len(report.failed)
    console.print(
        styled(
            f"Drops: {n_good:,} of {len(report.drops):,} came to rest on their areas, ",
            (f"{report.share:.1%}", style),
            f" (at least {LEAST_SHARE:.0%})",
        )
    )
    for drop in report.failed[:_EXAMPLES]:
        where = f"{drop.scene_id}, {drop.drone_class} area {drop.area_id}"
        console.print(f"drop: {where}: {', '.join(drop.faults)}", soft_wrap=True)
