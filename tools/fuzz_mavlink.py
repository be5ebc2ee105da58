"""Hostile but legal MAVLink against a hovering vehicle, on each link.

    python tools/fuzz_mavlink.py                       # 100,000 frames for each row, minutes
    python tools/fuzz_mavlink.py --frames 10000000 --link udp --seed 3

Two kinds of traffic: `hover` is all that should not move a vehicle, and its twin that nobody talks
to says where it would be; `wild` is everything, and the vehicle starts again where it has been
brought down. Prints a JSON row for each kind and link; the exit status is 1 where one of them
breaks a limit.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
import time
from dataclasses import asdict, dataclass
from typing import Literal

import psutil
from fuzzing.frames import Traffic
from fuzzing.vehicles import LINKS, LinkName, Vehicle

from flightsim.mavlink.personalities import PERSONALITIES

MOST_DEVIATION_M = 0.05
MOST_GROWTH_MB = 20.0
_CHECK_EVERY = 50
"""Ticks between two pings of an honest client: a second."""
_WARM_SHARE = 0.2
"""Share of the frames after which memory counts as filled."""

Kind = Literal["hover", "wild"]
KINDS: tuple[Kind, ...] = ("hover", "wild")


@dataclass(frozen=True, kw_only=True)
class Row:
    """Outcome of one kind of traffic on one link."""

    kind: Kind
    link: LinkName
    personality: str
    seed: int
    n_frames: int
    """Frames that the vehicle received, decoded and handled."""
    n_faults: int
    """Errors of ours in answering them, which were contained."""
    fault: str | None
    deviation_m: float | None
    """Greatest distance from where the twin was at the same time; hover only."""
    n_restarts: int
    growth_mb: float
    """Growth of the process after the first fifth of the frames."""
    cpu_s: float

    @property
    def is_sound(self) -> bool:
        """Whether every limit is kept."""
        holds = self.deviation_m is None or self.deviation_m <= MOST_DEVIATION_M
        return self.n_faults == 0 and holds and self.growth_mb <= MOST_GROWTH_MB


def fuzz(
    kind: Kind,
    link: LinkName,
    *,
    n_frames: int,
    seed: int = 0,
    n_clients: int = 1,
    personality: str = "px4",
) -> Row:
    """Send a number of frames that arrive, and see what becomes of the vehicle.

    Raises:
        DeadVehicleError: If an honest client is no longer answered.
        Exception: Whatever ends the loop of the simulation.
    """
    cpu_s = time.process_time()
    traffic = Traffic(seed, is_obeyed=kind == "wild").frames()
    vehicle = Vehicle(link, n_clients, personality)
    twin = Vehicle(None, personality=personality) if kind == "hover" else None
    deviation_m, n_before, n_restarts, n_faults, fault = 0.0, 0, 0, 0, None
    warm_bytes: int | None = None
    n_ticks = 0
    while (n_received := n_before + vehicle.n_received) < n_frames:
        vehicle.tick(traffic)
        n_ticks += 1
        if warm_bytes is None and n_received >= _WARM_SHARE * n_frames:
            warm_bytes = psutil.Process().memory_info().rss
        if twin is not None:
            twin.tick()
            deviation_m = max(deviation_m, _distance_m(vehicle, twin))
        if n_ticks % _CHECK_EVERY:
            continue
        vehicle.require_life()
        if twin is not None:
            twin.tick()
        elif not vehicle.is_flying:
            n_before, n_restarts = n_before + vehicle.n_received, n_restarts + 1
            n_faults, fault = _faults(vehicle, n_faults, fault)
            vehicle.close()
            vehicle = Vehicle(link, n_clients, personality)
    n_faults, fault = _faults(vehicle, n_faults, fault)
    growth = psutil.Process().memory_info().rss - (warm_bytes or 0)
    for each in filter(None, (vehicle, twin)):
        each.close()
    return Row(
        kind=kind,
        link=link,
        personality=personality,
        seed=seed,
        n_frames=n_received,
        n_faults=n_faults,
        fault=fault,
        deviation_m=None if twin is None else deviation_m,
        n_restarts=n_restarts,
        growth_mb=round(growth / 1e6, 1),
        cpu_s=round(time.process_time() - cpu_s, 1),
    )


def _distance_m(vehicle: Vehicle, twin: Vehicle) -> float:
    both = (each.bench.plant.truth.position_enu_m for each in (vehicle, twin))
    return math.dist(*both)


def _faults(vehicle: Vehicle, n_before: int, before: str | None) -> tuple[int, str | None]:
    faults = vehicle.bench.server.faults
    return n_before + faults.n_caught, before or faults.last


def main() -> int:
    """Fuzz as the command line says."""
    parser = argparse.ArgumentParser(description="Hostile MAVLink on each link")
    parser.add_argument("--frames", type=int, default=100_000, help="frames of each row")
    parser.add_argument("--link", choices=LINKS, action="append", help="default: each of them")
    parser.add_argument("--kind", choices=KINDS, action="append", help="default: both")
    parser.add_argument("--personality", choices=tuple(PERSONALITIES), default="px4")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--clients", type=int, default=4, help="hostile clients at a time")
    options = parser.parse_args()
    is_sound = True
    for link in options.link or LINKS:
        for kind in options.kind or KINDS:
            row = fuzz(
                kind,
                link,
                n_frames=options.frames,
                seed=options.seed,
                n_clients=options.clients,
                personality=options.personality,
            )
            print(json.dumps(asdict(row)), flush=True)
            is_sound &= row.is_sound
    return 0 if is_sound else 1


if __name__ == "__main__":
    sys.exit(main())
