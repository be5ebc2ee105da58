"""Hostile but legal MAVLink against a hovering vehicle, on each link.

    python tools/fuzz_mavlink.py                       # 100,000 frames for each row, minutes
    python tools/fuzz_mavlink.py --frames 10000000 --link udp --kind hover --log udp.jsonl

Two kinds of traffic: `hover` is all that should not move a vehicle, and its twin that nobody talks
to says where it would be; `wild` is everything, and the vehicle starts again where it has been
brought down. Both start again when a battery runs low. Prints a JSON row for each kind and link; a
log has one for every twentieth of the way besides. The exit status is 1 where one of them breaks a
limit.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Literal

import psutil
from fuzzing.clients import LINKS, LinkName
from fuzzing.frames import Traffic
from fuzzing.vehicles import Vehicle

from flightsim.mavlink.personalities import PERSONALITIES

# Limit of docs/results.md; ten million frames moved the hover by less than half a millimetre.
MOST_DEVIATION_M = 0.05
MOST_GROWTH_MB = 20.0
_CHECK_EVERY = 50
"""Ticks between two pings of an honest client: a second."""
_N_PARTS, _N_WARM_PARTS = 20, 4
"""Parts of the frames, and how many of them pass before memory counts as filled."""

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
    """Number of times that a fresh vehicle took the place of a spent or fallen one."""
    cpu_s: float

    @property
    def is_sound(self) -> bool:
        """True if every limit is kept: no fault, no greater deviation or growth than allowed."""
        holds = self.deviation_m is None or self.deviation_m <= MOST_DEVIATION_M
        return self.n_faults == 0 and holds and self.growth_mb <= MOST_GROWTH_MB


class Siege:
    """A vehicle under fire, what became of it so far, and its twin that nobody talks to."""

    def __init__(
        self, kind: Kind, link: LinkName, seed: int, n_clients: int, personality: str
    ) -> None:
        self._start_s = time.process_time()
        self._kind: Kind = kind
        self._link: LinkName = link
        self._seed = seed
        self._n_clients, self._personality = n_clients, personality
        self._traffic = Traffic(seed, is_obeyed=kind == "wild").frames()
        # Same seed and same scene: without traffic both fly alike to the last bit.
        self._vehicle = Vehicle(link, n_clients, personality)
        self._twin = Vehicle(None, personality=personality) if kind == "hover" else None
        self._deviation_m = 0.0
        self._n_before = self._n_restarts = self._n_faults = self._n_ticks = 0
        self._fault: str | None = None
        self._warm_bytes: int | None = None

    @property
    def n_frames(self) -> int:
        """Frames that the vehicle received, decoded and handled so far."""
        return self._n_before + self._vehicle.n_received

    def warm_up(self) -> None:
        """Count memory from here."""
        self._warm_bytes = _resident_bytes()

    def tick(self) -> None:
        """Fire for 20 ms of simulated time, and look after the vehicle once a second.

        Raises:
            DeadVehicleError: If an honest client is no longer answered.
            Exception: Whatever ends the loop of the simulation.
        # Nothing else may tell them apart, so that the twin is stepped whenever the vehicle is.
        """
        self._vehicle.tick(self._traffic)
        self._n_ticks += 1
        if self._twin is not None:
            self._twin.tick()
            both = (each.bench.plant.truth.position_enu_m for each in (self._vehicle, self._twin))
            self._deviation_m = max(self._deviation_m, math.dist(*both))
        if self._n_ticks % _CHECK_EVERY:
            return
        self._vehicle.require_life()
        # The check has stepped the vehicle.
        if self._twin is not None:
            self._twin.tick()
        # Where a twin flies, a vehicle that has come down is no reason to begin again: its
        # deviation is the finding.
        if self._vehicle.is_spent or (self._twin is None and not self._vehicle.is_flying):
            self._restart()

    def _restart(self) -> None:
        # Frames and faults are those of the vehicle, which goes.
        self._n_before, self._n_restarts = self.n_frames, self._n_restarts + 1
        self._count_faults()
        self._vehicle.close()
        self._vehicle = Vehicle(self._link, self._n_clients, self._personality)
        if self._twin is not None:
            self._twin.close()
            self._twin = Vehicle(None, personality=self._personality)

    def _count_faults(self) -> None:
        faults = self._vehicle.bench.server.faults
        self._n_faults, self._fault = self._n_faults + faults.n_caught, self._fault or faults.last

    def row(self) -> Row:
        """Row of the outcome so far."""
        faults = self._vehicle.bench.server.faults
        growth = 0 if self._warm_bytes is None else _resident_bytes() - self._warm_bytes
        return Row(
            kind=self._kind,
            link=self._link,
            personality=self._personality,
            seed=self._seed,
            n_frames=self.n_frames,
            n_faults=self._n_faults + faults.n_caught,
            fault=self._fault or faults.last,
            deviation_m=None if self._twin is None else self._deviation_m,
            n_restarts=self._n_restarts,
            growth_mb=round(growth / 1e6, 1),
            cpu_s=round(time.process_time() - self._start_s, 1),
        )

    def close(self) -> None:
        """Close every link."""
        for each in filter(None, (self._vehicle, self._twin)):
            each.close()


def fuzz(
    kind: Kind,
    link: LinkName,
    *,
    n_frames: int,
    seed: int = 0,
    n_clients: int = 1,
    personality: str = "px4",
    report: Callable[[Row], None] | None = None,
) -> Row:
    """Send a number of frames that arrive, and see what becomes of the vehicle.

    Args:
        kind: Kind of traffic.
        link: Link of the hostile clients.
        n_frames: Number of frames that are to be received, decoded and handled.
        seed: Seed of the traffic.
        n_clients: Number of hostile clients.
        personality: Flight stack that the vehicle imitates.
        report: Called with what became of it so far, at every twentieth of the frames.

    Raises:
        DeadVehicleError: If an honest client is no longer answered.
        Exception: Whatever ends the loop of the simulation.
    """
    siege = Siege(kind, link, seed, n_clients, personality)
    # Buffers and caches of a fixed size fill up in the first fifth, which is no leak.
    for part in range(1, _N_PARTS + 1):
        while siege.n_frames < n_frames * part / _N_PARTS:
            siege.tick()
        if part == _N_WARM_PARTS:
            siege.warm_up()
        if report is not None:
            report(siege.row())
    row = siege.row()
    siege.close()
    return row


def _resident_bytes() -> int:
    return psutil.Process().memory_info().rss


def main() -> int:
    """Fuzz what the command line asks for, and print a row for each kind and link.

    Returns:
        Exit status: 1 if a row breaks a limit.
    """
    parser = argparse.ArgumentParser(description="Hostile MAVLink on each link")
    parser.add_argument("--frames", type=int, default=100_000, help="frames of each row")
    parser.add_argument("--link", choices=LINKS, action="append", help="default: each of them")
    parser.add_argument("--kind", choices=KINDS, action="append", help="default: both")
    parser.add_argument("--personality", choices=tuple(PERSONALITIES), default="px4")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--clients", type=int, default=4, help="hostile clients at a time")
    parser.add_argument("--log", type=Path, help="file that rows on the way are appended to")
    options = parser.parse_args()

    def report(row: Row) -> None:
        if options.log is not None:
            with options.log.open("a") as file:
                file.write(json.dumps(asdict(row)) + "\n")

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
                report=report,
            )
            print(json.dumps(asdict(row)), flush=True)
            is_sound &= row.is_sound
    return 0 if is_sound else 1


if __name__ == "__main__":
    sys.exit(main())
