"""Growth of a scene: composers lay places out, places fill themselves step by step.

A place is a small grammar. Each of its two generators yields after a step that leaves the scene
whole. The first steps place what characterises the place, later ones enrich it, and the least
characteristic come last. The curator takes steps from all places in turn and stops when the scene
has as many objects as it should. Every scene therefore keeps its budget whatever stands in it, and
no place is left half finished.
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
        """Grow coarse objects: ground, buildings, rooms, fences.

        Each step leaves the place whole; the first one makes it recognisable.
        """
        ...

    def details(self) -> Iterator[None]:
        """Grow fine objects: furniture, plants, vehicles.

        They are asked for after the structures of all places, and after the home pad.
        """
        ...


@dataclass(frozen=True, kw_only=True)
class Composition:
    """Result of a composer: the places of a scene and its bounds."""

    theme: str
    """Name of the kind of scene."""
    places: list[Place]
    extent_min_enu_m: Vector3
    """Lower corner of the flight volume."""
    extent_max_enu_m: Vector3
    """Upper corner of the flight volume; the curator raises it over higher objects."""
    fulness: float = 1.0
    """Number of fine objects, relative to the average scene."""
    place_start: Callable[[], Placed]
    """Function that puts the home pad down, after the structures and before the details."""


def fill(growths: Iterable[Iterator[None]], is_full: Callable[[], bool]) -> None:
    """Take steps in turn until the scene is full or nothing grows.

    Args:
        growths: Generators of steps. Each takes at least one step, even in a full scene, because
            the first step makes a place recognisable.
        is_full: Asked before each further step.
    """
    growing = [growth for growth in growths if _step(growth)]
    while growing and not is_full():
        # A copy, because places that have ended leave the list.
        for growth in tuple(growing):
            if is_full():
                return
            if not _step(growth):
                growing.remove(growth)


def _step(growth: Iterator[None]) -> bool:
    """Take one more step, and return true if the growth goes on."""
    return next(growth, _DONE) is not _DONE


_DONE = object()
