"""Flight logs as ULog, kept aboard and read over MAVLink."""

from flightsim.mavlink.logs.recorder import FlightRecorder
from flightsim.mavlink.logs.service import LogService

__all__ = ["FlightRecorder", "LogService"]
