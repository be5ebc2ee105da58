"""How far the estimate of a vehicle may be off the map, and how fast that changes."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

_LEAST_SIGMA_M = 0.08
_WALK_OF_SIGMA = 0.05
"""A receiver that claims s wanders by 0.05 s per root second once odometry has smoothed it."""
_LEAST_WALK = 0.02
"""Of odometry at 1 m/s."""


@dataclass(frozen=True, kw_only=True)
class MapAnchorCfg:
    """How far the estimate may be off, and how fast that changes."""

    horizontal_sigma_m: float = 1.8
    """Of the estimate at the start, each axis."""
    vertical_sigma_m: float = 2.2
    """Of the estimate at the start."""
    yaw_sigma_rad: float = math.radians(0.5)
    """Of the estimate at the start."""
    horizontal_walk: float = 0.08
    """How the error of the estimate moves, m/sqrt(s)."""
    vertical_walk: float = 0.15
    """How the error of the estimate moves, m/sqrt(s)."""
    yaw_walk: float = math.radians(0.05)
    """How the error of the estimate moves, rad/sqrt(s)."""
    fix_sigma_m: float = 0.04
    """Of the best fix: map and camera."""
    fix_yaw_sigma_rad: float = math.radians(0.2)
    """Of the best fix."""
    least_inlier_share: float = 0.6
    """Of the points, that the map must explain."""
    doubt_m: float = 0.4
    """What an image that the map does not wholly explain adds to the deviation."""
    slew_s: float = 0.5
    """In which what the offset and yaw in use lack of the fused ones falls to 1/e."""
    slew_mps: float = 0.5
    """How fast the offset in use follows at most."""

    def for_accuracy(self, horizontal_m: float, vertical_m: float) -> MapAnchorCfg:
        """The same for an estimate that claims these standard deviations.

        Args:
            horizontal_m: Each horizontal axis; NaN or infinite counts as a bare receiver's.
            vertical_m: Of the height, likewise.
        """
        bare = MapAnchorCfg()
        h = horizontal_m if math.isfinite(horizontal_m) else bare.horizontal_sigma_m
        v = vertical_m if math.isfinite(vertical_m) else bare.vertical_sigma_m
        return replace(
            self,
            horizontal_sigma_m=max(h, _LEAST_SIGMA_M),
            vertical_sigma_m=max(v, _LEAST_SIGMA_M),
            horizontal_walk=max(_WALK_OF_SIGMA * h, _LEAST_WALK),
            vertical_walk=max(_WALK_OF_SIGMA * v, _LEAST_WALK),
        )
