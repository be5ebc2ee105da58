"""Switches that make sensors and motors of a plant fail."""

from __future__ import annotations

import numpy as np

from flightsim.plant.cfg import PlantError
from flightsim.plant.sensing import SENSORS, SensorReadings
from flightsim.sensors.failure import Failure
from flightsim.sensors.imu import ACCELEROMETER, GYROSCOPE, IMU

SENSOR_PARTS = {
    **{sensor.name: (sensor.name, 0) for sensor in SENSORS if sensor is not IMU},
    "accelerometer": (IMU.name, ACCELEROMETER),
    "gyroscope": (IMU.name, GYROSCOPE),
}
"""Sensor and number of its part, by the name that callers use."""
_SLOW_SHARE = 0.85
"""Share of the commanded speed at which a slow motor turns."""
ROTOR_FAILURES = frozenset({Failure.NONE, Failure.OFF, Failure.STUCK, Failure.SLOW})
"""Kinds of failure that a motor can have; the others make sense for measurements only."""


class Failures:
    """Failures of one plant; each lasts until it is set to `Failure.NONE`."""

    def __init__(self, record: np.void, readings: SensorReadings) -> None:
        """Switch parts of a vehicle.

        Args:
            record: Record of the plant, of `PLANT_DTYPE`; changed.
            readings: Readings of the same plant, which drop what they have read when a sensor
                changes.
        """
        self._record = record
        self._rotors = range(record["rotors"]["n_rotors"])
        self._readings = readings

    def fail_sensor(self, sensor: str, failure: Failure) -> None:
        """Make a sensor fail, or a part of the IMU: `accelerometer` or `gyroscope`.

        A sensor that is off keeps its last reading and the time of it.

        Args:
            sensor: A key of `SENSOR_PARTS`.
            failure: Kind of failure; `Failure.NONE` mends the sensor.

        Raises:
            PlantError: If there is no such sensor.
        """
        if sensor not in SENSOR_PARTS:
            raise PlantError(f"sensor = {sensor!r}: valid are {', '.join(SENSOR_PARTS)}")
        name, part = SENSOR_PARTS[sensor]
        r = self._record[name]
        r["failure"][part] = failure
        # From the next tick: the present one has been measured already.
        r["failing_since"][part] = self._record["engine"]["tick"] + 1
        self._readings.drop()

    def fail_rotor(self, rotor: int, failure: Failure) -> None:
        """Make a motor (from 0) stop, stick at its present speed, or turn slower than commanded.

        Raises:
            PlantError: If there is no such rotor, or no such failure of one.
        """
        if rotor not in self._rotors or failure not in ROTOR_FAILURES:
            names = ", ".join(kind.name for kind in sorted(ROTOR_FAILURES))
            raise PlantError(
                f"rotor = {rotor}, failure = {failure.name}: 0 to {self._rotors[-1]} and {names} "
                "are valid"
            )
        r = self._record["rotors"]
        shares = {Failure.NONE: 1.0, Failure.SLOW: _SLOW_SHARE}
        r["command_share"][rotor] = shares.get(failure, 0.0)
        is_stuck = failure is Failure.STUCK
        r["stuck_radps"][rotor] = r["speed_radps"][rotor] if is_stuck else 0.0

    def weaken_rotor(self, rotor: int, effectiveness: float) -> None:
        """Make a rotor (from 0) produce only this share, 0 to 1, of its thrust and torque.

        Raises:
            PlantError: If there is no such rotor or share.
        """
        if rotor not in self._rotors or not 0.0 <= effectiveness <= 1.0:
            raise PlantError(
                f"rotor = {rotor}, effectiveness = {effectiveness}: 0 to {self._rotors[-1]} and "
                "0 to 1 are valid"
            )
        self._record["rotors"]["effectiveness"][rotor] = effectiveness
