"""Protocols of the vehicle below the autopilot, for the type checker.

`flightsim.plant.Plant` satisfies them; so does anything that estimates a state and follows a
`Setpoint`. There is no truth here: an autopilot knows only its sensors and its estimator.
"""

from __future__ import annotations

from typing import Protocol

from autonomy.types import Setpoint, State, Vector3


class EstimatorLike(Protocol):
    """Health of the state estimate."""

    @property
    def is_attitude_valid(self) -> bool:
        """Whether the attitude can be used for flight."""
        ...

    @property
    def is_position_valid(self) -> bool:
        """Whether position and velocity can be used for flight."""
        ...

    @property
    def sigma_horizontal_m(self) -> float:
        """Standard deviation of the horizontal position."""
        ...

    @property
    def sigma_vertical_m(self) -> float:
        """Standard deviation of the height."""
        ...


class GnssLike(Protocol):
    """Latest satellite fix."""

    @property
    def time_us(self) -> int:
        """Time of the present tick or reading since the start."""
        ...

    @property
    def fix_type(self) -> int:
        """Fix type: 0 or 1 none, 2 two-dimensional, 3 and more three-dimensional."""
        ...

    @property
    def position_enu_m(self) -> Vector3:
        """Position measured by the receiver."""
        ...


class StampedLike(Protocol):
    """Latest reading of a sensor of which only the age matters to the autopilot."""

    @property
    def time_us(self) -> int:
        """Time of the present tick or reading since the start."""
        ...


class SensorsLike(Protocol):
    """Latest readings that the autopilot uses."""

    @property
    def imu(self) -> StampedLike:
        """Accelerometer and gyroscope."""
        ...

    @property
    def gnss(self) -> GnssLike:
        """Satellite receiver."""
        ...

    @property
    def baro(self) -> StampedLike:
        """Barometer."""
        ...

    @property
    def mag(self) -> StampedLike:
        """Magnetometer."""
        ...

    @property
    def range_m(self) -> float:
        """Distance along body -z; infinite if nothing is near, NaN if invalid."""
        ...


class BatteryLike(Protocol):
    """Measurements of the power module."""

    @property
    def voltage_v(self) -> float:
        """Voltage at the terminals."""
        ...

    @property
    def current_a(self) -> float:
        """Current drawn."""
        ...

    @property
    def consumed_mah(self) -> float:
        """Charge drawn since the start."""
        ...

    @property
    def remaining(self) -> float:
        """State of charge, 0 to 1."""
        ...


class PlantLike(Protocol):
    """A vehicle with sensors, estimator and inner loops, updated every 20 ms."""

    @property
    def time_us(self) -> int:
        """Time of the present tick or reading since the start."""
        ...

    @property
    def estimate(self) -> State:
        """Estimated state of the present tick."""
        ...

    @property
    def estimator(self) -> EstimatorLike:
        """Health of the estimate."""
        ...

    @property
    def sensors(self) -> SensorsLike:
        """Latest readings."""
        ...

    @property
    def battery(self) -> BatteryLike:
        """State of the battery."""
        ...

    @property
    def collective_thrust_fraction(self) -> float:
        """Commanded collective thrust as a fraction of the maximum."""
        ...

    def apply(self, setpoint: Setpoint) -> None:
        """Follow this setpoint from the next tick on."""
        ...
