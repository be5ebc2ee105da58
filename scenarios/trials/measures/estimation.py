"""Errors of the estimate against the truth, over a whole flight."""

from __future__ import annotations

import math

import numpy as np
from jaxtyping import Float

from autonomy.types import ControlLevel


class EstimationErrors:
    """Sums of the estimator's errors from arming on, over a history that grows.

    Sums instead of rows, so that a run without end takes no more memory.
    """

    def __init__(self) -> None:
        self._n_rows = 0
        self._position_m2 = 0.0
        self._angle_rad2 = 0.0

    def add(self, history: np.ndarray) -> None:
        """Add rows, one for each control tick (`flightsim.plant.record`)."""
        # On the ground before arming the filter may not even be aligned.
        armed = history[history["setpoint_level"] > ControlLevel.OFF]
        error_m = armed["position_est_enu_m"] - armed["position_true_enu_m"]
        angle_rad = rotation_angle_rad(armed["quat_est_wxyz"], armed["quat_true_wxyz"])
        self._n_rows += len(armed)
        self._position_m2 += float(np.sum(error_m**2))
        self._angle_rad2 += float(np.sum(angle_rad**2))

    @property
    def position_rmse_m(self) -> float:
        """Root mean square of the 3-D distance; NaN before arming."""
        return self._root(self._position_m2)

    @property
    def attitude_rmse_deg(self) -> float:
        """Root mean square of the angle between estimated and true attitude; NaN before arming."""
        return math.degrees(self._root(self._angle_rad2))

    def _root(self, sum_of_squares: float) -> float:
        return math.sqrt(sum_of_squares / self._n_rows) if self._n_rows else math.nan


def rotation_angle_rad(
    a_wxyz: Float[np.ndarray, "n 4"], b_wxyz: Float[np.ndarray, "n 4"]
) -> Float[np.ndarray, " n"]:
    """Return the angle of the rotation between two attitudes, rad, 0 to pi."""
    # Both parts of conj(a) b, because the scalar part alone loses small angles to rounding.
    scalar = np.abs(np.sum(a_wxyz * b_wxyz, axis=1))
    vector = (
        a_wxyz[:, :1] * b_wxyz[:, 1:]
        - b_wxyz[:, :1] * a_wxyz[:, 1:]
        - np.cross(a_wxyz[:, 1:], b_wxyz[:, 1:])
    )
    return 2.0 * np.arctan2(np.linalg.norm(vector, axis=1), scalar)
