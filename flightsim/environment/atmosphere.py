"""International Standard Atmosphere in the troposphere.

Source: ISO 2533:1975; constants as PX4's gazebo-classic barometer uses them.
"""

from __future__ import annotations

from autonomy.jit import kernel

SEA_LEVEL_TEMPERATURE_K = 288.15
SEA_LEVEL_PRESSURE_PA = 101325.0
LAPSE_RATE_KPM = 0.0065
AIR_DENSITY_KGPM3 = 1.225
"""Density at sea level and 15 degrees Celsius."""

# g M / (R L)
_EXPONENT = 5.25588


@kernel
def temperature_k(altitude_m: float) -> float:
    """Return the air temperature at an altitude above mean sea level (m), K."""
    return SEA_LEVEL_TEMPERATURE_K - LAPSE_RATE_KPM * altitude_m


@kernel
def pressure_pa(altitude_m: float) -> float:
    """Return the static pressure at an altitude above mean sea level (m), Pa."""
    return (
        SEA_LEVEL_PRESSURE_PA * (temperature_k(altitude_m) / SEA_LEVEL_TEMPERATURE_K) ** _EXPONENT
    )


@kernel
def pressure_altitude_m(pressure: float) -> float:
    """Return the altitude above mean sea level (m) at which the air has this pressure (Pa)."""
    ratio = (pressure / SEA_LEVEL_PRESSURE_PA) ** (1.0 / _EXPONENT)
    return SEA_LEVEL_TEMPERATURE_K * (1.0 - ratio) / LAPSE_RATE_KPM
