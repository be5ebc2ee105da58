"""Uploaded mission and its progress."""

from __future__ import annotations

from collections.abc import Iterable

from flightsim.autopilot.mission_check import check_mission, unsupported_command
from flightsim.autopilot.mission_item import MissionItem


class MissionStore:
    """The uploaded mission and the vehicle's progress in it."""

    def __init__(self) -> None:
        self.items: tuple[MissionItem, ...] = ()
        self.unknown_commands: frozenset[int] = frozenset()
        """Commands of ours that the imitated flight stack does not know."""
        self.current_index = 0
        self.last_reached_index: int | None = None
        self.is_finished = False
        self.n_jumps: dict[int, int] = {}
        """Number of times that each jump was taken, by index."""
        self.revision = 0
        """Counter of changes to the items."""
        self.n_selections = 0
        """Counter of items selected by clients."""

    def __len__(self) -> int:
        return len(self.items)

    def replace(self, items: Iterable[MissionItem]) -> None:
        """Replace the mission.

        Raises:
            MissionError: If an item cannot be flown; the old mission remains.
        """
        candidate = tuple(items)
        check_mission(candidate)
        for index, item in enumerate(candidate):
            if item.command in self.unknown_commands:
                raise unsupported_command(index, item)
        self.items = candidate
        self.revision += 1
        self.rewind()

    def rewind(self) -> None:
        """Restart at the first item."""
        self.select(0)
        self.last_reached_index = None

    def select(self, index: int) -> None:
        """Go to an item at a client's request; a mission in flight follows."""
        self.current_index = index
        self.is_finished = False
        self.n_jumps.clear()
        self.n_selections += 1
