"""Flight stacks that are not ours but fly our plant: ArduPilot and PX4, each by its protocol."""

from flightsim.bridges.physics.bridge import BridgeError
from flightsim.bridges.stack import STACKS, ExternalStack

__all__ = ["STACKS", "BridgeError", "ExternalStack"]
