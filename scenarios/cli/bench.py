"""`aeroscene bench`: how fast this machine is."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass
from typing import Annotated, Any

import tyro
from rich.console import Console
from rich.progress import Progress
from rich.table import Table

from scenarios.bench.row import Row
from scenarios.cli.command_line import EXIT_DONE, EXIT_NEGATIVE, fail

_PROG = "aeroscene bench"
_LEAST_SECONDS = 1.0
_LEAST_COUNT, _MOST_COUNT = 3, 1016

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


Bench = (
    Annotated[SimCfg, tyro.conf.subcommand("sim", prefix_name=False)]
    | Annotated[SceneCfg, tyro.conf.subcommand("scene", prefix_name=False)]
)


@dataclass(frozen=True, kw_only=True)
class BenchCfg:
    """Measure how fast this machine is. Exit status 0 if every target is met, else 1."""

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


def _to_plain(bench: SimCfg | SceneCfg, rows: tuple[Row, ...]) -> dict[str, Any]:
    options = asdict(bench)
    del options["json"]
    name = "sim" if isinstance(bench, SimCfg) else "scene"
    return {"bench": name, **options, "rows": [row.to_plain() for row in rows]}


def _print_table(bench: SimCfg | SceneCfg, rows: tuple[Row, ...]) -> None:
    table = Table("metric", "value", "unit", "target", title=bench.title, title_justify="left")
    for row in rows:
        target = ""
        if row.target is not None:
            sign = "≥" if row.better == "higher" else "≤"
            style = "green" if row.is_met else "bold red"
            target = f"[{style}]{sign} {row.target:g}[/]"
        table.add_row(row.metric, f"{row.value:.4g}", row.unit, target)
    Console().print(table)
