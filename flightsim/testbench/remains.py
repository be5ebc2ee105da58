"""Memory of vehicles that have ended.

The parts of a vehicle refer to one another, so that only Python's collector frees them. It looks
at what has lived long once a quarter of that is new, and beside what numba makes such a quarter is
dozens of vehicles.
"""

from __future__ import annotations

import gc
from weakref import WeakSet

from flightsim.plant import Plant

MOST_WAITING = 4
"""Ended vehicles that may wait for the collector; to look for them takes a tenth of a second."""
_ended: WeakSet[Plant] = WeakSet()


def note_end(plant: Plant) -> None:
    """Note that a vehicle has ended."""
    _ended.add(plant)


def free_ended() -> None:
    """Free ended vehicles that nobody holds any more, where many may wait for it."""
    if len(_ended) >= MOST_WAITING:
        gc.collect()
        _ended.clear()  # What is left is held: to look for it again would be in vain.
