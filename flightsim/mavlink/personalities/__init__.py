"""Flight stacks to imitate: each is a file, and differs from the others in its data alone.

A new difference between stacks becomes a field of `Personality`, so that services never ask for a
name.
"""

from __future__ import annotations

from collections.abc import Mapping

from flightsim.mavlink.personalities.ardupilot import ARDUPILOT
from flightsim.mavlink.personalities.personality import Alias, ModeEntry, Personality, Setting
from flightsim.mavlink.personalities.px4 import PX4

PERSONALITIES: Mapping[str, Personality] = {stack.name: stack for stack in (PX4, ARDUPILOT)}
"""Every personality by its name."""

__all__ = ["ARDUPILOT", "PERSONALITIES", "PX4", "Alias", "ModeEntry", "Personality", "Setting"]
