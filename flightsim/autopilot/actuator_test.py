"""Motor tests: motors turn one after another for a set time, on the ground and disarmed only."""

from __future__ import annotations

from dataclasses import dataclass

from flightsim.autopilot.flight_context import FlightContext
from flightsim.autopilot.results import ACCEPTED, Reply, denied
from flightsim.plant import Plant
from flightsim.vehicles.airframe import Airframe

LONGEST_S = 600.0
# Above this height the vehicle counts as off the ground, and all tests end.
"""Longest time for which one motor may be asked to turn."""
_MOST_HEIGHT_M = 0.1


@dataclass(frozen=True, slots=True)
class _Turn:
    rotor: int
    speed_radps: float
    start_us: int
    end_us: int


class ActuatorTest:
    """Requested motor tests. Arming or leaving the ground ends all of them."""

    def __init__(self, plant: Plant, flight: FlightContext, airframe: Airframe) -> None:
        self._plant = plant
        self._flight = flight
        self._most_radps = [rotor.max_speed_radps for rotor in airframe.quadrotor.rotors]
        self._still = (0.0,) * len(self._most_radps)
        self._turns: list[_Turn] = []

    def request(self, rotors: tuple[int, ...], throttle: float, seconds: float) -> Reply:
        """Turn rotors one after the other, each for the same time.

        Args:
            rotors: Rotors (from 0) in their order. A new test replaces one of the same rotor.
            throttle: Share of the greatest speed, 0 to 1.
            seconds: Time for each rotor, 0 to `LONGEST_S`.

        Returns:
            The reply. It is denied if COM_MOT_TEST_EN is not 1 or a value is out of range.
        """
        if self._flight.parameters["COM_MOT_TEST_EN"] != 1:
            return denied("COM_MOT_TEST_EN is 0; valid is 1")
        if not 0.0 <= throttle <= 1.0:
            return denied(f"throttle {throttle:g}; valid are 0 to 1")
        if not 0.0 <= seconds <= LONGEST_S:
            return denied(f"{seconds:g} s; valid are 0 to {LONGEST_S:g}")
        self.stop(rotors)
        start_us, length_us = self._plant.time_us, round(1e6 * seconds)
        for number, rotor in enumerate(rotors):
            begin_us = start_us + number * length_us
            speed_radps = throttle * self._most_radps[rotor]
            self._turns.append(_Turn(rotor, speed_radps, begin_us, begin_us + length_us))
        return ACCEPTED

    def stop(self, rotors: tuple[int, ...]) -> None:
        """End the tests of the given rotors; the other tests go on from the next `update`."""
        self._turns = [turn for turn in self._turns if turn.rotor not in rotors]
        self._plant.spin_rotors(self._still)

    def update(self, *, is_armed: bool) -> None:
        """Turn the rotors that are due now; call it once a tick."""
        if not self._turns:
            return
        now_us, speeds_radps = self._plant.time_us, [*self._still]
        # An unknown height, without a reading of the rangefinder, counts as on the ground.
        if is_armed or (self._flight.vehicle.height_m or 0.0) > _MOST_HEIGHT_M:
            self._turns = []
        self._turns = [turn for turn in self._turns if now_us < turn.end_us]
        for turn in self._turns:
            if turn.start_us <= now_us:
                speeds_radps[turn.rotor] = turn.speed_radps
        # Passed on even if no test is left, so that the last rotor stops.
        self._plant.spin_rotors(tuple(speeds_radps))
