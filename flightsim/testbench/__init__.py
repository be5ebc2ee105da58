"""A scene with its vehicles, their flight stacks, and MAVLink, in one loop."""

from flightsim.testbench.cfg import MAX_INSTANCES, TestbenchCfg, TestbenchError
from flightsim.testbench.testbench import Testbench
from flightsim.testbench.vehicle import Vehicle

__all__ = ["MAX_INSTANCES", "Testbench", "TestbenchCfg", "TestbenchError", "Vehicle"]
