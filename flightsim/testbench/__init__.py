"""A scene with a vehicle, whoever flies it, and MAVLink, in one loop."""

from flightsim.testbench.cfg import MAX_INSTANCES, TestbenchCfg, TestbenchError
from flightsim.testbench.testbench import Testbench

__all__ = ["MAX_INSTANCES", "Testbench", "TestbenchCfg", "TestbenchError"]
