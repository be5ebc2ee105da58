"""Navigation satellites in the sky, of constellations on circular orbits.

A Walker constellation T/P/F has T satellites in P planes of equal inclination, their nodes evenly
spread, and a satellite of the next plane ahead by 360 F / T degrees. Satellites stand still during
a flight: they move by half a degree a minute.

Sources: the operators' service performance standards: GPS has 24 slots in 6 planes of 55 degrees at
26,560 km (here evenly spread), Galileo 24/3/1 of 56 degrees at 29,600 km, BeiDou's medium orbits
24/3/1 of 55 degrees at 27,906 km.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

_EARTH_RADIUS_M = 6.371e6
_EARTH_GRAVITY_M3PS2 = 3.986e14
_EARTH_RATE_RADPS = 7.2921e-5
_DAY_S = 86_400.0
LEAST_SATELLITES = 4
"""Least number of satellites for a position: three axes and the receiver's clock."""
MASK_RAD = math.radians(10.0)
"""Elevation below which a receiver uses no satellite, as usual."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Constellation:
    """A Walker constellation T/P/F: satellites, planes, and the phasing between planes."""

    n_satellites: int
    n_planes: int
    phasing: int
    inclination_deg: float
    radius_m: float


GPS = Constellation(n_satellites=24, n_planes=6, phasing=1, inclination_deg=55.0, radius_m=2.656e7)
GALILEO = Constellation(
    n_satellites=24, n_planes=3, phasing=1, inclination_deg=56.0, radius_m=2.96e7
)
BEIDOU = Constellation(
    n_satellites=24, n_planes=3, phasing=1, inclination_deg=55.0, radius_m=2.7906e7
)


def satellite_directions_enu(
    constellations: tuple[Constellation, ...], latitude_deg: float, time_s: float
) -> Float[np.ndarray, "n 3"]:
    """Return unit vectors to all satellites above the mask.

    Args:
        constellations: Constellations that the receiver hears.
        latitude_deg: Latitude of the receiver. Its longitude is zero, which the time makes up for.
        time_s: Time of the day.

    Returns:
        East, north, up; a row for each satellite.
    """
    latitude = math.radians(latitude_deg)
    up = np.array([math.cos(latitude), 0.0, math.sin(latitude)])
    north = np.array([-math.sin(latitude), 0.0, math.cos(latitude)])
    # Rows: east, north and up at longitude zero, in axes fixed to the Earth.
    axes = np.array([[0.0, 1.0, 0.0], north, up])
    positions_m = np.concatenate([_positions_m(c, time_s) for c in constellations])
    seen = positions_m - _EARTH_RADIUS_M * up
    directions = seen / np.linalg.norm(seen, axis=1, keepdims=True) @ axes.T
    return directions[directions[:, 2] > math.sin(MASK_RAD)]


def _positions_m(c: Constellation, time_s: float) -> np.ndarray:
    """Positions of a constellation (n, 3), fixed to the turning Earth, m."""
    plane, slot = np.divmod(np.arange(c.n_satellites), c.n_satellites // c.n_planes)
    # Kepler's third law.
    rate = math.sqrt(_EARTH_GRAVITY_M3PS2 / c.radius_m**3)
    along = 2.0 * math.pi * (slot * c.n_planes + plane * c.phasing) / c.n_satellites
    u = along + rate * time_s
    # The node drifts westwards as the Earth turns below the orbit.
    node = 2.0 * math.pi * plane / c.n_planes - _EARTH_RATE_RADPS * time_s
    tilt = math.radians(c.inclination_deg)
    x, y = np.cos(u), np.sin(u) * math.cos(tilt)
    return c.radius_m * np.stack(
        [
            x * np.cos(node) - y * np.sin(node),
            x * np.sin(node) + y * np.cos(node),
            np.sin(u) * math.sin(tilt),
        ],
        axis=1,
    )


def time_of_day_s(rng: np.random.Generator) -> float:
    """Return a random time of the day, s: each flight has another sky."""
    return float(rng.uniform(0.0, _DAY_S))
