"""First-order Gauss-Markov process: the slow error that most sensors have.

A bias b with correlation time tau, driven by white noise of density s, obeys

    b(t + dt) = exp(-dt / tau) b(t) + s_d n,   s_d^2 = s^2 tau / 2 (1 - exp(-2 dt / tau))

with n standard normal. This step is exact for any dt, so that a sensor at 5 Hz and one at 250 Hz
drift alike. The process settles at a standard deviation of s sqrt(tau / 2). A plain random walk
would grow without bound in a long flight.
"""

from __future__ import annotations

import math

import numpy as np

from autonomy.jit import kernel


def drift_terms(density: float, correlation_s: float, dt_s: float) -> tuple[float, float]:
    """Return the decay factor and the standard deviation of the increment for one step of `dt_s`.

    Args:
        density: Density s of the driving noise, in units of the bias a second a sqrt(Hz).
        correlation_s: Correlation time tau, positive.
        dt_s: Length of the step.
    """
    decay = math.exp(-dt_s / correlation_s)
    sigma = density * math.sqrt(0.5 * correlation_s * (1.0 - decay * decay))
    return decay, sigma


def density_of(stationary_sigma: float, correlation_s: float) -> float:
    """Return the density of the noise that drives a drift of a given deviation.

    Args:
        stationary_sigma: Standard deviation at which the process settles.
        correlation_s: Its correlation time.
    """
    return stationary_sigma / math.sqrt(0.5 * correlation_s)


@kernel
def advance_drift(
    bias: np.ndarray, decay: float, sigma: np.ndarray, normals: np.ndarray, first: int
) -> None:
    """Advance three independent processes by one step, in place.

    Args:
        bias: Values of the processes, shape (3,); changed.
        decay: Decay factor of all three, from `drift_terms`.
        sigma: Standard deviation of each increment, shape (3,).
        normals: Standard normals; the function uses `normals[first : first + 3]`.
        first: Place of the first number that is used.
    """
    for i in range(3):
        bias[i] = decay * bias[i] + sigma[i] * normals[first + i]
