"""Sends the goal in words to MAVLink clients, as messages for people."""

from __future__ import annotations

import math

from flightsim.autopilot.events import Severity
from flightsim.testbench import Testbench, Vehicle

GOAL = "Goal: "
"""Beginning of the message."""
_EVERY_US = 5_000_000
"""Simulated time between two messages, so that a client that connects later gets one too."""


def announce_goal(bench: Testbench, vehicle: Vehicle, text: str) -> None:
    """Send a text as STATUSTEXT every five seconds until the vehicle is armed.

    Args:
        bench: Testbench whose ticks are counted.
        vehicle: Vehicle of the goal. A vehicle with an external flight stack gets none, because
            such a stack does not pass these messages on.
        text: The goal.
    """
    if vehicle.external is not None:
        return
    autopilot, statustext = vehicle.autopilot, vehicle.own.server.statustext
    next_us: float = 0

    def on_tick() -> None:
        nonlocal next_us
        if autopilot.is_armed:
            next_us = math.inf
        elif vehicle.plant.time_us >= next_us:
            next_us = vehicle.plant.time_us + _EVERY_US
            statustext.broadcast(Severity.NOTICE, GOAL + text)

    bench.observers.append(on_tick)
