"""The flight kernels, compiled ahead of the first flight."""

from __future__ import annotations

import numpy as np

from autonomy.jit import compile_ahead
from flightsim.plant.kernel import advance
from flightsim.plant.record import PLANT_DTYPE

_COMPILE_SECONDS = 12.0


def compile_kernels() -> None:
    """Compile the flight kernels now, or load them from the cache; says so if it takes long."""
    compile_ahead(advance, example_arguments(), "flight kernels", _COMPILE_SECONDS)


def example_arguments() -> tuple[np.ndarray, ...]:
    """Arrays of the types that the kernel takes, for compiling it without a world."""
    return np.zeros((1, 1), PLANT_DTYPE), np.zeros(1, np.int64)
