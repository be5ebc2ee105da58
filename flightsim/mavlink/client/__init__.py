"""A MAVLink client for companions: commands, setpoints and telemetry in ENU."""

from flightsim.mavlink.client.client import (
    PX4_HOLD,
    PX4_LAND,
    PX4_OFFBOARD,
    PX4_RETURN,
    BytePipe,
    Command,
    CommandState,
    MavlinkClient,
)
from flightsim.mavlink.client.telemetry import Telemetry

__all__ = [
    "PX4_HOLD",
    "PX4_LAND",
    "PX4_OFFBOARD",
    "PX4_RETURN",
    "BytePipe",
    "Command",
    "CommandState",
    "MavlinkClient",
    "Telemetry",
]
