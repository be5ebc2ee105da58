"""Our own pilot: flies a mission over MAVLink, chooses the touchdown point from depth and lands.

`Pilot` is the state machine; the other modules are its phases, its senses and its limits. See
docs/pilot.md.
"""

from scenarios.pilot.phases import Phase, PilotVerdict, Replan, Transition
from scenarios.pilot.pilot import Pilot, PilotCfg

__all__ = ["Phase", "Pilot", "PilotCfg", "PilotVerdict", "Replan", "Transition"]
