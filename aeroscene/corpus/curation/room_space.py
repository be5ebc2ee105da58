"""A room to furnish."""

from __future__ import annotations

from dataclasses import dataclass

from aeroscene.corpus.curation.builder import Placed
from aeroscene.solids.shapes.shell import FINISH_M


@dataclass(frozen=True, slots=True)
class RoomSpace:
    """A room to furnish: x towards the building's front, y to its left."""

    placed: Placed
    kind: str = ""
    """Its use, where that is decided already."""

    @property
    def floor(self) -> float:
        """Height on which furniture stands."""
        return self.placed.base + FINISH_M
