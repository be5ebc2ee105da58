"""Fly the demo in many scenes with every vehicle and print the figures of docs/notebook.md.

python tools/fly_demos.py --scenes 40:50
"""

from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import dataclass
from typing import Any

import tyro
from rich.console import Console
from rich.progress import track
from rich.table import Table

COLUMNS = {
    "scene": "scene",
    "vehicle": "vehicle",
    "code": "code",
    "contacts_before_touchdown": "contacts",
    "touchdown_error_m": "touchdown m",
    "sim_seconds": "simulated s",
    "position_rmse_m": "position m",
    "attitude_rmse_deg": "attitude deg",
    "real_time_factor": "x real time",
}
"""Name of a figure in `--json`, and its heading."""


@dataclass(frozen=True, kw_only=True)
class FlyCfg:
    """Fly the demo in a range of scenes."""

    scenes: str = "40:50"
    """First scene and the one after the last."""
    vehicles: tuple[str, ...] = ("iris", "hummingbird")
    """Airframes to fly."""
    seed: int = 0
    """Seed of every flight."""
    instance: int = 9
    """Shifts the MAVLink ports."""


def fly(cfg: FlyCfg, scene: int, vehicle: str) -> dict[str, Any]:
    """One flight in a process of its own; the object that `--json` prints."""
    command = [sys.executable, "-m", "scenarios.cli.sitl", "--demo", "--json", "--speed", "max"]
    options = {"scene": scene, "vehicle": vehicle, "seed": cfg.seed, "instance": cfg.instance}
    for name, value in options.items():
        command += [f"--{name}", str(value)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)  # noqa: S603
    if not done.stdout:
        sys.exit(done.stderr)
    return json.loads(done.stdout)


def main(cfg: FlyCfg) -> None:
    """Fly them all and print a table."""
    first, end = map(int, cfg.scenes.split(":"))
    flights = [(scene, vehicle) for vehicle in cfg.vehicles for scene in range(first, end)]
    progress = track(flights, console=Console(stderr=True), description="flying")
    results = [fly(cfg, scene, vehicle) for scene, vehicle in progress]
    table = Table(*COLUMNS.values())
    for result in results:
        table.add_row(*(_cell(result[column]) for column in COLUMNS))
    console = Console(width=120)
    console.print(table)
    failed = [result for result in results if not result["success"]]
    console.print(f"{len(results) - len(failed)} of {len(results)} landed within every limit")
    for result in failed:
        console.print(
            f"{result['scene']}, {result['vehicle']}: {result['code']}: {result['reason']}"
        )


def _cell(value: object) -> str:
    return f"{value:.3g}" if isinstance(value, float) else str(value)


if __name__ == "__main__":
    main(tyro.cli(FlyCfg))
