"""A mission as ArduPilot's clients read and write it: item 0 is home, and every item continues.

As in ArduCopter, headings of places are not kept: the vehicle turns to where it flies.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from math import nan

from flightsim.autopilot.autopilot import Autopilot
from flightsim.autopilot.mission_item import PLACE_COMMANDS, Cmd, MissionError, MissionItem

_GLOBAL = 0


class MissionWithHome:
    """The autopilot's mission with home before it, as ArduPilot's clients expect it.

    An uploaded home is not kept; it is always the vehicle's own.
    """

    def __init__(self, autopilot: Autopilot) -> None:
        self._autopilot = autopilot

    @property
    def items(self) -> tuple[MissionItem, ...]:
        """Home and the mission, whose jumps count home."""
        stored = self._autopilot.mission.items
        told = (_with_heading(item, 0.0) for item in stored)
        return (self._home(), *(_with_jump_moved(item, by=1) for item in told))

    @property
    def current_index(self) -> int:
        """Index of the current item, with home counted."""
        return self._autopilot.mission.current_index + 1

    def replace(self, items: Iterable[MissionItem]) -> None:
        """Replace the mission by all items but the first.

        Clients leave "autocontinue" at 0, because ArduPilot has never looked at it.

        Args:
            items: Home and the mission.

        Raises:
            MissionError: If an item cannot be flown; the old mission remains.
        """
        # An empty upload has no home either; the placeholder stands for it.
        _, *rest = (*items,) or (None,)
        try:
            self._autopilot.mission.replace(
                replace(_with_jump_moved(_with_heading(item, nan), by=-1), is_autocontinue=True)
                for item in rest
            )
        except MissionError as error:
            text = f"{error} (home not counted)"
            raise MissionError(error.fault, text, index=error.index, param=error.param) from error

    def _home(self) -> MissionItem:
        home = self._autopilot.home
        if home is None:
            # Before the first position clients still expect an item 0.
            return MissionItem(frame=_GLOBAL, command=Cmd.WAYPOINT, param1=0.0, param2=0.0)
        place = home.geodetic
        return MissionItem(
            frame=_GLOBAL,
            command=Cmd.WAYPOINT,
            param1=0.0,
            param2=0.0,
            param3=0.0,
            param4=0.0,
            x=place.latitude_deg,
            y=place.longitude_deg,
            z=place.altitude_m,
        )


def _with_heading(item: MissionItem, heading_deg: float) -> MissionItem:
    return replace(item, param4=heading_deg) if item.command in PLACE_COMMANDS else item


def _with_jump_moved(item: MissionItem, *, by: int) -> MissionItem:
    return replace(item, param1=item.param1 + by) if item.command == Cmd.JUMP else item
