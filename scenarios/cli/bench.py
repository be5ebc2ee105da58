"""`aeroscene bench`: how fast this machine is."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Annotated, Any, Literal

import tyro
from rich.console import Console
from rich.progress import Progress
from rich.table import Table

from scenarios.bench.row import Row
from scenarios.cli.command_line import EXIT_DONE, EXIT_NEGATIVE, fail

_PROG = "aeroscene bench"
_LEAST_SECONDS = 1.0


@dataclass(frozen=True, kw_only=True)
class BenchCfg:
    """Measure how fast this machine is.

    sim flies a scene with everything but cameras and two MAVLink clients, then measures the parts.
    Exit status 0 if every target is met, else 1.
    """

    name: tyro.conf.Positional[Literal["sim"]]
    """Which benchmark."""
    scene: str = "42"
    """Scene of the dataset by number, or a scene JSON file."""
    vehicle: str = "iris"
    """Airframe: iris, iris-rotors or hummingbird."""
    seconds: float = 60.0
    """Simulated seconds of each flight; those with cameras take a fifth."""
    json: Annotated[bool, tyro.conf.arg(name="json")] = False
    """Print one JSON object: rows, each with metric, value, unit and target."""


def run(cfg: BenchCfg) -> int:
    """Run the benchmark and print it; exit status 2 with one line where it cannot be run."""
    if not cfg.seconds >= _LEAST_SECONDS:
        fail(_PROG, f"seconds {cfg.seconds} is too short; valid: {_LEAST_SECONDS:g} or more")
    # The whole stack: only where it is run.
    from aeroscene.scene import SceneError  # noqa: PLC0415
    from flightsim.vehicles.catalogue import AirframeError  # noqa: PLC0415
    from scenarios.bench import sim  # noqa: PLC0415
    from scenarios.bench.launch import LaunchError  # noqa: PLC0415

    bench_cfg = sim.SimBenchCfg(scene=cfg.scene, vehicle=cfg.vehicle, seconds=cfg.seconds)
    try:
        with Progress(console=Console(stderr=True), transient=True) as progress:
            task = progress.add_task("", total=1.0)
            rows = tuple(
                sim.rows(
                    bench_cfg,
                    lambda title, share: progress.update(task, description=title, completed=share),
                )
            )
    except (SceneError, AirframeError, sim.BenchError, LaunchError) as error:
        fail(_PROG, str(error))
    if cfg.json:
        print(json.dumps(_to_plain(cfg, rows)))
    else:
        _print_table(cfg, rows)
    return EXIT_DONE if all(row.is_met for row in rows) else EXIT_NEGATIVE


def _to_plain(cfg: BenchCfg, rows: tuple[Row, ...]) -> dict[str, Any]:
    return {
        "bench": cfg.name,
        "scene": cfg.scene,
        "vehicle": cfg.vehicle,
        "seconds": cfg.seconds,
        "rows": [row.to_plain() for row in rows],
    }


def _print_table(cfg: BenchCfg, rows: tuple[Row, ...]) -> None:
    title = f"scene {cfg.scene}, {cfg.vehicle}, {cfg.seconds:g} simulated seconds"
    table = Table("metric", "value", "unit", "target", title=title, title_justify="left")
    for row in rows:
        target = ""
        if row.target is not None:
            sign = "≥" if row.better == "higher" else "≤"
            style = "green" if row.is_met else "bold red"
            target = f"[{style}]{sign} {row.target:g}[/]"
        table.add_row(row.metric, f"{row.value:.4g}", row.unit, target)
    Console().print(table)
