"""Fly the demo in many scenes with every vehicle; print the figures of docs/notebook.md.

    python tools/fly_demos.py --scenes 40:50
    python tools/fly_demos.py --autopilot px4 --autopilot-binary px4 --out runs/px4

With `--out` each flight is recorded, and its distance from the planned path measured; the figures
of docs/flight_stacks.md are the medians of each vehicle.
"""

from __future__ import annotations

import json
import statistics
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
import tyro
from judging.recording import read_recording
from measure_tracking import tracking_errors_m
from rich.progress import track
from rich.table import Table

from scenarios.cli.terminal import terminal

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
MEDIANS = {
    "touchdown_error_m": "touchdown m",
    "touchdown_speed_mps": "touchdown m/s",
    "flight_s": "flight s",
    "energy_j": "energy J",
    "tracking_rmse_m": "off the path m",
    "position_rmse_m": "position m",
    "attitude_rmse_deg": "attitude deg",
    "cpu_seconds": "CPU s",
    "real_time_factor": "x real time",
}
"""Figures of which each vehicle's median is printed, and their headings."""


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
    autopilot: Literal["builtin", "px4", "ardupilot"] = "builtin"
    """Flight stack."""
    autopilot_binary: Path | None = None
    """Program of a flight stack that is not ours."""
    out: Path | None = None
    """Folder for the recordings; none keeps none."""


def fly(cfg: FlyCfg, scene: int, vehicle: str) -> dict[str, Any]:
    """Fly once, in a process of its own.

    Args:
        cfg: Settings of all flights.
        scene: Number of the scene.
        vehicle: Airframe.

    Returns:
        The object that `--json` prints, with the errors of tracking if the flight is recorded.

    Raises:
        SystemExit: If the process printed no result, with what it said on standard error.
    """
    # A process each, as a user flies: with no state of an earlier flight, and the speed of a fresh
    # start.
    command = [sys.executable, "-m", "scenarios.cli.sitl", "--demo", "--json", "--speed", "max"]
    options: dict[str, Any] = {"scene": scene, "vehicle": vehicle}
    options |= {"seed": cfg.seed, "instance": cfg.instance}
    options["autopilot"] = cfg.autopilot
    if cfg.autopilot_binary is not None:
        options["autopilot-binary"] = cfg.autopilot_binary
    record = cfg.out and cfg.out / f"{vehicle}-{scene}.rrd"
    if record is not None:
        # Cameras would be most of the file, and tracking needs none.
        options |= {"record": record, "camera-hz": 0}
    for name, value in options.items():
        command += [f"--{name}", str(value)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)  # noqa: S603
    if not done.stdout:
        sys.exit(done.stderr)
    result = json.loads(done.stdout)
    if record is not None:
        errors_m = tracking_errors_m(read_recording(record))
        if len(errors_m):  # A plan begins where the pilot believes to be, which may be elsewhere.
            result["tracking_rmse_m"] = float(np.sqrt(np.mean(errors_m**2)))
            result["tracking_max_m"] = float(errors_m.max())
    return result


def main(cfg: FlyCfg) -> None:
    """Fly every vehicle in every scene, and print a table of flights, medians and failures."""
    if cfg.out is not None:
        cfg.out.mkdir(parents=True, exist_ok=True)
    first, end = map(int, cfg.scenes.split(":"))
    flights = [(scene, vehicle) for vehicle in cfg.vehicles for scene in range(first, end)]
    progress = track(flights, console=terminal(stderr=True), description="flying")
    results = [fly(cfg, scene, vehicle) for scene, vehicle in progress]
    table = Table(*COLUMNS.values())
    for result in results:
        table.add_row(*(_cell(result[column]) for column in COLUMNS))
    console = terminal(width=150)
    console.print(table)
    console.print(medians(results))
    failed = [result for result in results if not result["success"]]
    console.print(f"{len(results) - len(failed)} of {len(results)} landed within every limit")
    for result in failed:
        console.print(
            f"{result['scene']}, {result['vehicle']}: {result['code']}: {result['reason']}"
        )


def medians(results: Sequence[dict[str, Any]]) -> Table:
    """Table of each vehicle's medians over its flights that landed within every limit.

    Args:
        results: Results of `fly`. A figure that no flight of a vehicle has shows as "-".
    """
    table = Table("medians", "landed", *MEDIANS.values())
    for vehicle in dict.fromkeys(result["vehicle"] for result in results):
        flown = [result for result in results if result["vehicle"] == vehicle]
        landed = [result for result in flown if result["success"]]
        found = [[result[name] for result in landed if name in result] for name in MEDIANS]
        cells = [_cell(statistics.median(values)) if values else "-" for values in found]
        table.add_row(vehicle, f"{len(landed)} of {len(flown)}", *cells)
    return table


def _cell(value: object) -> str:
    return f"{value:.3g}" if isinstance(value, float) else str(value)


if __name__ == "__main__":
    main(tyro.cli(FlyCfg))
