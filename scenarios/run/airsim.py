"""The door for AirSim's clients of a run; only runs that ask for it import this module."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack

from flightsim.testbench import Testbench
from scenarios.airsim.door import AirsimDoor, Guest
from scenarios.run.cfg import SitlCfg
from scenarios.run.flight import Flight


def open_airsim(
    cfg: SitlCfg, bench: Testbench, flights: Sequence[Flight], stack: ExitStack
) -> AirsimDoor:
    """Answer clients from now on, and fly vehicles that no pilot of ours flies.

    Args:
        cfg: Configuration of the run.
        bench: Its testbench.
        flights: Flight of each vehicle.
        stack: Closes the door.

    Raises:
        TestbenchError: If the port is taken.
    """
    door = AirsimDoor(
        [_guest(flight) for flight in flights], address=cfg.bench.bind, port=cfg.airsim_port
    )
    stack.enter_context(door)
    bench.observers.append(door.on_tick)
    bench.simulator.interlude = door
    return door


def _guest(flight: Flight) -> Guest:
    is_free = flight.companion is None
    return Guest(vehicle=flight.vehicle, connect=flight.vehicle.connect if is_free else None)
