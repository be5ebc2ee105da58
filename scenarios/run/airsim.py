"""The door for AirSim's clients of a run; only runs that ask for it import this module."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path

from flightsim.testbench import Testbench, TestbenchError
from scenarios.airsim.door import AirsimDoor, Guest
from scenarios.airsim.settings import PORT, AirsimSettings, read_settings
from scenarios.run.cfg import SitlCfg
from scenarios.run.flight import Flight


def with_settings(cfg: SitlCfg, path: Path) -> tuple[SitlCfg, AirsimSettings]:
    """Configuration of a run with what a settings.json asks for, and these settings.

    Options of the command line that are not at their default stay as they are.

    Raises:
        TestbenchError: If the file is no settings.json, or names vehicles beside --vehicles.
    """
    settings = read_settings(path)
    n = len(settings.vehicles)
    if n and cfg.vehicles:
        raise TestbenchError(
            f"vehicles {cfg.vehicles!r} stands beside the {n} of airsim-settings {str(path)!r}; "
            "valid: one of the two"
        )
    speed = settings.clock_speed if cfg.bench.speed == 1.0 else cfg.bench.speed
    port = settings.port if cfg.airsim_port == PORT else cfg.airsim_port
    vehicles = str(n) if n > 1 else cfg.vehicles
    bench = replace(cfg.bench, speed=speed)
    return replace(cfg, airsim=True, airsim_port=port, vehicles=vehicles, bench=bench), settings


def open_airsim(
    cfg: SitlCfg,
    settings: AirsimSettings | None,
    bench: Testbench,
    flights: Sequence[Flight],
    stack: ExitStack,
) -> AirsimDoor:
    """Answer clients from now on, and fly vehicles that no pilot of ours flies.

    Args:
        cfg: Configuration of the run.
        settings: What a settings.json asks for; None without one.
        bench: Its testbench.
        flights: Flight of each vehicle.
        stack: Closes the door.

    Raises:
        TestbenchError: If the port is taken.
    """
    guests = [_guest(flight) for flight in flights]
    door = AirsimDoor(guests, settings or AirsimSettings(), port=cfg.airsim_port)
    stack.enter_context(door)
    bench.observers.append(door.on_tick)
    bench.simulator.interlude = door
    return door


def _guest(flight: Flight) -> Guest:
    is_free = flight.companion is None
    return Guest(vehicle=flight.vehicle, connect=flight.vehicle.connect if is_free else None)
