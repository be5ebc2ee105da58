"""The plant: everything that runs faster than 50 Hz, compiled, behind a call every 20 ms."""

from flightsim.plant.cfg import NotAlignedError, PhysicsDivergedError, PlantCfg, PlantError
from flightsim.plant.compiling import compile_kernels
from flightsim.plant.fleet import Fleet
from flightsim.plant.plant import Plant

__all__ = [
    "Fleet",
    "NotAlignedError",
    "PhysicsDivergedError",
    "Plant",
    "PlantCfg",
    "PlantError",
    "compile_kernels",
]
