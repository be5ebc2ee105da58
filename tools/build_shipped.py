"""Make the 1,016 scenes that ship: generate, validate, count, pack them into one file.

python tools/build_shipped.py --scenes 0:60      # a sample: figures, and what to ask for instead
python tools/build_shipped.py                    # all of them, and the archive

Scenes are kept in a folder as they are made; the same command goes on where it was stopped, and
`aeroscene dataset stats|validate|show FOLDER` looks at them. Another checkpoint or other sources
make them again.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from statistics import fmean
from typing import Literal

import tyro
from rich.table import Table
from rich.text import Text

from aeroscene.corpus.corpus import CORPUS_SIZE
from aeroscene.corpus.dataset import Dataset, SceneEntry, open_dataset
from aeroscene.corpus.shipped import SHIPPED
from aeroscene.metrics.paper_table import Row, paper_table
from aeroscene.processes import WorkerDiedError, default_jobs
from aeroscene.scene import SceneError
from scenarios.cli.progress import progress_bar
from scenarios.cli.scene_numbers import SceneNumbersError, scene_numbers
from scenarios.cli.terminal import Terminal, styled, terminal
from scenarios.dataset.build import build
from scenarios.dataset.shipping import CorpusMaker, Maker, ModelMaker, pack_shipped, plan_shipped

TOLERANCE = 0.10
"""Relative deviation that an average may have from the paper's."""


@dataclass(frozen=True, kw_only=True)
class ShipCfg:
    """Make scenes and, once all of them are there, the archive."""

    folder: Path = Path("shipped")
    """Folder in which scenes are kept until they are packed."""
    scenes: str = f"0:{CORPUS_SIZE}"
    """Numbers of scenes: A:B without B, single ones, joined by commas."""
    maker: Literal["model", "corpus"] = "model"
    """Maker of the scenes; the corpus is for a rehearsal."""
    checkpoint: Path = Path("aeroscene/learning/checkpoints/default.safetensors")
    """Weights of the model."""
    device: str = "cpu"
    """Device that the model runs on."""
    jobs: int = field(default_factory=default_jobs)
    """Processes; one on a GPU."""
    out: Path = SHIPPED
    """The archive to write."""


def main(cfg: ShipCfg) -> None:
    """Make the missing scenes, print the averages, and pack the corpus if it is complete.

    Raises:
        SceneNumbersError: If the numbers of scenes are not valid.
        WorkerDiedError: If a process that makes scenes was ended from outside.
    """
    maker = ModelMaker(cfg.checkpoint, cfg.device) if cfg.maker == "model" else CorpusMaker()
    numbers = scene_numbers(cfg.scenes)
    # A plan leaves out what the folder already has from the same maker, so that a stopped run goes
    # on.
    plan = plan_shipped(cfg.folder, numbers, maker)
    with progress_bar("making scenes", len(plan.to_make)) as advance:
        build(plan, cfg.jobs, lambda _: advance())
    dataset = open_dataset(cfg.folder).select(frozenset(numbers))
    _report(terminal(), dataset.entries)
    # Only a complete corpus is packed: a sample, or a folder of one, gives figures alone.
    if len(dataset.entries) == CORPUS_SIZE:
        _pack(cfg, dataset, maker)


def _report(console: Terminal, entries: Sequence[SceneEntry]) -> None:
    """Print the averages beside the paper's, and by how much to ask for more or less."""
    table = Table("average", title=f"{len(entries):,} scenes", title_justify="left")
    for heading in ("ours", "paper", "off by", "ask for"):
        table.add_column(heading, justify="right")
    names = {entry.index: () for entry in entries}
    for row in paper_table(entries, names):
        if row.is_average:
            table.add_row(row.title, *_cells(row))
    console.print(table)
    # An entry's attempt counts the draws before it that were rejected.
    n_again = sum(entry.attempt for entry in entries)
    share = n_again / (len(entries) + n_again)
    console.print(f"{n_again} draws were rejected, {share:.1%}")


def _cells(row: Row) -> tuple[str | Text, ...]:
    ours, paper = row.ours["total"], row.paper["total"]
    if not ours:
        return "-", f"{paper:g}", "-", "-"
    off = ours / paper - 1
    style = "green" if abs(off) <= TOLERANCE else "bold red"
    return f"{ours:.2f}", f"{paper:g}", styled((f"{off:+.1%}", style)), f"x {paper / ours:.3f}"


def _pack(cfg: ShipCfg, dataset: Dataset, maker: Maker) -> None:
    with progress_bar("packing", len(dataset.entries)) as advance:
        size = pack_shipped(dataset, cfg.out, maker, cfg.device, advance)
    mean_objects = fmean(entry.n_objects for entry in dataset.entries)
    print(f"{cfg.out}: {size / 1e6:.2f} MB, {mean_objects:.1f} objects a scene")


if __name__ == "__main__":
    try:
        main(tyro.cli(ShipCfg, description=__doc__))
    except (SceneError, SceneNumbersError, WorkerDiedError, OSError) as error:
        sys.exit(f"build_shipped: error: {error}")
    except KeyboardInterrupt:
        sys.exit("build_shipped: stopped; the same command goes on from here")
