"""Options of `bench method`, light as those of the others."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import tyro

from aeroscene.ranges import Range, require_ranges
from scenarios.bench.configs import AnyBenchCfg, BenchError


@dataclass(frozen=True, kw_only=True)
class MethodBenchCfg(AnyBenchCfg):
    """Hold the paper's network against what needs no network, and against eight scenes by heart.

    The errors of a trained network are divided by those of a formula without parameters, channel by
    channel, on scenes that it has not seen. A network of the same kind then learns eight scenes,
    and DiffuScene the same eight in the same CPU time.
    """

    preset: Literal["paper", "progressive"] = "progressive"
    """Which of the paper's two presets; the one that ships, without --checkpoint."""
    checkpoint: Annotated[
        Path | None, tyro.conf.arg(help_behavior_hint="(default: the one that ships)")
    ] = None
    """File written by `aeroscene train` with the preset."""
    data: Path = Path("corpus")
    """Folder made by `aeroscene dataset build`, or a file of neutral layouts; scenes that are held
    out of it are judged."""
    count: Annotated[int, Range(2, 1000)] = 48
    """Number of held-out scenes."""
    cpu_seconds: Annotated[float, Range(0.0, 36_000.0, "s")] = 60.0
    """CPU time for learning eight scenes, each method; 0 leaves that out."""

    def __post_init__(self) -> None:
        require_ranges(self, BenchError)

    @property
    def title(self) -> str:
        """Title of the results."""
        return f"{self.checkpoint or self.preset}, {self.count} held-out scenes of {self.data}"
