"""Rooms as the space that furniture may fill."""

from __future__ import annotations

from dataclasses import dataclass

from aeroscene.corpus.curation.builder import Placed
from aeroscene.solids.shapes.shell import FINISH_M


@dataclass(frozen=True, slots=True)
class RoomSpace:
    """A room to furnish: x towards the building's front, y to its left."""

    placed: Placed
    kind: str = ""
    """Use of the room if it is decided already; empty otherwise."""

    @property
    def floor(self) -> float:
        """Height of the floor's finish, on which furniture stands, m."""
        return self.placed.base + FINISH_M
