"""Motor tests: MAV_CMD_ACTUATOR_TEST by PX4's tools, MAV_CMD_DO_MOTOR_TEST by ArduPilot's."""

from __future__ import annotations

import math
from collections.abc import Mapping

from flightsim.autopilot.modes import LandedState
from flightsim.autopilot.results import ACCEPTED, Reply, denied
from flightsim.mavlink.commands import UNSUPPORTED, Command, Executor, choice
from flightsim.mavlink.dialect import dialect as mav
from flightsim.mavlink.personalities import Personality
from flightsim.mavlink.view import VehicleView

_FIRST_MOTOR_FUNCTION = mav.ACTUATOR_OUTPUT_FUNCTION_MOTOR1
_PWM_LEAST, _PWM_SPAN = 1000.0, 1000.0  # pulses of 1,000 to 2,000 us are a throttle of 0 to 1


class MotorCommands:
    """Executes motor tests, with motors numbered as the flight stack numbers them.

    PX4 counts them by their outputs, ArduPilot's default order goes clockwise from the front.
    """

    def __init__(self, view: VehicleView, personality: Personality) -> None:
        self._autopilot = view.autopilot
        airframe = view.plant.world.airframe
        self._by_number = airframe.motors
        sequence = airframe.rotors_clockwise
        default = sequence if personality.tests_motors_clockwise else airframe.motors
        self._orders = {
            mav.MOTOR_TEST_ORDER_DEFAULT: default,
            mav.MOTOR_TEST_ORDER_SEQUENCE: sequence,
            mav.MOTOR_TEST_ORDER_BOARD: airframe.motors,
        }
        self.executors: Mapping[int, Executor] = {
            mav.MAV_CMD_ACTUATOR_TEST: self._test_actuator,
            mav.MAV_CMD_DO_MOTOR_TEST: self._test_motors,
        }

    def _test_actuator(self, c: Command) -> Reply:
        """Turn one motor; a throttle of NaN ends its test."""
        function = choice(c.x)
        number = None if function is None else function - _FIRST_MOTOR_FUNCTION
        if number is None or not 0 <= number < len(self._by_number):
            return UNSUPPORTED
        rotors = (self._by_number[number],)
        if fault := self._obstacle():
            return denied(fault)
        if math.isnan(c.param1):
            self._autopilot.actuator_test.stop(rotors)
            return ACCEPTED
        return self._autopilot.actuator_test.request(rotors, c.param1, c.param2)

    def _test_motors(self, c: Command) -> Reply:
        """Turn one motor, or several one after the other."""
        first, kind, n = choice(c.param1), choice(c.param2), choice(c.x, default=1)
        # An unknown order is refused below; 0 is the flight stack's own.
        order = self._orders.get(choice(c.y, default=mav.MOTOR_TEST_ORDER_DEFAULT) or 0)
        throttles = {
            mav.MOTOR_TEST_THROTTLE_PERCENT: c.param3 / 100.0,
            mav.MOTOR_TEST_THROTTLE_PWM: (c.param3 - _PWM_LEAST) / _PWM_SPAN,
        }
        if kind is None or kind not in throttles or order is None:
            return UNSUPPORTED
        n = max(1, n or 1)
        if first is None or not 1 <= first <= first + n - 1 <= len(order):
            return denied(f"motors {c.param1:g} and {n - 1} more; valid are 1 to {len(order)}")
        if fault := self._obstacle():
            return denied(fault)
        rotors = order[first - 1 : first - 1 + n]
        return self._autopilot.actuator_test.request(rotors, throttles[kind], c.param4)

    def _obstacle(self) -> str | None:
        """Return the reason that forbids a test, or None."""
        if self._autopilot.is_armed:
            return "the vehicle is armed"
        is_landed = self._autopilot.landed_state is LandedState.ON_GROUND
        return None if is_landed else "the vehicle is not on the ground"
