"""Compilation of the flight kernels ahead of the first flight.

Numba compiles a function at its first call, which would stop a running simulation for seconds.
Compiling ahead moves that into the start, where a message can explain the wait.
"""

from __future__ import annotations

import functools

import numpy as np

from autonomy.estimation.error_state import FILTER_DTYPE
from autonomy.estimation.motion_capture import fuse_pose, fuse_velocity, restart_position
from autonomy.jit import compile_ahead
from flightsim.plant.kernel import advance
from flightsim.plant.record import PLANT_DTYPE

_COMPILE_SECONDS = 12.0
"""Rough times that the message to the user names."""
_OUTSIDE_SECONDS = 3.0


@functools.cache
def compile_kernels() -> None:
    """Compile the flight kernels now or load them from the cache, with a message if it takes long.

    Only the first call does anything, because finding the types of the arguments takes as long as
    building a small world.
    """
    compile_ahead(advance, example_arguments(), "flight kernels", _COMPILE_SECONDS)
    # Positions from outside come between the steps, straight to the filter.
    kept, vector = np.zeros(1, FILTER_DTYPE)[0], np.zeros(3)
    for fuse, arguments in (
        (fuse_pose, (kept, vector, 0.0, 0, 1.0, 1.0, 1.0)),
        (fuse_velocity, (kept, vector, 0, 1.0)),
        (restart_position, (kept, vector, 0, 1.0, 1.0)),
    ):
        compile_ahead(fuse, arguments, "kernels for positions from outside", _OUTSIDE_SECONDS)


def example_arguments() -> tuple[np.ndarray, ...]:
    """Return arrays of the types that the kernel takes, to compile it without a world."""
    return np.zeros((1, 1), PLANT_DTYPE), np.zeros(1, np.int64)
