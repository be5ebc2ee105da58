"""One moving obstacle over time: a Kalman filter of constant velocity, and the size of it."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from jaxtyping import Float

from autonomy.perception.depth_image import DepthImage
from autonomy.perception.sighting import LEAST_HALF_M, Footprint, Sighting

ACCELERATION_PSD = 1.5
"""Of the white acceleration that velocity wanders by, m^2/s^3: people turn within a second."""
_FIRST_SPEED_SIGMA_MPS = 1.5
_SHRINK = 0.1
_HEADING_SPEED_MPS = 0.6
_TURN_RAD = math.radians(20.0)
_LOOKED_AT = np.linspace(-0.5, 0.5, 5)
_SEEN_THROUGH_M = 0.4
_SURE_SHARE = 0.6
_SIGMAS = 4.0


class MoverTrack:
    """State of one obstacle.

    Attributes:
        mean: Position and velocity of its centre, ENU.
        covariance: Of them.
        size: Its half extents, turned along its motion once that is known.
        n_hits: Images that showed it.
        n_misses: Images in a row that showed that it is not where it was predicted.
        last_seen_s: When it was seen last.
    """

    def __init__(self, time_s: float, sighting: Sighting) -> None:
        """Begin where it is seen, at rest for all that is known."""
        forward = sighting.forward
        self.size: Footprint = sighting.footprint(math.atan2(forward[1], forward[0]))
        position, covariance = sighting.centre(self.size)
        self.mean = np.concatenate([position, np.zeros(3)])
        self.covariance = np.zeros((6, 6))
        self.covariance[:3, :3] = covariance
        self.covariance[3:, 3:] = _FIRST_SPEED_SIGMA_MPS**2 * np.eye(3)
        self.n_hits, self.n_misses = 1, 0
        self.last_seen_s = self._time_s = time_s

    def predicted(self, time_s: float) -> tuple[Float[np.ndarray, " 6"], Float[np.ndarray, "6 6"]]:
        """Mean and covariance at a later time."""
        dt = max(time_s - self._time_s, 0.0)
        move = np.eye(6)
        move[:3, 3:] = dt * np.eye(3)
        noise = ACCELERATION_PSD * np.array([[dt**3 / 3, dt**2 / 2], [dt**2 / 2, dt]])
        return move @ self.mean, move @ self.covariance @ move.T + np.kron(noise, np.eye(3))

    def predict(self, time_s: float) -> None:
        """Go on to a later time."""
        self.mean, self.covariance = self.predicted(time_s)
        self._time_s = max(time_s, self._time_s)

    def surprise(self, sighting: Sighting) -> float:
        """Squared Mahalanobis distance of a sighting, 3 degrees of freedom."""
        position, covariance = sighting.centre(self.size)
        off = position - self.mean[:3]
        return float(off @ np.linalg.solve(self.covariance[:3, :3] + covariance, off))

    def see(self, sighting: Sighting) -> None:
        """Take a sighting in.

        A size newly learned puts the centre elsewhere, without anything having moved.
        """
        before, _ = sighting.centre(self.size)
        self._learn_size(sighting)
        position, noise = sighting.centre(self.size)
        self.mean[:3] += position - before
        gain = np.linalg.solve(self.covariance[:3, :3] + noise, self.covariance[:3]).T
        self.mean = self.mean + gain @ (position - self.mean[:3])
        keep = np.eye(6)
        keep[:, :3] -= gain
        self.covariance = keep @ self.covariance @ keep.T + gain @ noise @ gain.T
        self.n_hits += 1
        self.n_misses = 0
        self.last_seen_s = self._time_s

    def _learn_size(self, sighting: Sighting) -> None:
        """Grow at once to what is seen; shrink slowly, and only where no border cuts it."""
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

    def is_seen_through(self, image: DepthImage, inverse_sigma_pm: float) -> bool:
        """Whether an image shows what is behind the place where the obstacle should be."""
        rotation = np.asarray(image.rotation_enu_from_optical, dtype=float)
        sight = (self.mean[:3] - np.array(image.position_enu_m)) @ rotation
        if sight[2] < LEAST_HALF_M:
            return False
        half = min(self.size.along_m, self.size.across_m)
        grid = np.stack(np.meshgrid(2 * half * _LOOKED_AT, 2 * self.size.up_m * _LOOKED_AT), -1)
        grid = 0.5 * grid.reshape(-1, 2)
        column = np.rint(image.cx + image.fx * (sight[0] + grid[:, 0]) / sight[2]).astype(int)
        row = np.rint(image.cy + image.fy * (sight[1] + grid[:, 1]) / sight[2]).astype(int)
        height, width = image.depth_m.shape
        inside = (row >= 0) & (row < height) & (column >= 0) & (column < width)
        depth_m = image.depth_m[row[inside], column[inside]]
        behind_m = sight[2] + half + _SEEN_THROUGH_M + _SIGMAS * inverse_sigma_pm * sight[2] ** 2
        return int(np.count_nonzero(depth_m > behind_m)) > _SURE_SHARE * len(grid)


def _learned(known_m: float, seen_m: float, is_cut: bool) -> float:
    """Half an extent after one more sighting."""
    if seen_m >= known_m or is_cut:
        return max(seen_m, known_m)
    return known_m + _SHRINK * (seen_m - known_m)
