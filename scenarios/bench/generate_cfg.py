"""Options of `bench generate`, light as those of the others."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

import tyro

from aeroscene.ranges import SEEDS, Range, require_ranges
from scenarios.bench.configs import MOST_SCENES, AnyBenchCfg, BenchError

_N_GENERATED = 24


def _default(says: str) -> Any:
    """What happens without an option whose own default is None."""
    return tyro.conf.arg(help_behavior_hint=f"(default: {says})")


@dataclass(frozen=True, kw_only=True)
class GenerateBenchCfg(AnyBenchCfg):
    """Generate scenes one by one and compare them with the corpus.

    Times are wall times from a seed to a finished scene. "before" and "after" are the scenes before
    and after feasibility; docs/metrics.md explains each figure.
    """

    scenes: Annotated[str | None, _default("none")] = None
    """Judge existing scenes instead: shipped, or a folder with a dataset or with output of
    `aeroscene generate`."""
    count: Annotated[int | None, Range(2, MOST_SCENES), _default("24; with --scenes all")] = None
    """Number of scenes, a third in each domain; figures of sets need 64 or more. With --scenes, the
    number of first scenes to judge."""
    seed: Annotated[int, SEEDS] = 0
    """Seed of the first scene; the others count up from it."""
    checkpoint: Annotated[Path | None, _default("the one that ships with the preset")] = None
    """File written by `aeroscene train`."""
    preset: Literal["default", "paper", "progressive"] = "default"
    """The model that ships; its targets apply to a checkpoint too."""
    device: str = "auto"
    """auto uses a GPU if there is one; or cpu, cuda, cuda:1, mps."""
    data: Path = Path("corpus")
    """Folder made by `aeroscene dataset build`, with the scenes to compare with."""

    def __post_init__(self) -> None:
        require_ranges(self, BenchError)
        chosen = (self.checkpoint, self.preset, self.device)
        if self.scenes is not None and chosen != (None, "default", "auto"):
            raise BenchError(
                f"scenes {self.scenes!r} are made already; valid: --scenes without --checkpoint, "
                "--preset and --device"
            )

    @property
    def n_generated(self) -> int:
        """Number of scenes to generate, or the most to look at."""
        return _N_GENERATED if self.count is None else self.count

    @property
    def title(self) -> str:
        """Title of the results."""
        if self.scenes is not None:
            count = "all" if self.count is None else f"first {self.count}"
            return f"scenes {self.scenes}, {count}"
        model = self.checkpoint or self.preset
        return f"{self.n_generated} scenes by {model}, from seed {self.seed}"
