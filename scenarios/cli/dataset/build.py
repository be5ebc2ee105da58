"""`aeroscene dataset build`: compose the training corpus in a folder."""

from __future__ import annotations

import signal
import sys
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

from aeroscene.corpus.corpus import CORPUS_SIZE
from aeroscene.corpus.provenance import curation_digest
from aeroscene.processes import default_jobs
from scenarios.cli.command_line import EXIT_DONE, interrupt, print_json
from scenarios.cli.dataset.options import JOBS
from scenarios.cli.outputs import OutFolder
from scenarios.cli.progress import progress_bar
from scenarios.cli.scene_numbers import scene_numbers
from scenarios.dataset.build import BuildPlan, build, plan_build

_PROG = "aeroscene dataset build"


@dataclass(frozen=True, kw_only=True)
class BuildCfg:
    """Make the corpus: the same scenes, byte for byte, whenever and with however many processes.

    Scenes in the folder that the same sources made are kept, so that a stopped build continues
    where it was. Scenes that other sources made are made again.
    """

    out: Annotated[Path, OutFolder()] = Path("corpus")
    """Folder to build in; it is made if it is missing."""
    scenes: str = f"0:{CORPUS_SIZE}"
    """Numbers of scenes, from 0 up: A:B without B, single ones, joined by commas. You can go beyond
    the 1,016 of the corpus as far as you like; every fifth scene is of the test split."""
    jobs: Annotated[int, JOBS] = field(default_factory=default_jobs)
    """Processes; the default is the number of cores."""
    json: bool = False
    """Print one JSON object: folder, scenes, made, kept, bytes, seconds, sources."""


def run(cfg: BuildCfg) -> int:
    """Make the scenes that are missing or outdated, and print how many were made and kept."""
    # SIGTERM is handled as Ctrl-C is, so that nothing stays half-written.
    signal.signal(signal.SIGTERM, interrupt)
    plan = plan_build(cfg.out, scene_numbers(cfg.scenes))
    _announce(plan)
    start_s = time.perf_counter()
    try:
        with progress_bar("making scenes", len(plan.to_make)) as advance:
            n_bytes = build(plan, cfg.jobs, lambda _: advance())
    except KeyboardInterrupt:
        sys.stderr.write(f"{_PROG}: stopped; the same command goes on from here\n")
        raise
    seconds = time.perf_counter() - start_s
    _report(cfg, plan, n_bytes, seconds)
    return EXIT_DONE


def _announce(plan: BuildPlan) -> None:
    if plan.outdated:
        sys.stderr.write(
            f"{_PROG}: {len(plan.outdated)} scenes in {plan.folder} were made by other sources: "
            "they are made again\n"
        )
    if plan.foreign:
        sys.stderr.write(
            f"{_PROG}: {len(plan.foreign)} scenes in {plan.folder} that were not asked for were "
            "made by other sources: they stay; a build that names them in --scenes makes them "
            "again\n"
        )


def _report(cfg: BuildCfg, plan: BuildPlan, n_bytes: int, seconds: float) -> None:
    n_made, n_kept = len(plan.to_make), len(plan.kept)
    if cfg.json:
        report = {
            "folder": str(cfg.out),
            "scenes": n_made + n_kept,
            "made": n_made,
            "kept": n_kept,
            "bytes": n_bytes,
            "seconds": round(seconds, 3),
            "sources": curation_digest(),
        }
        print_json(report)
        return
    rate = f", {n_made / seconds:.1f} a second" if n_made else ""
    print(
        f"{cfg.out}: {n_made + n_kept} scenes, {n_bytes / 1e6:.1f} MB. {n_made} made in "
        f"{_clock(seconds)}{rate}, {n_kept} were there."
    )


def _clock(seconds: float) -> str:
    minutes, rest = divmod(seconds, 60)
    return f"{minutes:.0f} min {rest:.0f} s" if minutes else f"{rest:.1f} s"
