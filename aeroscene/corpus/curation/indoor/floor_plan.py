"""Floor plans before construction, and buildings after it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TypeVar

from aeroscene.corpus.curation.builder import Placed
from aeroscene.corpus.curation.indoor.zones import Zone
from aeroscene.corpus.curation.room_space import RoomSpace

T = TypeVar("T")


class OverlapError(ValueError):
    """Raised if parts of a floor plan do not fit beside each other."""


@dataclass(frozen=True, kw_only=True)
class FloorPlan:
    """Everything that is decided before the first object is placed; lengths in m."""

    name: str
    """Category of the shell: building or warehouse."""
    size: tuple[float, float]
    """Outer lengths along x and y, multiples of half a metre."""
    height: float
    """Underside of the roof above the ground."""
    zones: tuple[Zone, ...]
    """The first is the hall in which a flight starts."""
    finishes: dict[str, str]
    """Floor finish of each kind of zone."""
    colour: str
    """Colour of the outer walls."""


@dataclass(slots=True)
class Building:
    """A building with a room for each zone of its plan."""

    plan: FloorPlan
    shell: Placed
    spaces: list[RoomSpace] = field(default_factory=list)
    """Rooms, in the order of the plan's zones."""
    sides: list[tuple[str, ...]] = field(default_factory=list)
    """Sides of each room along which walls stand."""


def sure(placed: T | None) -> T:
    """Return an object that a plan needs.

    The builder returns None for objects that do not fit. For furniture that is normal, for a wall
    it is a fault of the plan.

    Raises:
        OverlapError: If the builder has refused the object.
    """
    if placed is None:
        raise OverlapError(
            "a floor plan overlaps itself; valid: zones side by side inside the walls"
        )
    return placed
