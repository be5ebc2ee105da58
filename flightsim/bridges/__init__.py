"""Flight stacks that are not ours fly the plant: ArduPilot and PX4, each by its own protocol."""

from flightsim.bridges.physics.bridge import BridgeError
from flightsim.bridges.stack import STACKS, ExternalStack

__all__ = ["STACKS", "BridgeError", "ExternalStack"]
