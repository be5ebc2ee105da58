"""What the plant tells: states and estimator status, built from its report on demand."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from autonomy.types import State, Vector3

_MAX_HORIZONTAL_SIGMA_M = 5.0
"""Position counts as lost beyond this: some ten seconds without a fix."""


@dataclass(frozen=True, kw_only=True, slots=True)
class EstimatorStatus:
    """Health of the estimate; ratios of innovations to their gates are accepted below 1."""

    is_attitude_valid: bool
    is_position_valid: bool
    sigma_horizontal_m: float
    sigma_vertical_m: float
    sigma_velocity_mps: float
    sigma_tilt_rad: float
    sigma_yaw_rad: float
    gnss_age_s: float
    """Since the last accepted fix."""
    gnss_position_ratio: float
    gnss_velocity_ratio: float
    baro_ratio: float
    heading_ratio: float
    gyro_bias_flu_radps: Vector3
    accel_bias_flu_mps2: Vector3


class Report:
    """The plant's report of one advance as Python numbers."""

    def __init__(
        self, values: Sequence[float], slices: Mapping[str, slice], time_us: int, tick_us: int
    ) -> None:
        self._values = values
        self._slices = slices
        self._time_us = time_us
        self._tick_us = tick_us

    def vector(self, name: str) -> Any:
        """A field as a tuple."""
        return tuple(self._values[self._slices[name]])

    def scalar(self, name: str) -> float:
        """A field of one number."""
        return self._values[self._slices[name].start]

    def state(self, kind: str) -> State:
        """State "true" or "est"."""
        return State(
            time_us=self._time_us,
            position_enu_m=self.vector(f"position_{kind}"),
            velocity_enu_mps=self.vector(f"velocity_{kind}"),
            quat_wxyz=self.vector(f"quat_{kind}"),
            angular_rate_flu_radps=self.vector(f"rate_{kind}"),
        )

    def estimator(self) -> EstimatorStatus:
        """Status of the filter."""
        v = self.vector("variance")
        is_aligned = self.scalar("is_aligned") == 1.0
        sigma_horizontal = math.sqrt(v[0] + v[1]) if is_aligned else math.inf
        ratios = self.vector("ratios")
        return EstimatorStatus(
            is_attitude_valid=is_aligned,
            is_position_valid=sigma_horizontal < _MAX_HORIZONTAL_SIGMA_M,
            sigma_horizontal_m=sigma_horizontal,
            sigma_vertical_m=math.sqrt(v[2]) if is_aligned else math.inf,
            sigma_velocity_mps=math.sqrt(v[3] + v[4] + v[5]) if is_aligned else math.inf,
            sigma_tilt_rad=math.sqrt(v[6] + v[7]) if is_aligned else math.inf,
            sigma_yaw_rad=math.sqrt(v[8]) if is_aligned else math.inf,
            gnss_age_s=self.scalar("gnss_age_ticks") * self._tick_us * 1e-6,
            gnss_position_ratio=ratios[0],
            gnss_velocity_ratio=ratios[1],
            baro_ratio=ratios[2],
            heading_ratio=ratios[3],
            gyro_bias_flu_radps=self.vector("gyro_bias"),
            accel_bias_flu_mps2=self.vector("accel_bias"),
        )
