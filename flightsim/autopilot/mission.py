"""Uploaded mission and its progress."""

from __future__ import annotations

from collections.abc import Iterable

from flightsim.autopilot.mission_check import check_mission, unsupported_command
from flightsim.autopilot.mission_item import MissionItem


class MissionStore:
    """The uploaded mission and the vehicle's progress in it.

    `revision` and `n_selections` only count up. The behaviour that flies the mission compares them
    with the last values it saw, and so notices what clients changed between two ticks.
    """

    def __init__(self) -> None:
        self.items: tuple[MissionItem, ...] = ()
        self.unknown_commands: frozenset[int] = frozenset()
        """Commands that we can execute but the imitated flight stack does not know; they are
        refused."""
        self.current_index = 0
        self.last_reached_index: int | None = None
        self.is_finished = False
        self.n_jumps: dict[int, int] = {}
        """Number of times that each jump was taken, by the jump's index."""
        self.revision = 0
        """Counter of changes to the items."""
        self.n_selections = 0
        """Counter of items selected by clients."""

    def __len__(self) -> int:
        return len(self.items)

    def replace(self, items: Iterable[MissionItem]) -> None:
        """Replace the mission, and restart it at the first item.

        Args:
            items: The new items; none deletes the mission.

        Raises:
            MissionError: If an item cannot be flown; the old mission remains.
        """
        # Checked as a whole before anything is stored, so that a bad upload changes nothing.
        candidate = tuple(items)
        check_mission(candidate)
        for index, item in enumerate(candidate):
            if item.command in self.unknown_commands:
                raise unsupported_command(index, item)
        self.items = candidate
        self.revision += 1
        self.rewind()

    def rewind(self) -> None:
        """Restart at the first item, as if none had been reached."""
        self.select(0)
        self.last_reached_index = None

    def select(self, index: int) -> None:
        """Go to an item at a client's request; a mission in flight follows.

        Args:
            index: Index of the item, which must exist.
        """
        self.current_index = index
        self.is_finished = False
        self.n_jumps.clear()
        self.n_selections += 1
