"""First-order Gauss-Markov process: the slow error that most sensors have.

b(t + dt) = exp(-dt / tau) b(t) + s_d n, n standard normal, with s_d^2 = s^2 tau / 2
(1 - exp(-2 dt / tau)) for a driving noise of density s. Its stationary deviation is
s sqrt(tau / 2).
"""

from __future__ import annotations

import math

import numpy as np

from autonomy.jit import kernel


def drift_terms(density: float, correlation_s: float, dt_s: float) -> tuple[float, float]:
    """Decay factor and standard deviation of the increment, for one step of `dt_s`."""
    decay = math.exp(-dt_s / correlation_s)
    sigma = density * math.sqrt(0.5 * correlation_s * (1.0 - decay * decay))
    return decay, sigma


def density_of(stationary_sigma: float, correlation_s: float) -> float:
    """Density of the driving noise that keeps the process at a standard deviation."""
    return stationary_sigma / math.sqrt(0.5 * correlation_s)


@kernel
def advance_drift(
    bias: np.ndarray, decay: float, sigma: np.ndarray, normals: np.ndarray, first: int
) -> None:
    """One step of three independent processes; uses `normals[first : first + 3]`."""
    for i in range(3):
        bias[i] = decay * bias[i] + sigma[i] * normals[first + i]
