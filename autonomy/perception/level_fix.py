"""Horizontal offset by one depth image alone, whatever the estimate believes.

    symbol   name                                              unit
    D        directions of offset and yaw that it determines   m, rad
    R        their variances
    L        information on the offset, D R^-1 D^T             1/m^2

An estimator must not be corrected by its own belief. The offset of the anchor mixes images and
estimate, so only the image counts here. Height and heading are taken from the anchor, because other
sensors know them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from autonomy.perception.match import Match

_LEAST_INFORMATION = 1e-3
"""Information in 1/m^2 below which a horizontal direction counts as open: 30 m."""


@dataclass(frozen=True, kw_only=True, slots=True)
class LevelFix:
    """Horizontal offset from the estimate to the map."""

    offset_enu_m: tuple[float, float]
    sigma_m: float
    """Standard deviation in the worst direction."""


def level_fix(
    match: Match,
    variances: Float[np.ndarray, " k"],
    prior: Float[np.ndarray, " 4"],
    covariance: Float[np.ndarray, "4 4"],
) -> LevelFix | None:
    """Horizontal offset by one image; None if it leaves a horizontal direction open.

    Args:
        match: Accepted match of the image.
        variances: Variances of its measured values.
        prior: Offset and yaw before the image; of these, height and yaw are used.
        covariance: Covariance of the prior.
    """
    weighted = match.directions / variances
    information, pull = weighted @ match.directions.T, weighted @ match.measured
    for k in (2, 3):
        information[k, k] += 1.0 / covariance[k, k]
        pull[k] += prior[k] / covariance[k, k]
    # Schur complement: height and yaw are eliminated, with their uncertainty.
    across = np.linalg.solve(information[2:, 2:], information[2:, :2])
    level = information[:2, :2] - information[:2, 2:] @ across
    least = float(np.linalg.eigvalsh(level)[0])
    if least < _LEAST_INFORMATION:
        return None
    east_m, north_m, _, _ = np.linalg.solve(information, pull).tolist()
    return LevelFix(offset_enu_m=(east_m, north_m), sigma_m=1.0 / math.sqrt(least))
