"""Consistency of an estimator: normalised squared errors against their chi-square law.

NEES is e^T P^-1 e for an error e and the covariance P that the filter claims; over consistent
flights it is chi-square distributed with as many degrees of freedom as e has components.

Source: Bar-Shalom, Li and Kirubarajan 2001, "Estimation with applications to tracking and
navigation", section 5.4.2.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from scipy.spatial.transform import Rotation

from autonomy.estimation.error_state import ATTITUDE, POSITION, VELOCITY
from flightsim.plant import Plant

BLOCKS = {"position": POSITION, "velocity": VELOCITY, "attitude": ATTITUDE}
"""First index of each block of three states whose errors have a truth."""
_DIMENSION = 3  # states of a block


@dataclass(frozen=True, slots=True)
class Band:
    """Interval of the mean NEES of some flights with a probability of 95%."""

    low: float
    high: float


def band(n_flights: int) -> Band:
    """95% band of a block's mean NEES over independent flights.

    Args:
        n_flights: Number of flights, 1 or more.
    """
    from scipy.stats import chi2

    freedom = _DIMENSION * n_flights
    low, high = chi2.ppf((0.025, 0.975), freedom) / n_flights
    return Band(float(low), float(high))


def errors(plant: Plant) -> dict[str, Float[np.ndarray, " 3"]]:
    """True minus estimated value for each of `BLOCKS`; attitude as a rotation vector, ENU."""
    true, estimate = plant.truth, plant.estimate
    return {
        "position": np.subtract(true.position_enu_m, estimate.position_enu_m),
        "velocity": np.subtract(true.velocity_enu_mps, estimate.velocity_enu_mps),
        "attitude": attitude_error(np.array(true.quat_wxyz), np.array(estimate.quat_wxyz)),
    }


def attitude_error(
    true_wxyz: Float[np.ndarray, " 4"], estimate_wxyz: Float[np.ndarray, " 4"]
) -> Float[np.ndarray, " 3"]:
    """Rotation vector in the world that turns the estimated attitude into the true one, rad."""
    true, estimate = Rotation.from_quat([true_wxyz, estimate_wxyz], scalar_first=True)
    return (true * estimate.inv()).as_rotvec()


def nees(plant: Plant) -> dict[str, float]:
    """Present NEES of each of `BLOCKS`; 3 on average for a consistent filter."""
    covariance = plant.filter["covariance"]
    found = {}
    for block, e in errors(plant).items():
        part = slice(BLOCKS[block], BLOCKS[block] + _DIMENSION)
        found[block] = float(e @ np.linalg.solve(covariance[part, part], e))
    return found
