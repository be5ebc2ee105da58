"""Settings of the map anchor: the error of a vehicle's estimate, and how fast it changes.

The anchor needs to know how wrong the estimate may be and how fast that changes. A receiver's class
is not known to a companion, but the deviation that the autopilot claims is, so `for_accuracy`
derives the settings from the claim.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

_LEAST_SIGMA_M = 0.08  # no claim is believed to be better than this


@dataclass(frozen=True, kw_only=True)
class MapAnchorCfg:
    """Error of the estimate, and how fast it changes.

    The defaults are those of a bare receiver of metre grade.
    """

    horizontal_sigma_m: float = 1.8
    """Standard deviation of the estimate at the start, each axis."""
    vertical_sigma_m: float = 2.2
    """Standard deviation of the estimate's height at the start."""
    yaw_sigma_rad: float = math.radians(0.5)
    """Standard deviation of the estimate's yaw at the start."""
    horizontal_walk: float = 0.08
    """Random walk of the estimate's error, m/sqrt(s), each axis."""
    vertical_walk: float = 0.15
    """Random walk of the estimate's height error, m/sqrt(s)."""
    walk_of_sigma: float = 0.05
    """Random walk per claimed deviation, 1/sqrt(s): how far a receiver wanders once odometry has
    smoothed it; 0 if only the velocity is followed."""
    least_walk: float = 0.02
    """Random walk of the best estimate, m/sqrt(s): odometry at 1 m/s."""
    yaw_walk: float = math.radians(0.05)
    """Random walk of the estimate's yaw error, rad/sqrt(s)."""
    fix_sigma_m: float = 0.04
    """Standard deviation of the best fix, by the errors of map and camera."""
    fix_yaw_sigma_rad: float = math.radians(0.2)
    """Standard deviation of the best fix's yaw."""
    least_inlier_share: float = 0.6
    """Least share of the points that the map must explain."""
    doubt_m: float = 0.4
    """Greatest deviation added by an image that the map does not wholly explain."""
    alike_s: float = 10.0
    """Time for which the error of the estimate's position stays nearly the same."""
    slew_s: float = 0.5
    """Time constant with which offset and yaw in use approach the fused ones."""
    slew_mps: float = 0.5
    """Greatest speed of the offset in use."""

    @property
    def share_beyond(self) -> float:
        """Share of a position's departure from the velocity that is the position's error, 0 to 1.

        The rest is the velocity's: departures are shared in the ratio of the variances of the two
        walks.
        """
        position = 2.0 * self.horizontal_sigma_m**2 / self.alike_s
        return position / (position + self.least_walk**2)

    def for_accuracy(self, horizontal_m: float, vertical_m: float) -> MapAnchorCfg:
        """Settings for an estimate that claims these standard deviations.

        Args:
            horizontal_m: Deviation of each horizontal axis; NaN or infinity counts as a bare
                receiver's.
            vertical_m: Deviation of the height, likewise.
        """
        bare = MapAnchorCfg()
        h = horizontal_m if math.isfinite(horizontal_m) else bare.horizontal_sigma_m
        v = vertical_m if math.isfinite(vertical_m) else bare.vertical_sigma_m
        return replace(
            self,
            horizontal_sigma_m=max(h, _LEAST_SIGMA_M),
            vertical_sigma_m=max(v, _LEAST_SIGMA_M),
            horizontal_walk=max(self.walk_of_sigma * h, self.least_walk),
            vertical_walk=max(self.walk_of_sigma * v, self.least_walk),
        )


SEEN_SO_FAR = MapAnchorCfg(
    yaw_sigma_rad=math.radians(0.1),
    fix_sigma_m=0.015,
    walk_of_sigma=0.0,
    least_walk=0.05,
    doubt_m=0.0,
)
"""Settings for a map that the same camera makes, with the velocity followed. Such a map errs as the
images do, and a lag of the fixes would be learned into it. Images are therefore believed more than
the velocity, and an image that does not fit is no reason to doubt the offset."""
