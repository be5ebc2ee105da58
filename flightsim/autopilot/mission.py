"""The uploaded mission and how far it has been flown."""

from __future__ import annotations

from collections.abc import Iterable

from flightsim.autopilot.mission_check import MAX_MISSION_ITEMS, check_mission
from flightsim.autopilot.mission_item import Cmd, MissionError, MissionFault, MissionItem

__all__ = [
    "MAX_MISSION_ITEMS",
    "Cmd",
    "MissionError",
    "MissionFault",
    "MissionItem",
    "MissionStore",
]


class MissionStore:
    """The uploaded mission and where the vehicle is in it."""

    def __init__(self) -> None:
        self.items: tuple[MissionItem, ...] = ()
        self.current_index = 0
        self.last_reached_index: int | None = None
        self.is_finished = False
        self.n_jumps: dict[int, int] = {}
        """How often each jump has been taken."""
        self.revision = 0
        """Grows with every change of the items."""
        self.n_selections = 0
        """Grows with every choice of an item by a client."""

    def __len__(self) -> int:
        return len(self.items)

    def replace(self, items: Iterable[MissionItem]) -> None:
        """Store a new mission.

        Raises:
            MissionError: If an item cannot be flown; the old mission remains.
        """
        candidate = tuple(items)
        check_mission(candidate)
        self.items = candidate
        self.revision += 1
        self.rewind()

    def clear(self) -> None:
        """Forget the mission."""
        self.replace(())

    def rewind(self) -> None:
        """Start over at the first item."""
        self.select(0)
        self.last_reached_index = None

    def select(self, index: int) -> None:
        """Go to an item because somebody wants it; a mission in flight follows."""
        self.current_index = index
        self.is_finished = False
        self.n_jumps.clear()
        self.n_selections += 1
