"""The door to ROS 2 of a run; only runs that ask for it import this module."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack

from flightsim.testbench import Testbench
from scenarios.ros2.door import Guest, Ros2Door
from scenarios.run.cfg import SitlCfg
from scenarios.run.flight import Flight


def open_door(
    cfg: SitlCfg, bench: Testbench, flights: Sequence[Flight], stack: ExitStack
) -> Ros2Door:
    """Publish a run from now on, and take commands for vehicles that no pilot of ours flies.

    Args:
        cfg: Configuration of the run.
        bench: Its testbench.
        flights: Flight of each vehicle.
        stack: Closes the door.

    Raises:
        TestbenchError: If a library is missing, or the transport cannot be opened.
    """
    door = Ros2Door(
        [_guest(flight) for flight in flights],
        transport=cfg.ros2_transport,
        domain=cfg.domain,
        address=cfg.bench.bind,
        instance=cfg.bench.instance,
        camera_hz=cfg.camera_hz,
    )
    stack.enter_context(door)
    bench.observers.extend(door.observers)
    return door


def _guest(flight: Flight) -> Guest:
    is_free = flight.companion is None
    return Guest(
        vehicle=flight.vehicle,
        # Opens the cameras only if a node subscribes.
        render=lambda camera: flight.cameras.render(camera),  # noqa: PLW0108
        connect=flight.vehicle.connect if is_free else None,
    )
