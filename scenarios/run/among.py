"""What a run is told of the world that its vehicle shares with others."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from flightsim.plant import Plant
from flightsim.testbench import Testbench

if TYPE_CHECKING:
    from scenarios.mission.mission import Mission


@dataclass(frozen=True, kw_only=True, eq=False)
class Among:
    """A vehicle of several in one world."""

    bench: Testbench
    mission: Mission | None
    """What our own pilot flies, in a demo."""
    mates: tuple[Plant, ...]
    """The other vehicles."""
