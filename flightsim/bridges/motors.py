"""Conversion of a flight stack's motor outputs into the speeds of our rotors.

PX4 and ArduPilot number the motors of a quadrotor alike; `Airframe.motors` has our rotors in that
order. A speed controller turns its motor at a speed proportional to its input, so thrust is the
square of the input. Parameters make both stacks reckon with it (`flightsim.bridges.launch`).
"""

from __future__ import annotations

from flightsim.bridges.physics.bridge import MotorOutputs
from flightsim.plant.handover import RotorSpeeds
from flightsim.vehicles import Airframe


class MotorMap:
    """Order and greatest speeds of an airframe's rotors, for the outputs of a flight stack."""

    def __init__(self, airframe: Airframe) -> None:
        self._motors = airframe.motors
        self._max_radps = [rotor.max_speed_radps for rotor in airframe.quadrotor.rotors]

    def rotor_speeds_radps(self, outputs: MotorOutputs) -> RotorSpeeds | None:
        """Return the speeds of our rotors for the outputs of a stack's motors.

        Args:
            outputs: Outputs of the motors 1 to 4; values outside of 0 to 1 are cut off.

        Returns:
            Speeds of our rotors 0 to 3 in rad/s; None, which cuts the power, if all motors are off.
        """
        if max(outputs) <= 0.0:
            return None
        speeds = [0.0] * 4
        for rotor, output in zip(self._motors, outputs, strict=True):
            speeds[rotor] = min(max(output, 0.0), 1.0) * self._max_radps[rotor]
        a, b, c, d = speeds
        return (a, b, c, d)
