"""What the autopilot needs of the vehicle below it: a description for the type checker.

`flightsim.plant.Plant` fits; so does anything else that estimates a state and follows a
`Setpoint`. There is no truth here: an autopilot knows only what its sensors and its estimator say.
"""

from __future__ import annotations

from typing import Protocol

from autonomy.types import Setpoint, State, Vector3


class EstimatorLike(Protocol):
    """Health of the state estimate."""

    @property
    def is_attitude_valid(self) -> bool:
        """Whether the attitude can be flown by."""
        ...

    @property
    def is_position_valid(self) -> bool:
        """Whether position and velocity can be flown by."""
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
        """0 or 1 none, 2 flat, 3 and more three-dimensional."""
        ...

    @property
    def position_enu_m(self) -> Vector3:
        """Where the receiver believes to be."""
        ...


class StampedLike(Protocol):
    """Latest reading of a sensor of which only the age matters here."""

    @property
    def time_us(self) -> int:
        """Time of the present tick or reading since the start."""
        ...


class SensorsLike(Protocol):
    """Latest readings that the autopilot looks at."""

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
    """What a power module measures."""

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
    """A vehicle with sensors, estimator and inner loops, seen every 20 ms."""

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
        """The battery."""
        ...

    @property
    def collective_thrust_fraction(self) -> float:
        """Commanded collective thrust over the maximum."""
        ...

    def apply(self, setpoint: Setpoint) -> None:
        """Follow this setpoint from the next tick on."""
        ...
