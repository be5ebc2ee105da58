"""Dryden turbulence at low altitude, as air velocities at one moving point.

    symbol   name                                           unit
    h        height above ground, 10 to 1,000 ft            m
    V        speed through the air, at least 1 m/s          m/s
    L        length scales along, across, up                m
    sigma    standard deviations along, across, up          m/s
    T        L / V                                          s
    x        states of the filters, unit stationary variance

Along the wind a first-order filter 1 / (1 + T s), across and up (1 + sqrt(3) T s) / (1 + T s)^2,
each driven by white noise and integrated exactly over a step. States are normalised: a change of
height or speed scales what they mean and never adds energy.

Deviations: the axes are the wind's, not the body's, as in the standard near the ground; V has
a floor, without which nothing would change for a vehicle hovering in calm air; gradients across
the vehicle, which is far smaller than L, are omitted.

Sources: MIL-F-8785C, 3.7.2.1 (spectra), 3.7.3.4 (scales and intensities near the ground).
"""

from __future__ import annotations

import math

import numpy as np
from jaxtyping import Float

from autonomy.jit import kernel

N_STATES = 5
"""Number of filter states: one along, two across, two up."""
N_NORMALS = 5
"""Number of standard normals for one step."""

_FOOT_M = 0.3048
_LOWEST_FT, _HIGHEST_FT = 10.0, 1000.0
_LEAST_SPEED_MPS = 1.0
# Below this ratio of step to time constant the closed forms cancel numerically.
_SHORT_STEP = 0.1
_SERIES_TERMS = 8
_SQRT_3 = math.sqrt(3.0)


@kernel
def length_scales_m(height_m: float) -> tuple[float, float]:
    """Return the length scales of turbulence (m), horizontal and vertical, at a height."""
    feet = min(max(height_m / _FOOT_M, _LOWEST_FT), _HIGHEST_FT)
    horizontal_ft = feet / (0.177 + 0.000823 * feet) ** 1.2
    return horizontal_ft * _FOOT_M, feet * _FOOT_M


@kernel
def horizontal_ratio(height_m: float) -> float:
    """Return the ratio of the horizontal to the vertical standard deviation of turbulence."""
    feet = min(max(height_m / _FOOT_M, _LOWEST_FT), _HIGHEST_FT)
    return 1.0 / (0.177 + 0.000823 * feet) ** 0.4


@kernel
def step_turbulence(
    x: np.ndarray,
    turbulence_mps: np.ndarray,
    height_m: float,
    speed_mps: float,
    sigma_up_mps: float,
    dt_s: float,
    normals: np.ndarray,
) -> None:
    """Advance the filters by one step.

    Args:
        x: Filter states (5,), changed.
        turbulence_mps: Result (3,): along the wind, to its left, up.
        height_m: Height above ground.
        speed_mps: Speed through the air.
        sigma_up_mps: Standard deviation of vertical turbulence.
        dt_s: Length of the step.
        normals: Standard normals (5,).
    """
    along_m, up_m = length_scales_m(height_m)
    speed = max(speed_mps, _LEAST_SPEED_MPS)
    sigma = sigma_up_mps * horizontal_ratio(height_m)
    step = dt_s * speed / along_m
    decay = math.exp(-step)
    # expm1 keeps its digits for short steps, in which 1 - exp(-2 step) would cancel.
    x[0] = decay * x[0] + math.sqrt(-math.expm1(-2.0 * step)) * normals[0]
    turbulence_mps[0] = sigma * x[0]
    turbulence_mps[1] = sigma * _step_second_order(x[1:3], step, normals[1], normals[2])
    step = dt_s * speed / up_m
    turbulence_mps[2] = sigma_up_mps * _step_second_order(x[3:5], step, normals[3], normals[4])


@kernel
def _step_second_order(x: np.ndarray, step: float, normal: float, other: float) -> float:
    """Step T x0' = n - x0, T x1' = x0 - x1 by step = dt / T; the output has unit variance."""
    decay = math.exp(-step)
    variance_0 = -math.expm1(-2.0 * step)
    covariance, variance_1 = _driven(step, 1), _driven(step, 2)
    gain = math.sqrt(variance_0)
    mixed = covariance / gain
    x[1] = decay * (x[1] + step * x[0]) + mixed * normal
    # Rounding may leave a negative variance for tiny steps.
    x[1] += math.sqrt(max(variance_1 - mixed * mixed, 0.0)) * other
    x[0] = decay * x[0] + gain * normal
    # The numerator 1 + sqrt(3) T s as a combination of both states, scaled to unit variance.
    return math.sqrt(0.5) * (_SQRT_3 * x[0] + (1.0 - _SQRT_3) * x[1])


@kernel
def _driven(step: float, power: int) -> float:
    """Return twice the integral of z^power exp(-2 z) from 0 to `step`, for powers 1 and 2."""
    if step > _SHORT_STEP:
        decay = math.exp(-2.0 * step)
        if power == 1:
            return 0.5 - decay * (step + 0.5)
        return 0.5 - decay * (step * step + step + 0.5)
    total, term = 0.0, 2.0 * step ** (power + 1)
    for k in range(_SERIES_TERMS):
        total += term / (power + 1 + k)
        term *= -2.0 * step / (k + 1)
    return total


def stationary_states(generator: np.random.Generator) -> Float[np.ndarray, " 5"]:
    """Draw random states of the stationary process, so that a flight does not begin in calm air."""
    x = generator.standard_normal(N_STATES)
    for first in (1, 3):
        # Stationary: the second state has variance 1/2, and covariance 1/2 with the first.
        x[first + 1] = 0.5 * x[first] + 0.5 * x[first + 1]
    return x
