"""`aeroscene bench`: how fast this machine is, how good a scene model is, how a vehicle flies."""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated, Any

import tyro
from rich.table import Table

from scenarios.bench.configs import (
    AnyBenchCfg,
    BenchError,
    ControlBenchCfg,
    GenerateBenchCfg,
    MethodBenchCfg,
    SceneBenchCfg,
    SimBenchCfg,
    VehiclesBenchCfg,
    WorldsBenchCfg,
)
from scenarios.bench.row import Row
from scenarios.cli.command_line import EXIT_DONE, EXIT_NEGATIVE, fail, print_json
from scenarios.cli.progress import share_bar
from scenarios.cli.terminal import styled, terminal

_PROG = "aeroscene bench"

Bench = (
    Annotated[SimBenchCfg, tyro.conf.subcommand("sim", prefix_name=False)]
    | Annotated[SceneBenchCfg, tyro.conf.subcommand("scene", prefix_name=False)]
    | Annotated[GenerateBenchCfg, tyro.conf.subcommand("generate", prefix_name=False)]
    | Annotated[MethodBenchCfg, tyro.conf.subcommand("method", prefix_name=False)]
    | Annotated[ControlBenchCfg, tyro.conf.subcommand("control", prefix_name=False)]
    | Annotated[WorldsBenchCfg, tyro.conf.subcommand("worlds", prefix_name=False)]
    | Annotated[VehiclesBenchCfg, tyro.conf.subcommand("vehicles", prefix_name=False)]
)

# tyro keeps the names of subcommands to itself, so modules and `--json` need them once more.
_NAMES: Mapping[type, str] = {
    SimBenchCfg: "sim",
    SceneBenchCfg: "scene",
    GenerateBenchCfg: "generate",
    MethodBenchCfg: "method",
    ControlBenchCfg: "control",
    WorldsBenchCfg: "worlds",
    VehiclesBenchCfg: "vehicles",
}


@dataclass(frozen=True, kw_only=True)
class BenchCfg:
    """Measure how fast this machine is, or how good generated scenes are.

    Exit status 0 if every target is met, else 1.
    """

    bench: Bench


def run(cfg: BenchCfg) -> int:
    """Run the benchmark that the command line chose, and print its table or JSON object.

    Returns:
        0 if every target is met, else 1. If the benchmark cannot run, the process exits with
        status 2 and one line that names the reason.
    """
    # Imported here because it is the whole stack, which `--help` does not need.
    from aeroscene.scene import SceneError

    try:
        module = _module(cfg.bench)
    except SceneError as error:
        fail(_PROG, str(error))
    status = measure(_PROG, _NAMES[type(cfg.bench)], cfg.bench, module)
    if isinstance(cfg.bench, GenerateBenchCfg):
        # A part of the corpus gives other figures than the whole one.
        from scenarios.cli.dataset.options import mention_shortfall

        mention_shortfall(_PROG, cfg.bench.data)
    return status


def measure(prog: str, name: str, bench: AnyBenchCfg, module: Any) -> int:
    """Run one benchmark with a progress bar, print its rows, and return the exit status.

    Args:
        prog: Command that names itself in errors.
        name: Name of the benchmark in `--json`.
        bench: Options of the benchmark.
        module: Module whose `rows(options, on_progress)` measures.
    """
    from aeroscene.scene import SceneError
    from flightsim.vehicles.catalogue import AirframeError
    from scenarios.bench.launch import LaunchError

    try:
        with share_bar() as on_progress:
            rows = tuple(module.rows(bench, on_progress))
    except (SceneError, AirframeError, BenchError, LaunchError) as error:
        fail(prog, str(error))
    if bench.json:
        print_json(_to_plain(name, bench, rows))
    else:
        _print_table(bench, rows)
    return EXIT_DONE if all(row.is_met for row in rows) else EXIT_NEGATIVE


def _module(bench: AnyBenchCfg) -> Any:
    """Import and return the module of a benchmark, after cheap checks of its checkpoint.

    `bench generate --scenes` measures existing scenes. It has a module of its own, because it needs
    no PyTorch.
    """
    is_made = isinstance(bench, GenerateBenchCfg) and bench.scenes is not None
    if isinstance(bench, GenerateBenchCfg | MethodBenchCfg) and not is_made:
        from aeroscene.learning import require_torch

        require_torch()
        if bench.checkpoint is not None:
            # The head of the file alone: a wrong file is refused before PyTorch is loaded.
            from aeroscene.learning.training.presets import read_sections

            read_sections(bench.checkpoint)
    name = "existing_scenes" if is_made else _NAMES[type(bench)]
    return importlib.import_module(f"scenarios.bench.{name}")


def _to_plain(name: str, bench: AnyBenchCfg, rows: tuple[Row, ...]) -> dict[str, Any]:
    options = {key: str(v) if isinstance(v, Path) else v for key, v in asdict(bench).items()}
    del options["json"]
    return {"bench": name, **options, "rows": [row.to_plain() for row in rows]}


def _print_table(bench: AnyBenchCfg, rows: tuple[Row, ...]) -> None:
    table = Table("metric", "value", "unit", "target", title=bench.title, title_justify="left")
    for row in rows:
        target = styled()
        if row.target is not None:
            sign = "≥" if row.better == "higher" else "≤"
            style = "green" if row.is_met else "bold red"
            target = styled((f"{sign} {row.target:g}", style))
        table.add_row(row.metric, f"{row.value:.4g}", row.unit, target)
    terminal().print(table)
