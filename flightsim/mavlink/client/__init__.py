"""A MAVLink client for companions: commands, setpoints and telemetry in ENU."""

from flightsim.mavlink.client.client import BytePipe, Command, CommandState, MavlinkClient
from flightsim.mavlink.client.habits import (
    ARDUPILOT_HABITS,
    PX4_HABITS,
    PX4_HOLD,
    PX4_LAND,
    PX4_OFFBOARD,
    PX4_RETURN,
    REAL_PX4_HABITS,
    Habits,
)
from flightsim.mavlink.client.telemetry import Telemetry

__all__ = [
    "ARDUPILOT_HABITS",
    "PX4_HABITS",
    "PX4_HOLD",
    "PX4_LAND",
    "PX4_OFFBOARD",
    "PX4_RETURN",
    "REAL_PX4_HABITS",
    "BytePipe",
    "Command",
    "CommandState",
    "Habits",
    "MavlinkClient",
    "Telemetry",
]
