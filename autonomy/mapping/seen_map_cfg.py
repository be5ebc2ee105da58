"""Settings of a map that grows with depth images."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True, slots=True)
class SeenMapCfg:
    """Settings of a map that grows."""

    resolution_m: float = 0.25
    max_range_m: float = 8.0
    """Depth beyond which a measurement is not believed."""
    cap_m: float = 1.5
    """Cap of the distances to obstacles."""
    nearby_m: float = 10.0
    """Reach of `obstacles` from the last camera position."""
    camera_pitch_down_rad: float = math.radians(15.0)
    """Pitch of the camera that looks ahead, which decides from where it sees a place."""
    camera_vertical_fov_rad: float = math.radians(60.0)
