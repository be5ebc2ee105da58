"""State of the vehicle known to the autopilot in one tick, read once from the plant."""

from __future__ import annotations

from math import hypot, inf, isfinite, isnan, nan

from autonomy.types import LEVEL, ZERO3, yaw_of
from flightsim.autopilot.parameters import Parameters
from flightsim.plant import Plant
from flightsim.sensors.imu import IMU
from flightsim.sensors.rangefinder import RANGEFINDER

TICK_S = 0.02
# Silence after which the rangefinder's height, and the inertial sensor, are no longer believed.
_RANGE_PATIENCE_US, _IMU_PATIENCE_US = 500_000, 100_000
_MOST_ACCEL_MPS2, _MOST_RATE_RADPS = 150.0, 60.0
"""Acceleration and rate that no sound sensor reports: nearly the 16 g of a usual sensor, and more
than twice the spin of a vehicle on three rotors."""
_STEEP_COSINE = 0.7
"""Cosine of the tilt beyond which the rangefinder looks too far aside."""
_MOST_WILD = 2
"""Consecutive readings beyond those bounds, a tenth of a second apart, that condemn the sensor. An
impact makes one."""


class Vehicle:
    """Estimates and readings of the present tick; never the truth.

    Fast values are read in each tick by `read`, slow or costly ones a few times a second by
    `read_slowly`.
    """

    def __init__(self, plant: Plant, parameters: Parameters, hover_thrust_fraction: float) -> None:
        self._plant = plant
        self._parameters = parameters
        self.hover_thrust_fraction = hover_thrust_fraction
        self.is_landed = True
        """Decision of the land detector."""
        self.resting_range_m = 0.0
        """Last reading of the rangefinder on the ground, m: heights count from it."""
        self.time_us = 0
        self.position_enu_m = self.velocity_enu_mps = self.angular_rate_flu_radps = ZERO3
        self.quat_wxyz = LEVEL
        self.is_attitude_ok = self.is_position_ok = False
        self.is_dead_reckoning = False
        """True if the position rests on inertial sensors alone, so that it may jump or drift."""
        self.velocity_sigma_mps = inf
        self.yaw_rad = self.thrust_fraction = 0.0
        self.range_m = nan
        self.is_imu_ok = True
        self.lost_rotors: tuple[int, ...] = ()
        self.wind_mps = 0.0
        self._n_wild = 0

    def read(self) -> None:
        """Read the plant's present estimates; call it in each tick."""
        plant = self._plant
        state = plant.estimate
        self.time_us = plant.time_us
        self.position_enu_m = state.position_enu_m
        self.velocity_enu_mps = state.velocity_enu_mps
        self.angular_rate_flu_radps = state.angular_rate_flu_radps
        self.quat_wxyz = state.quat_wxyz
        self.yaw_rad = yaw_of(state.quat_wxyz)
        self.thrust_fraction = plant.collective_thrust_fraction

    def read_range(self) -> None:
        """Read the rangefinder; NaN if it has fallen silent."""
        sensors = self._plant.sensors
        is_heard = sensors.is_delivering(RANGEFINDER, self.time_us, _RANGE_PATIENCE_US)
        self.range_m = sensors.range_m if is_heard else nan
        if self.cos_tilt >= _STEEP_COSINE:
            # Infinite where nothing is within its range.
            # The controller asks for the room below: near the ground it must not lean on its legs.
            height_m = self.range_m * self.cos_tilt - self.resting_range_m
            self._plant.set_room_below(0.0 if isnan(height_m) else max(height_m, 0.0))

    def read_slowly(self) -> None:
        """Read values that change slowly or are costly; call it a few times a second."""
        self.read_range()
        self._read_imu()
        self.lost_rotors = self._plant.lost_rotors
        self.wind_mps = hypot(*self._plant.wind_est_enu_mps)
        estimator = self._plant.estimator
        self.is_attitude_ok = estimator.is_attitude_valid
        self.is_dead_reckoning = estimator.is_dead_reckoning
        self.velocity_sigma_mps = estimator.sigma_velocity_mps
        limit_m = self._parameters["COM_POS_FS_EPH"]
        self.is_position_ok = (
            estimator.is_position_valid
            and isfinite(self.position_enu_m[0])
            # A negative COM_POS_FS_EPH accepts any deviation.
            and (limit_m < 0.0 or estimator.sigma_horizontal_m <= limit_m)
        )

    def _read_imu(self) -> None:
        """Judge the inertial sensor: it must deliver, change, and stay within plausible bounds."""
        imu = self._plant.sensors.imu
        is_wild = (
            max(map(abs, imu.accel_flu_mps2)) > _MOST_ACCEL_MPS2
            or max(map(abs, imu.gyro_flu_radps)) > _MOST_RATE_RADPS
        )
        self._n_wild = self._n_wild + 1 if is_wild else 0
        is_heard = self._plant.sensors.is_delivering(IMU, self.time_us, _IMU_PATIENCE_US)
        self.is_imu_ok = is_heard and self._n_wild < _MOST_WILD

    @property
    def speed_xy_mps(self) -> float:
        """Horizontal speed, m/s."""
        return hypot(self.velocity_enu_mps[0], self.velocity_enu_mps[1])

    @property
    def cos_tilt(self) -> float:
        """Cosine of the angle between body z and up: 1 is level, negative is upside down."""
        _, x, y, _ = self.quat_wxyz
        return 1.0 - 2.0 * (x * x + y * y)

    @property
    def height_m(self) -> float | None:
        """Height over the surface that the rangefinder sees, m, 0 at rest; None if it sees none."""
        cosine = self.cos_tilt
        if not isfinite(self.range_m) or cosine < _STEEP_COSINE:
            return None
        return self.range_m * cosine - self.resting_range_m
