"""One moving obstacle over time: whether it stands, goes straight or turns, and its size.

Filters for these modes of motion run side by side (`motion_modes.py`). An obstacle that stops is
soon known to stand, and a fast car's velocity is smoothed less than one mode for everything would
smooth it.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from jaxtyping import Float

from autonomy.jit import kernel
from autonomy.perception.depth_image import DepthImage, Pixels
from autonomy.perception.motion_modes import CHANGES, ahead, begin, fused
from autonomy.perception.sighting import LEAST_HALF_M, Footprint, Sighting

_FIRST_SPEED_SIGMA_MPS = 2.5
_SHRINK = 0.1
_HEADING_SPEED_MPS = 0.6
_TURN_RAD = math.radians(20.0)
_LOOKED_AT = (-0.5, -0.25, 0.0, 0.25, 0.5)
_SEEN_THROUGH_M = 0.4
_SURE_SHARE = 0.6
_SIGMAS = 4.0


class MoverTrack:
    """State of one obstacle.

    Attributes:
        mean: Position and velocity of its centre, ENU, at the time last predicted for.
        covariance: Covariance of the mean.
        size: Half extents of the obstacle, turned along its motion once that is known.
        n_hits: Number of images that showed it.
        n_misses: Number of images in a row that showed that it is not at its predicted place.
        last_seen_s: Time of the last sighting, which is the time of the filter's state.
    """

    def __init__(self, time_s: float, sighting: Sighting) -> None:
        """Start at the first sighting, at rest since nothing else is known."""
        forward = sighting.forward
        self.size: Footprint = sighting.footprint(math.atan2(forward[1], forward[0]))
        position, covariance = sighting.centre(self.size)
        self.mean = np.concatenate([position, np.zeros(3)])
        self.covariance = np.zeros((6, 6))
        self.covariance[:3, :3] = covariance
        self.covariance[3:, 3:] = _FIRST_SPEED_SIGMA_MPS**2 * np.eye(3)
        self._modes = begin(self.mean, self.covariance)
        self._predicted: dict[float, tuple[np.ndarray, np.ndarray]] = {}
        self.n_hits, self.n_misses = 1, 0
        self.last_seen_s = self._time_s = time_s

    def predicted(self, time_s: float) -> tuple[Float[np.ndarray, " 6"], Float[np.ndarray, "6 6"]]:
        """Mean and covariance at a later time, blended from the modes by their probabilities."""
        # Several cameras look at one time, and nothing changes until one of them sees it.
        if time_s not in self._predicted:
            self._predicted[time_s] = ahead(self._modes, max(time_s - self.last_seen_s, 0.0))
        return self._predicted[time_s]

    def predict(self, time_s: float) -> None:
        """Advance the filter to a later time."""
        self.mean, self.covariance = self.predicted(time_s)
        self._time_s = max(time_s, self._time_s)

    def surprise(self, sighting: Sighting) -> float:
        """Squared Mahalanobis distance of a sighting, 3 degrees of freedom."""
        position, covariance = sighting.centre(self.size)
        off = position - self.mean[:3]
        return float(off @ np.linalg.solve(self.covariance[:3, :3] + covariance, off))

    def see(self, sighting: Sighting) -> None:
        """Update the track with a sighting.

        A newly learned size shifts the centre although nothing has moved.
        """
        before, _ = sighting.centre(self.size)
        self._learn_size(sighting)
        position, noise = sighting.centre(self.size)
        dt = self._time_s - self.last_seen_s
        shift = position - before
        self._modes, *state = fused(self._modes, dt, shift, position, noise, CHANGES)
        self.mean, self.covariance = state
        self._predicted.clear()
        self.n_hits += 1
        self.n_misses = 0
        self.last_seen_s = self._time_s

    def _learn_size(self, sighting: Sighting) -> None:
        """Grow at once to the seen size; shrink slowly, and only where no border cuts it off."""
        vx, vy = self.mean[3:5].tolist()
        yaw, size = self.size.yaw_rad, self.size
        if math.hypot(vx, vy) > _HEADING_SPEED_MPS:
            turn = (math.atan2(vy, vx) - yaw + math.pi / 4) % (math.pi / 2) - math.pi / 4
            if abs(turn) > _TURN_RAD:
                size = sighting.footprint(yaw + turn)
            else:
                size = replace(size, yaw_rad=yaw + turn)
        seen = sighting.footprint(size.yaw_rad)
        is_cut_aside, is_cut_up = any(sighting.is_cut[:2]), any(sighting.is_cut[2:])
        self.size = Footprint(
            along_m=_learned(size.along_m, seen.along_m, is_cut_aside),
            across_m=_learned(size.across_m, seen.across_m, is_cut_aside),
            up_m=_learned(size.up_m, seen.up_m, is_cut_up),
            yaw_rad=size.yaw_rad,
        )

    def is_seen_through(self, image: DepthImage) -> bool:
        """Whether an image shows what is behind the place where the obstacle should be."""
        half = (min(self.size.along_m, self.size.across_m), self.size.up_m)
        doubt = _SIGMAS * image.inverse_depth_sigma_pm
        return share_seen_through(image.pixels, self.mean[:3], half, doubt) > _SURE_SHARE


@kernel
def share_seen_through(
    pixels: Pixels, position: Float[np.ndarray, " 3"], half: tuple[float, float], doubt: float
) -> float:
    """Share of the lines of sight to an obstacle that end clearly behind it.

    Args:
        pixels: The image.
        position: Where the obstacle should be, ENU, m.
        half: Half its width and height, m.
        doubt: Error of inverse depth to allow for, 1/m.
    """
    depth, fx, fy, cx, cy, eye, rotation = pixels
    sight = np.zeros(3)
    for axis in range(3):
        for n in range(3):
            sight[axis] += (position[n] - eye[n]) * rotation[n, axis]
    if sight[2] < LEAST_HALF_M:
        return 0.0
    behind = sight[2] + half[0] + _SEEN_THROUGH_M + doubt * sight[2] ** 2
    n_behind = 0
    for up in _LOOKED_AT:
        row = round(cy + fy * (sight[1] + half[1] * up) / sight[2])
        if not 0 <= row < depth.shape[0]:
            continue
        for aside in _LOOKED_AT:
            column = round(cx + fx * (sight[0] + half[0] * aside) / sight[2])
            if 0 <= column < depth.shape[1] and depth[row, column] > behind:
                n_behind += 1
    return n_behind / len(_LOOKED_AT) ** 2


def _learned(known_m: float, seen_m: float, is_cut: bool) -> float:
    """Half extent after one more sighting."""
    if seen_m >= known_m or is_cut:
        return max(seen_m, known_m)
    return known_m + _SHRINK * (seen_m - known_m)
