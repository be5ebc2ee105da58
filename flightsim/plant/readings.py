"""What the plant tells: estimator status and sensor readings, built from its report on demand."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from autonomy.model.quadrotor import Vector3
from autonomy.types import State
from flightsim.sensors.gnss import GnssCfg

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


@dataclass(frozen=True, kw_only=True, slots=True)
class ImuReading:
    """Mean specific force and angular rate of the last IMU interval."""

    time_us: int
    accel_flu_mps2: Vector3
    gyro_flu_radps: Vector3


@dataclass(frozen=True, kw_only=True, slots=True)
class GnssReading:
    """Latest fix; `time_us` is the time for which it is valid, 0 before the first."""

    time_us: int
    position_enu_m: Vector3
    velocity_enu_mps: Vector3
    fix_type: int
    """MAVLink's GPS_FIX_TYPE; 0 or 1 before the first fix or without signal."""
    eph_m: float
    epv_m: float
    n_satellites: int


@dataclass(frozen=True, kw_only=True, slots=True)
class BaroReading:
    """Static pressure and the altitude above mean sea level that the standard gives it."""

    time_us: int
    pressure_pa: float
    altitude_m: float
    temperature_degc: float


@dataclass(frozen=True, kw_only=True, slots=True)
class MagReading:
    """Magnetic field in body axes."""

    time_us: int
    field_flu_ut: Vector3


@dataclass(frozen=True, kw_only=True, slots=True)
class SensorReadings:
    """The latest sample of every sensor."""

    imu: ImuReading
    gnss: GnssReading
    baro: BaroReading
    mag: MagReading
    range_m: float
    """Along body -z; infinite beyond reach, NaN before the first sample or when switched off."""


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

    def sensors(self, gnss: GnssCfg, *, has_gnss: bool) -> SensorReadings:
        """Latest readings; without signal the receiver reports no fix."""
        is_heard = has_gnss and self.scalar("hears_satellites") == 1.0
        is_fixed = is_heard and self.scalar("gnss_tick") >= 0.0
        settling = self.scalar("gnss_settling")
        return SensorReadings(
            imu=ImuReading(
                time_us=self._time_us,
                accel_flu_mps2=self.vector("accel"),
                gyro_flu_radps=self.vector("gyro"),
            ),
            gnss=GnssReading(
                time_us=self._time("gnss_tick"),
                position_enu_m=self.vector("gnss_position"),
                velocity_enu_mps=self.vector("gnss_velocity"),
                fix_type=gnss.fix_type if is_fixed else 1,
                eph_m=math.hypot(gnss.reported_accuracy_m[0], settling) if is_fixed else math.inf,
                epv_m=math.hypot(gnss.reported_accuracy_m[1], settling) if is_fixed else math.inf,
                n_satellites=gnss.n_satellites if is_fixed else 0,
            ),
            baro=BaroReading(
                time_us=self._time("baro_tick"),
                pressure_pa=self.scalar("pressure"),
                altitude_m=self.scalar("pressure_altitude"),
                temperature_degc=self.scalar("temperature"),
            ),
            mag=MagReading(time_us=self._time("mag_tick"), field_flu_ut=self.vector("field")),
            range_m=self.scalar("range"),
        )

    def _time(self, name: str) -> int:
        return max(0, round(self.scalar(name))) * self._tick_us
