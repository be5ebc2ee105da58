"""Interacting multiple models of a moving obstacle: it stands, goes straight, turns left or right.

Four linear Kalman filters of position and velocity run side by side, weighed by how well each
foretells the sightings.

    symbol   name                                              unit
    x, P     mean and covariance of a mode's state             m, m/s
    mu       probability of each mode

Source: Blom and Bar-Shalom 1988, "The interacting multiple model algorithm for systems with
Markovian switching coefficients"; the same numbers as filterpy.kalman.IMMEstimator, which takes
40 times as long.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from autonomy.jit import kernel

_MODES = ((0.0, 0.01), (0.0, 2.0), (0.6, 1.4), (-0.6, 1.4))
"""Modes standing, straight, left and right: rate of turn in rad/s and power spectral density of
white acceleration in m^2/s^3 (people turn within a second); for standing, of white velocity."""
_N = len(_MODES)
_FIRST_SHARES = (0.3, 0.5, 0.1, 0.1)
_STAYS = 0.9
"""Probability that a mode lasts from one sighting to the next."""
CHANGES = np.array(
    [
        [_STAYS, 0.08, 0.01, 0.01],
        [0.03, _STAYS, 0.035, 0.035],
        [0.01, 0.08, _STAYS, 0.01],
        [0.01, 0.08, 0.01, _STAYS],
    ]
)
_LONGEST_TURN_S = 1.0
"""Longest time for which an unseen obstacle is predicted to go on turning."""
_STANDING_VARIANCE = 0.05**2
_TINY = 2.2250738585072014e-308


class Modes(NamedTuple):
    """State of the four filters."""

    means: np.ndarray
    """Position and velocity by each mode, ENU, (4, 6)."""
    covariances: np.ndarray
    """(4, 6, 6)."""
    shares: np.ndarray
    """Probability of each mode, (4,)."""


def begin(mean: Float[np.ndarray, " 6"], covariance: Float[np.ndarray, "6 6"]) -> Modes:
    """Modes that all begin from one state."""
    return Modes(np.tile(mean, (_N, 1)), np.tile(covariance, (_N, 1, 1)), np.array(_FIRST_SHARES))


@kernel
def ahead(modes: Modes, dt: float) -> tuple[Float[np.ndarray, " 6"], Float[np.ndarray, "6 6"]]:
    """Mean and covariance at a later time, blended from the modes by their probabilities."""
    means, covariances = np.empty((_N, 6)), np.empty((_N, 6, 6))
    for m in range(_N):
        _advance(m, modes.means[m], modes.covariances[m], dt, means[m], covariances[m])
    return _blended(means, covariances, modes.shares)


@kernel
def fused(
    modes: Modes,
    dt: float,
    shift: Float[np.ndarray, " 3"],
    position: Float[np.ndarray, " 3"],
    noise: Float[np.ndarray, "3 3"],
    changes: Float[np.ndarray, "4 4"],
) -> tuple[Modes, Float[np.ndarray, " 6"], Float[np.ndarray, "6 6"]]:
    """Modes after a sighting, and the mean and covariance that they amount to.

    Args:
        modes: Modes after the sighting before.
        dt: Time between the two, s.
        shift: Correction of all positions before, because another size is known.
        position: Position that was seen, ENU, m.
        noise: Its covariance, m^2.
        changes: Probabilities of the mode (column) that follows each mode (row).
    """
    means, covariances, expected = _mixed(modes, shift, changes)
    shares = np.empty(_N)
    for m in range(_N):
        mean, covariance = np.empty(6), np.empty((6, 6))
        _advance(m, means[m], covariances[m], dt, mean, covariance)
        likelihood = _update(mean, covariance, position, noise)
        means[m], covariances[m] = mean, covariance
        shares[m] = expected[m] * likelihood
    shares /= shares.sum()
    blended = _blended(means, covariances, shares)
    return Modes(means, covariances, shares), blended[0], blended[1]


@kernel
def _mixed(
    modes: Modes, shift: np.ndarray, changes: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """States that the filters go on from when modes change, and the probabilities of the modes."""
    means, covariances = np.zeros((_N, 6)), np.zeros((_N, 6, 6))
    expected = np.zeros(_N)
    for to in range(_N):
        for was in range(_N):
            expected[to] += modes.shares[was] * changes[was, to]
        shares = modes.shares * changes[:, to] / expected[to]
        means[to], covariances[to] = _blended(modes.means, modes.covariances, shares)
        means[to, :3] += shift
    return means, covariances, expected


@kernel
def _blended(
    means: np.ndarray, covariances: np.ndarray, shares: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Mean and covariance of a mixture."""
    mean, covariance = np.zeros(6), np.zeros((6, 6))
    for m in range(_N):
        mean += shares[m] * means[m]
    for m in range(_N):
        for a in range(6):
            for b in range(6):
                apart = (means[m, a] - mean[a]) * (means[m, b] - mean[b])
                covariance[a, b] += shares[m] * (apart + covariances[m, a, b])
    return mean, covariance


