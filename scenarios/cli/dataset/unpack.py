"""`aeroscene dataset unpack`: the scenes of the package as JSON files."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

from aeroscene.processes import default_jobs
from scenarios.cli.command_line import EXIT_DONE, print_json
from scenarios.cli.dataset.options import JOBS, SHIPPED_NAME, SceneNumbers, open_scenes
from scenarios.cli.outputs import OutFolder
from scenarios.cli.progress import progress_bar
from scenarios.dataset.unpack import unpack_all


@dataclass(frozen=True, kw_only=True)
class UnpackCfg:
    """Write the scenes that come with the package as JSON files, one each.

    docs/scenes.md describes their format; `--scene FILE.json` opens them again.
    """

    out: Annotated[Path, OutFolder()] = Path("scenes")
    """Folder to write to; it is made if it is missing. Files of the same names are replaced."""
    scenes: SceneNumbers = ""
    """Only these scenes: A:B without B, single ones, joined by commas; all by default."""
    gzip: bool = False
    """Compress the files: .json.gz, a fifth of the size."""
    jobs: Annotated[int, JOBS] = field(default_factory=default_jobs)
    """Processes; the default is the number of cores."""
    json: bool = False
    """Print one JSON object: folder, scenes, bytes."""


def run(cfg: UnpackCfg) -> int:
    """Write the files and print where they are."""
    dataset = open_scenes(SHIPPED_NAME, cfg.scenes)
    suffix = ".json.gz" if cfg.gzip else ".json"
    n_scenes = len(dataset.entries)
    with progress_bar("unpacking", n_scenes) as advance:
        n_bytes = unpack_all(dataset, cfg.out, suffix, cfg.jobs, advance)
    if cfg.json:
        print_json({"folder": str(cfg.out), "scenes": n_scenes, "bytes": n_bytes})
    else:
        print(f"{cfg.out}: {n_scenes} scenes, {n_bytes / 1e6:.1f} MB")
    return EXIT_DONE
