"""The plant: everything that runs faster than 50 Hz, compiled, behind a call every 20 ms.

Python is too slow for 500 physics steps a second with sensors and a filter. The plant therefore
keeps all of its state in one record (`PLANT_DTYPE`), and one compiled kernel advances it. The
autopilot and MAVLink, at 50 Hz, stay ordinary Python.
"""

from flightsim.plant.cfg import NotAlignedError, PhysicsDivergedError, PlantCfg, PlantError
from flightsim.plant.compilation import compile_kernels
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