@kernel
def _advance(
    m: int,
    mean: np.ndarray,
    covariance: np.ndarray,
    dt: float,
    mean_out: np.ndarray,
    covariance_out: np.ndarray,
) -> None:
    """Predict a state by one of the modes."""
    move, noise = _motion(m, dt)
    half = np.zeros((6, 6))
    for a in range(6):
        mean_out[a] = 0.0
        for b in range(6):
            if move[a, b] != 0.0:
                mean_out[a] += move[a, b] * mean[b]
                half[a] += move[a, b] * covariance[b]
    for a in range(6):
        for b in range(6):
            total = noise[a, b]
            for c in range(6):
                total += half[a, c] * move[b, c]
            covariance_out[a, b] = total


@kernel
def _motion(m: int, dt: float) -> tuple[np.ndarray, np.ndarray]:
    """Transition matrix of position and velocity over a time by a mode, and its noise."""
    rate, psd = _MODES[m]
    move, noise = np.zeros((6, 6)), np.zeros((6, 6))
    for axis in range(3):
        move[axis, axis] = 1.0
        if m == 0:
            noise[axis, axis], noise[3 + axis, 3 + axis] = psd * dt, _STANDING_VARIANCE
            continue
        move[3 + axis, 3 + axis] = 1.0
        noise[axis, axis], noise[3 + axis, 3 + axis] = psd * dt**3 / 3, psd * dt
        noise[axis, 3 + axis] = noise[3 + axis, axis] = psd * dt**2 / 2
    if m == 0:
        return move, noise
    turn_s = min(dt, _LONGEST_TURN_S)
    c, s = math.cos(rate * turn_s), math.sin(rate * turn_s)
    # Distance covered per unit of velocity, ahead and to its left: on the arc, then straight on.
    on, aside = turn_s, 0.0
    if rate != 0.0:
        on, aside = s / rate, (1.0 - c) / rate
    on, aside = on + (dt - turn_s) * c, aside + (dt - turn_s) * s
    move[0, 3], move[0, 4], move[1, 3], move[1, 4] = on, -aside, aside, on
    move[3, 3], move[3, 4], move[4, 3], move[4, 4] = c, -s, s, c
    move[2, 5] = dt
    return move, noise


@kernel
def _update(
    mean: np.ndarray, covariance: np.ndarray, position: np.ndarray, noise: np.ndarray
) -> float:
    """Kalman update of a state by a position, in place; the likelihood of the position."""
    spread = covariance[:3, :3] + noise
    inverse, determinant = _inverse(spread)
    off = position - mean[:3]
    surprise = 0.0
    for a in range(3):
        for b in range(3):
            surprise += off[a] * inverse[a, b] * off[b]
    gain = np.zeros((6, 3))
    for a in range(6):
        for b in range(3):
            for c in range(3):
                gain[a, b] += covariance[a, c] * inverse[c, b]
    before = covariance.copy()
    for a in range(6):
        for b in range(3):
            mean[a] += gain[a, b] * off[b]
        for b in range(6):
            for c in range(3):
                covariance[a, b] -= gain[a, c] * before[c, b]
    for a in range(6):
        for b in range(a):
            covariance[a, b] = covariance[b, a] = 0.5 * (covariance[a, b] + covariance[b, a])
    likelihood = math.exp(-0.5 * surprise) / math.sqrt((2.0 * math.pi) ** 3 * determinant)
    return max(likelihood, _TINY)


@kernel
def _inverse(s: np.ndarray) -> tuple[np.ndarray, float]:
    """Inverse and determinant of a symmetric matrix (3, 3)."""
    inverse = np.empty((3, 3))
    for a in range(3):
        b, c = (a + 1) % 3, (a + 2) % 3
        for d in range(3):
            e, f = (d + 1) % 3, (d + 2) % 3
            inverse[d, a] = s[b, e] * s[c, f] - s[b, f] * s[c, e]
    determinant = s[0, 0] * inverse[0, 0] + s[0, 1] * inverse[1, 0] + s[0, 2] * inverse[2, 0]
    return inverse / determinant, determinant
