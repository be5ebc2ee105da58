"""The mode that is reported to clients, and the choice of another one."""

from __future__ import annotations

from math import radians

from flightsim.autopilot.autopilot import Autopilot
from flightsim.autopilot.modes import Mode
from flightsim.autopilot.results import ACCEPTED, Reply
from flightsim.mavlink.personalities import ModeEntry, Personality

_CIRCLE_RATE_RADPS = radians(20.0)
"""Default of ArduCopter's CIRCLE_RATE: a positive rate circles clockwise."""


class ModeReport:
    """Mode of the vehicle in its personality's terms.

    If several modes of a flight stack are one of ours, the one that was chosen is reported.
    """

    def __init__(self, personality: Personality, autopilot: Autopilot) -> None:
        self._personality = personality
        self._autopilot = autopilot
        self._chosen: ModeEntry | None = None

    @property
    def entry(self) -> ModeEntry:
        """Entry of the present mode."""
        mode = self._autopilot.mode
        if self._chosen is not None and self._chosen.reports(mode):
            return self._chosen
        return self._personality.entry(mode)

    def choose(self, entry: ModeEntry) -> Reply:
        """Change the mode at a client's request.

        Args:
            entry: The mode in the personality's terms.
        """
        if entry.also and entry is self.entry:
            return ACCEPTED  # the flight within this mode goes on
        if entry.mode is Mode.ORBIT:
            reply = self._autopilot.circle_ahead(_CIRCLE_RATE_RADPS)
        else:
            reply = self._autopilot.set_mode(entry.mode)
        # Kept only if the change succeeds: the report must not name a mode that was refused.
        if reply.is_accepted:
            self._chosen = entry
        return reply
