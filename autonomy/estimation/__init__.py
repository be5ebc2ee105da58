"""Error-state Kalman filter that estimates the vehicle's state from noisy sensors alone."""

from autonomy.estimation.cfg import DragModel, EstimatorCfg
from autonomy.estimation.error_state import FILTER_DTYPE, new_filter

__all__ = ["FILTER_DTYPE", "DragModel", "EstimatorCfg", "new_filter"]
