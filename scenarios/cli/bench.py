"""`aeroscene bench`: how fast this machine is, how good generated scenes are."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

import tyro
from rich.console import Console
from rich.progress import Progress
from rich.table import Table

from scenarios.bench.row import Row
from scenarios.cli.command_line import EXIT_DONE, EXIT_NEGATIVE, fail

_PROG = "aeroscene bench"
_LEAST_SECONDS = 1.0
_LEAST_COUNT, _MOST_COUNT = 3, 1016
_LEAST_GENERATED = 6
"""Fewer say nothing about a set of scenes."""

OnProgress = Callable[[str, float], None]


@dataclass(frozen=True, kw_only=True)
class SimCfg:
    """Fly a scene with everything but cameras and two MAVLink clients, then measure the parts."""

    scene: str = "42"
    """Scene of the dataset by number, or a scene JSON file."""
    vehicle: str = "iris"
    """Airframe: iris, iris-rotors or hummingbird."""
    seconds: float = 60.0
    """Simulated seconds of each flight; those with cameras take a fifth."""
    json: Annotated[bool, tyro.conf.arg(name="json")] = False
    """Print one JSON object: rows, each with metric, value, unit and target."""

    def rows(self, on_progress: OnProgress) -> Iterable[Row]:
        """Measure."""
        from scenarios.bench import sim  # noqa: PLC0415 - the whole stack

        if not self.seconds >= _LEAST_SECONDS:
            raise sim.BenchError(
                f"seconds {self.seconds} is too short; valid: {_LEAST_SECONDS:g} or more"
            )
        cfg = sim.SimBenchCfg(scene=self.scene, vehicle=self.vehicle, seconds=self.seconds)
        return sim.rows(cfg, on_progress)

    @property
    def title(self) -> str:
        """What was measured."""
        return f"scene {self.scene}, {self.vehicle}, {self.seconds:g} simulated seconds"


@dataclass(frozen=True, kw_only=True)
class SceneCfg:
    """Make scenes of all domains, compile them, step their physics, render their cameras.

    CPU time of all threads is counted: what one core would take. p95 is the scene that only a
    twentieth of all are worse than.
    """

    count: int = 12
    """How many scenes, spread over the corpus."""
    json: Annotated[bool, tyro.conf.arg(name="json")] = False
    """Print one JSON object: rows, each with metric, value, unit and target."""

    def rows(self, on_progress: OnProgress) -> Iterable[Row]:
        """Measure."""
        from scenarios.bench import scene, sim  # noqa: PLC0415 - the whole stack

        if not _LEAST_COUNT <= self.count <= _MOST_COUNT:
            raise sim.BenchError(
                f"count {self.count} is out of range; valid: {_LEAST_COUNT} to {_MOST_COUNT}"
            )
        return scene.rows(self.count, on_progress)

    @property
    def title(self) -> str:
        """What was measured."""
        return f"{self.count} scenes of all domains"


@dataclass(frozen=True, kw_only=True)
class GenerateCfg:
    """Generate scenes, one after the other, and judge them beside the corpus.

    Times are wall times from a seed to a finished scene. "before" and "after" are the scenes before
    and after feasibility; docs/metrics.md says what each figure is.
    """

    count: int = 24
    """How many scenes, a third of each domain; figures about sets want 64 or more."""
    seed: int = 0
    """Seed of the first scene; the others count on from it."""
    checkpoint: Path | None = None
    """File that `aeroscene train` has written. [default: the one that ships with the preset]"""
    preset: Literal["default", "paper"] = "default"
    """The model that ships, default or paper; its targets hold for a checkpoint too."""
    device: str = "auto"
    """auto takes a GPU where there is one; or cpu, cuda, cuda:1, mps."""
    data: Path = Path("corpus")
    """Folder that `aeroscene dataset build` has made: the scenes to compare with."""
    json: Annotated[bool, tyro.conf.arg(name="json")] = False
    """Print one JSON object: rows, each with metric, value, unit and target."""

    def rows(self, on_progress: OnProgress) -> Iterable[Row]:
        """Measure."""
        from scenarios.bench import sim  # noqa: PLC0415 - the whole stack

        if not _LEAST_GENERATED <= self.count <= _MOST_COUNT:
            raise sim.BenchError(
                f"count {self.count} is out of range; valid: {_LEAST_GENERATED} to {_MOST_COUNT}"
            )
        if self.seed < 0:
            raise sim.BenchError(f"seed {self.seed} is out of range; valid: 0 or more")
        from scenarios.bench import generate  # noqa: PLC0415 - the model

        cfg = generate.GenerateBenchCfg(
            count=self.count,
            seed=self.seed,
            checkpoint=self.checkpoint,
            preset=self.preset,
            device=self.device,
            data=self.data,
        )
        return generate.rows(cfg, on_progress)

    @property
    def title(self) -> str:
        """What was measured."""
        return f"{self.count} scenes by {self.checkpoint or self.preset}, from seed {self.seed}"


Bench = (
    Annotated[SimCfg, tyro.conf.subcommand("sim", prefix_name=False)]
    | Annotated[SceneCfg, tyro.conf.subcommand("scene", prefix_name=False)]
    | Annotated[GenerateCfg, tyro.conf.subcommand("generate", prefix_name=False)]
)

AnyCfg = SimCfg | SceneCfg | GenerateCfg
_NAMES: Mapping[type, str] = {SimCfg: "sim", SceneCfg: "scene", GenerateCfg: "generate"}


@dataclass(frozen=True, kw_only=True)
class BenchCfg:
    """Measure how fast this machine is, or how good generated scenes are.

    Exit status 0 if every target is met, else 1.
    """

    bench: Bench


def run(cfg: BenchCfg) -> int:
    """Run the benchmark and print it; exit status 2 with one line where it cannot be run."""
    # The whole stack: only where it is run.
    from aeroscene.scene import SceneError  # noqa: PLC0415
    from flightsim.vehicles.catalogue import AirframeError  # noqa: PLC0415
    from scenarios.bench.launch import LaunchError  # noqa: PLC0415
    from scenarios.bench.sim import BenchError  # noqa: PLC0415

    try:
        with Progress(console=Console(stderr=True), transient=True) as progress:
            task = progress.add_task("", total=1.0)
            rows = tuple(
                cfg.bench.rows(
                    lambda title, share: progress.update(task, description=title, completed=share)
                )
            )
    except (SceneError, AirframeError, BenchError, LaunchError) as error:
        fail(_PROG, str(error))
    if cfg.bench.json:
        print(json.dumps(_to_plain(cfg.bench, rows)))
    else:
        _print_table(cfg.bench, rows)
    return EXIT_DONE if all(row.is_met for row in rows) else EXIT_NEGATIVE


def _to_plain(bench: AnyCfg, rows: tuple[Row, ...]) -> dict[str, Any]:
    options = {
        name: str(value) if isinstance(value, Path) else value
        for name, value in asdict(bench).items()
    }
    del options["json"]
    return {"bench": _NAMES[type(bench)], **options, "rows": [row.to_plain() for row in rows]}


def _print_table(bench: AnyCfg, rows: tuple[Row, ...]) -> None:
    table = Table("metric", "value", "unit", "target", title=bench.title, title_justify="left")
    for row in rows:
        target = ""
        if row.target is not None:
            sign = "≥" if row.better == "higher" else "≤"
            style = "green" if row.is_met else "bold red"
            target = f"[{style}]{sign} {row.target:g}[/]"
        table.add_row(row.metric, f"{row.value:.4g}", row.unit, target)
    Console().print(table)
