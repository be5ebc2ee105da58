"""Needs of a vehicle for a place to stand on."""

from __future__ import annotations

import math
from dataclasses import dataclass

MAX_ROUGHNESS_M = 0.04
MAX_RISE_M = 0.06


@dataclass(frozen=True, kw_only=True, slots=True)
class LandingNeeds:
    """Needs of a vehicle to stand safely.

    Raises `ValueError` if radii or slope are out of range.
    """

    footprint_radius_m: float
    """Radius of its feet, plus the scatter of a touchdown."""
    body_radius_m: float
    """Radius of all of it, plus the scatter of a touchdown."""
    max_slope_rad: float = math.radians(10.0)
    max_roughness_m: float = MAX_ROUGHNESS_M
    """Largest height range about the plane under the feet. With one foot so much higher a stance of
    0.28 m tilts by 8 deg; 0.06 let it stand on kerbs of 0.05 m."""
    max_rise_m: float = MAX_RISE_M
    """Greatest rise of anything within the body's radius above the plane: below the rotors."""
    min_frames: int = 3
    """Least number of frames that show all of the ground under the feet."""
    max_sigma_m: float = 0.02
    """Greatest deviation of the heights of the cells under the feet, root mean square."""
    enough_clearance_m: float = 0.8
    """Room beyond this makes a place no better."""

    def __post_init__(self) -> None:
        """Refuse values that fit no vehicle."""
        if not 0.0 < self.footprint_radius_m <= self.body_radius_m:
            raise ValueError(
                f"footprint_radius_m {self.footprint_radius_m} is not valid; valid: above 0, at "
                f"most body_radius_m {self.body_radius_m}"
            )
        if not 0.0 < self.max_slope_rad < math.pi / 2:
            raise ValueError(
                f"max_slope_rad {self.max_slope_rad} is not valid; valid: above 0, below pi/2"
            )
