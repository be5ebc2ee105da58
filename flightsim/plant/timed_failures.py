"""Failures that strike in flight: which part fails, how, and how long after lift-off.

A trial that takes something from a pilot on the way must take it at the same moment of every
repetition. So the moment counts from lift-off, by the true height, and not from the pilot's own
phases, which differ between pilots.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from flightsim.plant.failures import ROTOR_FAILURES, SENSOR_PARTS
from flightsim.plant.plant import Plant
from flightsim.sensors.failure import Failure

LIFTED_M = 0.5
"""Height above the first position from which the vehicle counts as flying."""
MOST_AFTER_S = 3600.0
_NONE = "none"
_WORD = re.compile(r"(?P<part>[a-z_]+?)(?P<rotor>[1-9]\d?)?=(?P<kind>[a-z]+)@(?P<after>[\d.]+)")
_MOTOR = "motor"
_KINDS = {kind.name.lower(): kind for kind in Failure if kind is not Failure.NONE}


class TimedFailureError(ValueError):
    """A failure that no vehicle can have; one line says what would be valid."""


@dataclass(frozen=True, slots=True)
class TimedFailure:
    """A part that fails at a moment of the flight, and stays so."""

    part: str
    """A sensor, as `Failures.fail_sensor` calls it, or `motor`."""
    rotor: int | None
    """Number of the motor, from 1 on; None for sensors."""
    kind: Failure
    after_s: float
    """Simulated seconds after lift-off."""

    def strike(self, plant: Plant) -> None:
        """Let the part fail."""
        if self.rotor is None:
            plant.failures.fail_sensor(self.part, self.kind)
        else:
            rotor = plant.world.airframe.motors[self.rotor - 1]
            plant.failures.fail_rotor(rotor, self.kind)


def parse_failures(text: str, n_rotors: int) -> tuple[TimedFailure, ...]:
    """Read failures such as `gnss=off@5,motor1=off@8`, or `none`.

    Args:
        text: Parts, kinds and seconds after lift-off.
        n_rotors: Motors of the vehicle.

    Raises:
        TimedFailureError: If a word is none of these.
    """
    if text == _NONE:
        return ()
    return tuple(_parsed(text, word.strip(), n_rotors) for word in text.split(","))


def _parsed(text: str, word: str, n_rotors: int) -> TimedFailure:
    match = _WORD.fullmatch(word)
    parts = f"{', '.join(SENSOR_PARTS)}, motor1 to motor{n_rotors}"
    if match is None:
        raise TimedFailureError(
            f"fail {text!r}: {word!r} is not valid; valid: none, or PART=KIND@SECONDS with commas "
            f"between them, such as gnss=off@5; parts are {parts}"
        )
    part, rotor = match["part"], None if match["rotor"] is None else int(match["rotor"])
    is_motor = part == _MOTOR and rotor is not None and rotor <= n_rotors
    if not (is_motor or (part in SENSOR_PARTS and rotor is None)):
        raise TimedFailureError(
            f"fail {text!r}: part {part + (match['rotor'] or '')!r} is unknown; valid: {parts}"
        )
    kinds = {name: kind for name, kind in _KINDS.items() if not is_motor or kind in ROTOR_FAILURES}
    if match["kind"] not in kinds:
        raise TimedFailureError(
            f"fail {text!r}: kind {match['kind']!r} is unknown; valid: {', '.join(kinds)}"
        )
    try:
        after_s = float(match["after"])
    except ValueError:
        after_s = math.inf
    if not 0.0 <= after_s <= MOST_AFTER_S:
        raise TimedFailureError(
            f"fail {text!r}: {match['after']} s is out of range; valid: 0 to {MOST_AFTER_S:g} s"
        )
    return TimedFailure(part, rotor, kinds[match["kind"]], after_s)


class FailureTimer:
    """Lets parts of a vehicle fail at their moments; `update` it after each tick."""

    def __init__(self, plant: Plant, failures: Sequence[TimedFailure]) -> None:
        """Watch a vehicle that stands on its start."""
        self._plant = plant
        self._ahead = sorted(failures, key=lambda failure: failure.after_s)
        self._ground_m = plant.truth.position_enu_m[2]
        self._lifted_us: int | None = None

    def update(self) -> None:
        """Let what is due fail."""
        if self._lifted_us is None:
            if self._plant.truth.position_enu_m[2] < self._ground_m + LIFTED_M:
                return
            self._lifted_us = self._plant.time_us
        for failure in self._due((self._plant.time_us - self._lifted_us) * 1e-6):
            failure.strike(self._plant)

    def _due(self, flown_s: float) -> Iterator[TimedFailure]:
        while self._ahead and self._ahead[0].after_s <= flown_s:
            yield self._ahead.pop(0)
