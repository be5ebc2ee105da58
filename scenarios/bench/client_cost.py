"""Cost of a UDP client for each tick: the same flight with and without it, in turns of 100 ticks.

Turns are short, so that a slow moment of the machine meets all flights alike. Times are CPU times
of the thread: by the wall clock, a client that wakes on the same core would count too.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack
from statistics import median

from aeroscene.scene import Scene
from flightsim.mavlink.links import UdpLink
from flightsim.mavlink.streams import Profile
from flightsim.simulator import TICK_US
from flightsim.testbench import Testbench, TestbenchCfg
from scenarios.bench.clients import Clients
from scenarios.bench.row import Row, lower
from scenarios.bench.square_flight import take_off

MOST_CLIENT_US = 12.0
"""Target of the time that one client adds to a tick."""
_CLIENTS: Mapping[str, Sequence[Profile]] = {
    "": (),
    "a ground station": ("normal",),
    "a companion": ("onboard",),
    "a ground station and a companion": ("normal", "onboard"),
}
_TICKS_IN_TURN = 100


def client_rows(scene: Scene, vehicle: str, seconds: float) -> Iterator[Row]:
    """Measure MAVLink's tick of hovering vehicles, each with other clients.

    Args:
        scene: Scene to hover in.
        vehicle: Airframe by its name.
        seconds: Simulated seconds of each vehicle.

    Raises:
        BenchError: If the vehicle does not fly.
    """
    costs_us: dict[str, list[float]] = {name: [] for name in _CLIENTS}
    with ExitStack() as stack:
        ports = iter(stack.enter_context(Clients(sum(map(len, _CLIENTS.values())))).ports)
        benches: dict[str, Testbench] = {}
        for name, profiles in _CLIENTS.items():
            links = [
                UdpLink(local_port=0, remote_port=next(ports), profile=profile)
                for profile in profiles
            ]
            # Links are passed in, so that the benches need no ports of their own.
            cfg = TestbenchCfg(vehicle=vehicle, speed="max")
            bench = Testbench(scene, cfg, has_network=False, links=[links])
            benches[name] = stack.enter_context(bench)
            take_off(bench)
        for _ in range(max(1, round(seconds * 1e6 / TICK_US / _TICKS_IN_TURN))):
            # Each turn has all benches one after the other, so that they can be compared pairwise.
            for name, bench in benches.items():
                costs_us[name].append(_tick_us(bench))
    yield lower("CPU of MAVLink's tick without a client", median(costs_us[""]), "us")
    for name, profiles in _CLIENTS.items():
        if profiles:
            # Differences of neighbouring turns, whose median ignores turns that were disturbed.
            more = median(
                us - alone for us, alone in zip(costs_us[name], costs_us[""], strict=True)
            )
            target = MOST_CLIENT_US * len(profiles)
            yield lower(f"CPU that {name} adds", more, "us", target)


def _tick_us(bench: Testbench) -> float:
    """Return the mean CPU time of MAVLink in a tick, in us."""
    # Looked up before the loop, whose own cost would otherwise be measured.
    clock, update = time.thread_time_ns, bench.server.update
    spent_ns = 0
    for _ in range(_TICKS_IN_TURN):
        bench.plant.advance()
        bench.autopilot.update()
        start_ns = clock()
        update()
        spent_ns += clock() - start_ns
    return 1e-3 * spent_ns / _TICKS_IN_TURN
