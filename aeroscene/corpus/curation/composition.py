"""How a scene grows: composers lay places out, places fill themselves step by step.

A place is a small grammar. Each of its two generators yields after a step that leaves the scene
whole: first what makes the place what it is, then what enriches it, the least telling last. The
curator takes steps from all places in turn and stops when the scene has as many objects as it
should, so that every scene keeps its budget whatever stands in it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Protocol

from aeroscene.corpus.curation.builder import Placed
from aeroscene.scene import Vector3


class Place(Protocol):
    """One place of a scene: a parcel, a street, a floor of rooms."""

    def structures(self) -> Iterator[None]:
        """Place what is coarse: ground, buildings, rooms, fences."""
        ...

    def details(self) -> Iterator[None]:
        """Place what is fine: furniture, plants, vehicles."""
        ...


@dataclass(frozen=True, kw_only=True)
class Composition:
    """What a composer has laid out."""

    theme: str
    """Name of what the scene is."""
    places: list[Place]
    extent_min_enu_m: Vector3
    """Lower corner of the flight volume."""
    extent_max_enu_m: Vector3
    """Upper corner of the flight volume; its height is raised over what stands higher."""
    fulness: float = 1.0
    """How many fine objects it should have, relative to the average scene."""
    place_start: Callable[[], Placed]
    """Puts the home pad down, once the structures stand and before the details."""


def fill(growths: Iterable[Iterator[None]], is_full: Callable[[], bool]) -> None:
    """Take steps in turn, at least one of each, until the scene is full or nothing grows."""
    growing = [growth for growth in growths if _step(growth)]
    while growing and not is_full():
        for growth in tuple(growing):
            if is_full():
                return
            if not _step(growth):
                growing.remove(growth)


def _step(growth: Iterator[None]) -> bool:
    """Whether the growth goes on after one more step."""
    return next(growth, _DONE) is not _DONE


_DONE = object()
