"""Switches by which parts of a plant fail."""

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
"""Sensor and part of each name."""
_SLOW_SHARE = 0.85
ROTOR_FAILURES = frozenset({Failure.NONE, Failure.OFF, Failure.STUCK, Failure.SLOW})
"""Kinds of failure that a motor can have."""


class Failures:
    """Failures of one plant, each until it is taken back."""

    def __init__(self, record: np.void, readings: SensorReadings) -> None:
        """Switch parts of a record of `PLANT_DTYPE`, whose sensors these are."""
        self._record = record
        self._rotors = range(record["rotors"]["n_rotors"])
        self._readings = readings

    def fail_sensor(self, sensor: str, failure: Failure) -> None:
        """Let a sensor fail, or a part of the IMU: `accelerometer`, `gyroscope`.

        One that is off keeps its last reading and its time.

        Raises:
            PlantError: If there is no such sensor.
        """
        if sensor not in SENSOR_PARTS:
            raise PlantError(f"sensor = {sensor!r}: valid are {', '.join(SENSOR_PARTS)}")
        name, part = SENSOR_PARTS[sensor]
        r = self._record[name]
        r["failure"][part] = failure
        r["failing_since"][part] = self._record["engine"]["tick"] + 1
        self._readings.drop()

    def fail_rotor(self, rotor: int, failure: Failure) -> None:
        """Let a motor (from 0) stop, stick at its present speed, or turn slower than commanded.

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
        """Let a rotor (from 0) make only this share, 0 to 1, of its thrust and torque.

        Raises:
            PlantError: If there is no such rotor or share.
        """
        if rotor not in self._rotors or not 0.0 <= effectiveness <= 1.0:
            raise PlantError(
                f"rotor = {rotor}, effectiveness = {effectiveness}: 0 to {self._rotors[-1]} and "
                "0 to 1 are valid"
            )
        self._record["rotors"]["effectiveness"][rotor] = effectiveness
