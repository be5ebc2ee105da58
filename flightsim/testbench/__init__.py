"""A scene with one vehicle or several, whoever flies them, and MAVLink, in one loop."""

from flightsim.testbench.cfg import MAX_INSTANCES, TestbenchCfg, TestbenchError
from flightsim.testbench.shared import SharedTestbench
from flightsim.testbench.testbench import Testbench

__all__ = ["MAX_INSTANCES", "SharedTestbench", "Testbench", "TestbenchCfg", "TestbenchError"]
