"""Memory of vehicles that have ended, and the time to free it.

The parts of a vehicle refer to one another, so only Python's collector frees them. It looks through
its oldest generation only when the new objects there are a quarter of it. Numba's objects alone
make that generation so large that a quarter is dozens of vehicles, and a campaign or a training
would grow by that much. So whoever builds a vehicle calls the collector when a few ended ones may
wait.
"""

from __future__ import annotations

import gc
from weakref import WeakSet

from flightsim.plant import Plant

MOST_WAITING = 4
"""Number of ended vehicles that may wait for the collector, which takes a tenth of a second."""
# Weak references: this set itself must not keep a vehicle alive.
_ended: WeakSet[Plant] = WeakSet()


def note_end(plant: Plant) -> None:
    """Note that a vehicle has ended, so that it can be freed once nobody holds it."""
    _ended.add(plant)


def free_ended() -> None:
    """Free ended vehicles that nobody holds any more, if many may wait for it."""
    if len(_ended) >= MOST_WAITING:
        gc.collect()
        # Those left are held by somebody: to look for them again would be in vain.
        _ended.clear()
