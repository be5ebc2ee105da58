"""Directions in which a lidar fires, one after another.

    symbol   name                                          unit
    t        time since the lidar was switched on          s
    n_j      rotation rate of prism j                      1/s
    d_j      angle by which prism j turns the beam away    rad

A beam behind two turning prisms is deflected by d_1 e(2 pi n_1 t) + d_2 e(2 pi n_2 t), with e(a) =
(cos a, sin a), to first order in the angles. Rates without a common period draw a rosette that
fills its cone the more densely the longer the lidar looks.

Source: Brazeal, Wilkinson and Hochmair 2021, A rigorous observation model for the Risley
prism-based Livox Mid-40 lidar sensor, doi.org/10.3390/s21144722.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from jaxtyping import Float, Int


class Pattern(Protocol):
    """Directions of a lidar's shots, by their numbers."""

    @property
    def shots_per_scan(self) -> int:
        """Number of shots in a scan."""
        ...

    def directions_flu(self, shots: Int[np.ndarray, " n"]) -> Float[np.ndarray, "n 3"]:
        """Return the unit directions of shots in the lidar's frame.

        Args:
            shots: Numbers of the shots since the lidar was switched on.
        """
        ...


@dataclass(frozen=True, kw_only=True, eq=False)
class ListedPattern:
    """Pattern with the same directions in each scan."""

    listed_flu: Float[np.ndarray, "k 3"]
    """Unit directions in the order in which they are fired."""

    @property
    def shots_per_scan(self) -> int:
        """Number of shots in a scan."""
        return len(self.listed_flu)

    def directions_flu(self, shots: Int[np.ndarray, " n"]) -> Float[np.ndarray, "n 3"]:
        """Return the unit directions of shots, which repeat with each scan."""
        return self.listed_flu[shots % len(self.listed_flu)]


@dataclass(frozen=True, kw_only=True)
class RosettePattern:
    """Pattern of a beam that passes forwards through two turning prisms.

    A scan is a part of an endless rosette here, so no two scans are alike.
    """

    rates_hz: tuple[float, float]
    """Turns of each prism per second, counter-clockwise as seen from behind the lidar."""
    deflections_rad: tuple[float, float]
    shots_per_scan: int
    shots_hz: float
    """Shots per second."""

    def directions_flu(self, shots: Int[np.ndarray, " n"]) -> Float[np.ndarray, "n 3"]:
        """Return the unit directions of shots, by the time at which each is fired."""
        time_s = shots / self.shots_hz
        left_rad, up_rad = np.zeros(len(shots)), np.zeros(len(shots))
        for rate_hz, deflection_rad in zip(self.rates_hz, self.deflections_rad, strict=True):
            # Whole turns are taken off, which keeps the angle small.
            turned_rad = 2.0 * np.pi * np.mod(rate_hz * time_s, 1.0)
            left_rad += deflection_rad * np.cos(turned_rad)
            up_rad += deflection_rad * np.sin(turned_rad)
        # To first order the deflections to the left and upwards are azimuth and elevation.
        return directions_flu(left_rad, up_rad)


def directions_flu(
    azimuth_rad: Float[np.ndarray, " n"], elevation_rad: Float[np.ndarray, " n"]
) -> Float[np.ndarray, "n 3"]:
    """Return unit directions by their azimuth and elevation.

    Args:
        azimuth_rad: Angles counter-clockwise from forwards.
        elevation_rad: Angles up from level.
    """
    level = np.cos(elevation_rad)
    return np.stack(
        [level * np.cos(azimuth_rad), level * np.sin(azimuth_rad), np.sin(elevation_rad)], axis=1
    )


def spinning_pattern(
    elevations_rad: Float[np.ndarray, " k"], step_rad: float, spread_rad: float
) -> ListedPattern:
    """Return the pattern of a column of beams that turns clockwise, from the nose on.

    Args:
        elevations_rad: Elevations of the beams in the order in which they fire.
        step_rad: Turn from one firing of all beams to the next; it divides a full turn.
        spread_rad: Turn while the beams of one column fire, which are evenly spread over it.
    """
    columns = step_rad * np.arange(round(2.0 * np.pi / step_rad))
    k = len(elevations_rad)
    azimuth_rad = columns[:, None] + spread_rad * np.arange(k) / k
    elevation_rad = np.broadcast_to(elevations_rad, azimuth_rad.shape)
    listed = directions_flu(-azimuth_rad.ravel(), elevation_rad.ravel())  # clockwise is negative
    return ListedPattern(listed_flu=listed)
