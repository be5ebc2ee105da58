"""Error-state Kalman filter: where the vehicle is, from noisy sensors alone."""

from autonomy.estimation.error_state import FILTER_DTYPE, EstimatorCfg, new_filter

__all__ = ["FILTER_DTYPE", "EstimatorCfg", "new_filter"]
