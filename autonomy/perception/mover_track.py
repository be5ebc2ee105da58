"""One moving obstacle over time: whether it stands, goes straight or turns, and its size.

A single filter of constant velocity is either slow to notice a stop or noisy on a straight line. An
interacting multiple-model filter weighs four linear Kalman filters of position and velocity by how
well each predicts the sightings: one that stands, one of constant velocity and two that turn, left
and right. An obstacle that stops is soon known to stand, and a fast car's velocity is smoothed less
than one mode for everything would smooth it.

Source: Blom and Bar-Shalom 1988, as in filterpy.kalman.IMMEstimator.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float

from autonomy.jit import kernel
from autonomy.perception.depth_image import DepthImage, Pixels
from autonomy.perception.sighting import LEAST_HALF_M, Footprint, Sighting

if TYPE_CHECKING:
    from filterpy.kalman import IMMEstimator

_MODES = ((0.0, 0.01), (0.0, 2.0), (0.6, 1.4), (-0.6, 1.4))
"""Modes standing, straight, left and right: rate of turn in rad/s and power spectral density of
white acceleration in m^2/s^3 (people turn within a second); for standing, of white velocity."""
_FIRST_SHARES = (0.3, 0.5, 0.1, 0.1)  # of the modes, at the first sighting
_STAYS = 0.9
"""Probability that a mode lasts from one sighting to the next."""
# Row: mode before, column: mode after; each row adds up to 1. Standing turns into a turn rarely.
_CHANGES = np.array(
    [
        [_STAYS, 0.08, 0.01, 0.01],
        [0.03, _STAYS, 0.035, 0.035],
        [0.01, 0.08, _STAYS, 0.01],
        [0.01, 0.08, 0.01, _STAYS],
    ]
)
_LONGEST_TURN_S = 1.0
"""Longest time for which an unseen obstacle is predicted to go on turning."""
# Variance of a standing obstacle's velocity; deviation of an unknown one's.
_STANDING_VARIANCE = 0.05**2
_FIRST_SPEED_SIGMA_MPS = 2.5
_SHRINK = 0.1  # of the excess, by which a known size shrinks at each smaller sighting
# Above this speed the obstacle's heading is its direction of motion; beyond this turn of the
# heading the size is measured anew.
_HEADING_SPEED_MPS = 0.6
_TURN_RAD = math.radians(20.0)
# Points looked at, across the obstacle, as shares of its size; and how to tell that they show what
# is behind it.
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
        """Start at the first sighting, at rest because nothing else is known."""
        forward = sighting.forward
        self.size: Footprint = sighting.footprint(math.atan2(forward[1], forward[0]))
        position, covariance = sighting.centre(self.size)
        self.mean = np.concatenate([position, np.zeros(3)])
        self.covariance = np.zeros((6, 6))
        self.covariance[:3, :3] = covariance
        self.covariance[3:, 3:] = _FIRST_SPEED_SIGMA_MPS**2 * np.eye(3)
        self._filter = _new_filter(self.mean, self.covariance)
        self._predicted: dict[float, tuple[np.ndarray, np.ndarray]] = {}
        self.n_hits, self.n_misses = 1, 0
        self.last_seen_s = self._time_s = time_s

    def predicted(self, time_s: float) -> tuple[Float[np.ndarray, " 6"], Float[np.ndarray, "6 6"]]:
        """Mean and covariance at a later time, blended from the modes by their probabilities."""
        # Several cameras look at one time, and nothing changes until one of them sees it.
        if time_s not in self._predicted:
            self._predicted[time_s] = self._blended(max(time_s - self.last_seen_s, 0.0))
        return self._predicted[time_s]

    def _blended(self, dt: float) -> tuple[Float[np.ndarray, " 6"], Float[np.ndarray, "6 6"]]:
        modes = zip(self._filter.filters, _motions(dt), strict=True)
        ahead = [mode.get_prediction(F=move, Q=noise) for mode, (move, noise) in modes]
        shares = self._filter.mu
        means, spreads = (np.array(values) for values in zip(*ahead, strict=True))
        mean = shares @ means
        apart = means - mean
        # Spread of the mixture: within the modes, plus between their means.
        return mean, np.tensordot(shares, spreads, 1) + (shares * apart.T) @ apart

    def predict(self, time_s: float) -> None:
        """Advance the mean to a later time; the filter itself waits for a sighting."""
        self.mean, self.covariance = self.predicted(time_s)
        self._time_s = max(time_s, self._time_s)

    def surprise(self, sighting: Sighting) -> float:
        """Squared Mahalanobis distance of a sighting from the track, 3 degrees of freedom."""
        position, covariance = sighting.centre(self.size)
        off = position - self.mean[:3]
        return float(off @ np.linalg.solve(self.covariance[:3, :3] + covariance, off))

    def see(self, sighting: Sighting) -> None:
        """Update the track with a sighting.

        A newly learned size shifts the centre although nothing has moved; the filter's states are
        shifted along, so that this is not taken for motion.
        """
        before, _ = sighting.centre(self.size)
        self._learn_size(sighting)
        position, noise = sighting.centre(self.size)
        motions = _motions(self._time_s - self.last_seen_s)
        for mode, (mode.F, mode.Q) in zip(self._filter.filters, motions, strict=True):
            mode.x[:3] += position - before
            mode.R = noise
        self._filter.predict()
        self._filter.update(position)
        self.mean, self.covariance = self._filter.x.copy(), self._filter.P.copy()
        self._predicted.clear()
        self.n_hits += 1
        self.n_misses = 0
        self.last_seen_s = self._time_s

    def _learn_size(self, sighting: Sighting) -> None:
        """Grow at once to the seen size; shrink slowly, and only if no border cuts it off."""
        vx, vy = self.mean[3:5].tolist()
        yaw, size = self.size.yaw_rad, self.size
        if math.hypot(vx, vy) > _HEADING_SPEED_MPS:
            # Modulo a quarter turn: a box looks the same along its length and its width.
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
        """True if an image shows the background of the place where the obstacle should be."""
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
        position: Expected position of the obstacle, ENU, m.
        half: Half its width and height, m.
        doubt: Error of inverse depth to allow for, 1/m.
    """
    depth, fx, fy, cx, cy, eye, rotation = pixels
    sight = np.zeros(3)
    for axis in range(3):
        for n in range(3):
            sight[axis] += (position[n] - eye[n]) * rotation[n, axis]
    # Behind the camera, or too near to look past.
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


