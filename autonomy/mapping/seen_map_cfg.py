"""Settings of a map that grows with depth images."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True, slots=True)
class SeenMapCfg:
    """Settings of a `SeenMap`."""

    resolution_m: float = 0.25
    """Edge of a cell, m."""
    max_range_m: float = 8.0
    """Greatest distance of a measurement that counts, m; free space is seen no farther either."""
    cap_m: float = 1.5
    """Cap of the distances to obstacles, m: paths gain nothing from more room than this."""
    nearby_m: float = 10.0
    """Reach of `SeenMap.obstacles` from the last camera position, m."""
    most_whole_cells: int = 40_000_000
    """Number of cells above which the map is wide: a search then takes a block about the vehicle
    instead of all cells. Scenes of 80 by 75 m have 8 million, districts more than 100 million."""
    search_m: float = 40.0
    """Reach of that block to each side, m."""
    camera_pitch_down_rad: float = math.radians(15.0)
    """Pitch of the camera that looks ahead; it decides from where that camera sees a place."""
    camera_vertical_fov_rad: float = math.radians(60.0)
    """Vertical field of view of that camera."""
