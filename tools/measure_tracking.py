"""Distances of flights from what their pilot planned, by their recordings, whoever flew.

    aeroscene sitl 42 --demo --autopilot px4 --autopilot-binary px4 --speed max --record px4/42.rrd
    python tools/measure_tracking.py px4/*.rrd

Prints a JSON object a recording: root mean square and greatest distance of the vehicle, where it
truly was, from the planned path of the moment. A lag along the path does not count.
"""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np
import tyro
from jaxtyping import Float
from judging.recording import Recording, read_recording

_AT_START_M = 1.5
"""Distance from its start within which a plan is taken up in flight."""


@dataclass(frozen=True, kw_only=True)
class TrackingCfg:
    """How far flights were from what their pilot planned."""

    paths: Annotated[tyro.conf.Positional[tuple[Path, ...]], tyro.conf.arg(metavar="FILE.rrd")]
    """Recordings of flights with a pilot that plans."""


def tracking_errors_m(flight: Recording) -> Float[np.ndarray, " n"]:
    """Distances from the path in effect, at each recorded moment that has one.

    Args:
        flight: Recording; without plans the result is empty.
    """
    errors = [np.empty(0)]
    ends_s = [*(plan.begun_s for plan in flight.plans[1:]), np.inf]
    for plan, replaced_s in zip(flight.plans, ends_s, strict=True):
        until_s = min(plan.begun_s + plan.duration_s, replaced_s)
        is_flown = (flight.time_s >= plan.begun_s) & (flight.time_s < until_s)
        flown_enu_m = flight.position_enu_m[is_flown]
        # A plan for later is shown as well while the vehicle stands.
        if len(flown_enu_m) and math.dist(flown_enu_m[0], plan.points_enu_m[0]) < _AT_START_M:
            errors.append(_distances_m(flown_enu_m, plan.points_enu_m))
    return np.concatenate(errors)


def _distances_m(
    points_m: Float[np.ndarray, "n 3"], path_m: Float[np.ndarray, "m 3"]
) -> Float[np.ndarray, " n"]:
    """Distances of points from a path of straight pieces, m."""
    start_m, piece_m = path_m[:-1], np.diff(path_m, axis=0)
    # Pieces of no length are points.
    squares = np.maximum(np.sum(piece_m**2, axis=1), 1e-12)
    off_m = points_m[:, None] - start_m
    share = np.clip(np.sum(off_m * piece_m, axis=2) / squares, 0.0, 1.0)
    return np.linalg.norm(off_m - share[..., None] * piece_m, axis=2).min(axis=1)


def main(cfg: TrackingCfg) -> None:
    """Print a row for each recording.

    Raises:
        SystemExit: If a recording has no plans.
    """
    for path in cfg.paths:
        errors_m = tracking_errors_m(read_recording(path))
        if not len(errors_m):
            raise SystemExit(f"recording {str(path)!r} has no plans; valid: one of --demo")
        row = {
            "recording": str(path),
            "tracking_rmse_m": round(float(np.sqrt(np.mean(errors_m**2))), 3),
            "tracking_max_m": round(float(errors_m.max()), 3),
        }
        print(json.dumps(row))


if __name__ == "__main__":
    main(tyro.cli(TrackingCfg))