def _new_filter(
    mean: Float[np.ndarray, " 6"], covariance: Float[np.ndarray, "6 6"]
) -> IMMEstimator:
    # Imported here: half a second that only flights with traffic need.
    from filterpy.kalman import IMMEstimator, KalmanFilter

    modes = []
    for _ in _MODES:
        mode = KalmanFilter(dim_x=6, dim_z=3)
        mode.x, mode.P, mode.H = mean.copy(), covariance.copy(), np.eye(3, 6)
        modes.append(mode)
    return IMMEstimator(modes, np.array(_FIRST_SHARES), _CHANGES)


@lru_cache(maxsize=16)
def _motions(dt: float) -> list[tuple[Float[np.ndarray, "6 6"], Float[np.ndarray, "6 6"]]]:
    """Transition matrix of position and velocity over a time, and its noise, for each mode.

    The noise of a moving mode is that of white acceleration, integrated over the time.
    """
    wander = np.kron([[dt**3 / 3, dt**2 / 2], [dt**2 / 2, dt]], np.eye(3))
    (_, drift), *moving = _MODES
    still = np.diag([1.0] * 3 + [0.0] * 3), np.diag([drift * dt] * 3 + [_STANDING_VARIANCE] * 3)
    motions = [still]
    for rate, psd in moving:
        turn_s = min(dt, _LONGEST_TURN_S)
        angle = rate * turn_s
        c, s = math.cos(angle), math.sin(angle)
        # Distance covered per unit of velocity, ahead and to its left: on the arc, then straight
        # on.
        ahead, aside = (s / rate, (1.0 - c) / rate) if rate else (turn_s, 0.0)
        ahead, aside = ahead + (dt - turn_s) * c, aside + (dt - turn_s) * s
        move = np.eye(6)
        move[:2, 3:5] = [[ahead, -aside], [aside, ahead]]
        move[3:5, 3:5] = [[c, -s], [s, c]]
        move[2, 5] = dt
        motions.append((move, psd * wander))
    return motions
