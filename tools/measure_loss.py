"""Missions, fences, rally points and parameters through a UDP proxy that loses datagrams.

    python tools/measure_loss.py                      # 20 runs each at 0, 10 and 25%, minutes
    python tools/measure_loss.py --runs 3 --loss 0.25 --items 100 --json

Every run uploads, downloads and compares with what was sent, over a proxy with a seed of its own. A
client that gives up is told apart from one that was told something wrong. The exit status is 1
where a run did not end with all of it equal.
"""

from __future__ import annotations

import argparse
import json
import socket
import statistics
import struct
import sys
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass

from loss.client import GaveUpError, Item, PatientClient
from loss.proxy import LossyProxy

from aeroscene.sources import load_scene
from flightsim.mavlink.dialect import dialect as mav
from flightsim.mavlink.links import UdpLink
from flightsim.testbench import Testbench, TestbenchCfg

PARTS = ("mission", "parameters", "fence", "rally")
_GLOBAL, _RELATIVE = 0, 3  # MAV_FRAME: height above sea level, and above home
_N_CORNERS, _N_RALLY = 60, 30


@dataclass(frozen=True, kw_only=True)
class Run:
    """Outcome of one client's session."""

    outcome: dict[str, str]
    """For each part "equal", "different", or the reason for which the client gave up."""
    sim_s: float
    n_repeats: int
    n_lost: int
    n_carried: int


@dataclass(frozen=True, kw_only=True)
class Row:
    """Outcome of all runs at one loss."""

    loss: float
    n_runs: int
    n_equal: dict[str, int]
    """Number of runs in which each part came back equal."""
    n_different: int
    n_gave_up: int
    median_sim_s: float
    median_repeats: float
    lost_share: float

    @property
    def is_sound(self) -> bool:
        """True if every run ended with every part equal."""
        return all(number == self.n_runs for number in self.n_equal.values())


def run(loss: float, seed: int, *, n_items: int = 500, tries: int = 20) -> Run:
    """Transfer everything there and back once.

    Args:
        loss: Share of the datagrams that is lost, 0 to 1.
        seed: Seed of the losses.
        n_items: Number of mission items.
        tries: Number of times that the client says the same thing before it gives up.
    """
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as end:
        end.bind(("127.0.0.1", 0))
        end.setblocking(False)
        proxy = LossyProxy(end.getsockname(), loss, seed)
        link = UdpLink(local_port=0, remote_port=proxy.vehicle_port, is_lockstep=True)
        cfg = TestbenchCfg(speed="max")
        with Testbench(load_scene("field"), cfg, has_network=False, links=[[link]]) as bench:
            # The vehicle needs a moment to start, and its first datagram gives the proxy its
            # address.
            bench.run(3.0)
            start_us = bench.plant.time_us
            client = PatientClient(bench, proxy, end, tries)
            outcome = {part: _outcome(part, client, bench, n_items) for part in PARTS}
            sim_s = (bench.plant.time_us - start_us) * 1e-6
        proxy.close()
    return Run(
        outcome=outcome,
        sim_s=sim_s,
        n_repeats=client.n_repeats,
        n_lost=proxy.n_lost,
        n_carried=proxy.n_carried,
    )


def _outcome(part: str, client: PatientClient, bench: Testbench, n_items: int) -> str:
    try:
        if part == "parameters":
            return _verdict(client.parameters() == _parameters(bench))
        mission_type, items = _LISTS[part](bench, n_items)
        client.upload(mission_type, items)
        return _verdict(client.download(mission_type) == list(items))
    except GaveUpError as error:
        return str(error)


def _verdict(is_equal: bool) -> str:
    return "equal" if is_equal else "different"


def _parameters(bench: Testbench) -> dict[str, bytes]:
    # As a vehicle of PX4 sends them: integers bytewise, others as floats.
    parameters = bench.autopilot.parameters
    return {
        name: struct.pack("<i", int(parameters[name]))
        if parameters.is_integer(name)
        else struct.pack("<f", parameters[name])
        for name in parameters
    }


def _places(bench: Testbench, number: int, spread: int) -> list[tuple[int, int]]:
    """Places near the start, latitude and longitude in 1e-7 degrees, no two of them equal.

    Args:
        bench: Testbench whose scene has the start.
        number: Number of places.
        spread: Distance of neighbours in 1e-7 degrees, about a centimetre.
    """
    scene = bench.scene
    x0, y0 = round(scene.latitude_deg * 1e7), round(scene.longitude_deg * 1e7)
    return [(x0 + spread * (n % 20), y0 + spread * (n // 20)) for n in range(number)]


def _mission(bench: Testbench, n_items: int) -> tuple[int, Sequence[Item]]:
    # All values have an exact form in single precision, so that they come back equal.
    items: list[Item] = [
        (
            _RELATIVE,
            mav.MAV_CMD_NAV_WAYPOINT,
            n % 3,
            1.5,
            0.0,
            n % 360 - 180.0,
            *place,
            10.0 + n / 8,
        )
        for n, place in enumerate(_places(bench, n_items, 100))
    ]
    return mav.MAV_MISSION_TYPE_MISSION, items


def _fence(bench: Testbench, _: int) -> tuple[int, Sequence[Item]]:
    vertex = mav.MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION
    items: list[Item] = [
        (_GLOBAL, vertex, float(_N_CORNERS), 0.0, 0.0, 0.0, *place, 0.0)
        for place in _places(bench, _N_CORNERS, 3000)
    ]
    return mav.MAV_MISSION_TYPE_FENCE, items


def _rally(bench: Testbench, _: int) -> tuple[int, Sequence[Item]]:
    items: list[Item] = [
        (_RELATIVE, mav.MAV_CMD_NAV_RALLY_POINT, 0.0, 0.0, 0.0, 0.0, *place, 20.0)
        for place in _places(bench, _N_RALLY, 1000)
    ]
    return mav.MAV_MISSION_TYPE_RALLY, items


_LISTS: dict[str, Callable[[Testbench, int], tuple[int, Sequence[Item]]]] = {
    "mission": _mission,
    "fence": _fence,
    "rally": _rally,
}


def summed_up(loss: float, runs: Sequence[Run]) -> Row:
    """Sum up all runs at one loss.

    Args:
        loss: Share of the datagrams that was to be lost.
        runs: Runs, one at least.
    """
    outcomes = [outcome for run in runs for outcome in run.outcome.values()]
    n_lost = sum(run.n_lost for run in runs)
    return Row(
        loss=loss,
        n_runs=len(runs),
        n_equal={part: sum(run.outcome[part] == "equal" for run in runs) for part in PARTS},
        n_different=outcomes.count("different"),
        n_gave_up=sum(outcome not in {"equal", "different"} for outcome in outcomes),
        median_sim_s=round(statistics.median(run.sim_s for run in runs), 1),
        median_repeats=statistics.median(run.n_repeats for run in runs),
        lost_share=round(n_lost / (n_lost + sum(run.n_carried for run in runs)), 3),
    )


def main() -> int:
    """Measure at the losses of the command line, and print a row for each.

    Returns:
        Exit status: 1 if a run did not end with every part equal.
    """
    parser = argparse.ArgumentParser(description="Transfers through a lossy UDP proxy")
    parser.add_argument("--loss", type=float, action="append", help="default: 0, 0.1 and 0.25")
    parser.add_argument("--runs", type=int, default=20, help="runs at each loss")
    parser.add_argument("--items", type=int, default=500, help="mission items")
    parser.add_argument("--tries", type=int, default=20, help="times that the client says a thing")
    parser.add_argument("--json", action="store_true", help="print a JSON row for each loss")
    options = parser.parse_args()
    is_sound = True
    for loss in options.loss or (0.0, 0.1, 0.25):
        runs = [
            run(loss, seed, n_items=options.items, tries=options.tries)
            for seed in range(options.runs)
        ]
        row = summed_up(loss, runs)
        is_sound &= row.is_sound
        if options.json:
            print(json.dumps(asdict(row)), flush=True)
            continue
        parts = ", ".join(f"{part} {row.n_equal[part]}/{row.n_runs}" for part in PARTS)
        print(
            f"{loss:.0%} lost: equal {parts}; different {row.n_different}, gave up "
            f"{row.n_gave_up}; {row.median_sim_s:.0f} s, {row.median_repeats:.0f} repeats",
            flush=True,
        )
    return 0 if is_sound else 1


if __name__ == "__main__":
    sys.exit(main())
