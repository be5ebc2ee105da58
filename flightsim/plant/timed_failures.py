"""Failures that strike in flight: which part fails, how, and how long after lift-off.

A trial that disables a part in flight must do so at the same moment of every repetition. The moment
therefore counts from lift-off, by the true height, and not from the pilot's own phases, which
differ between pilots.
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
"""Height above the first position at which the vehicle counts as flying."""
MOST_AFTER_S = 3600.0
"""Latest moment after lift-off that is accepted."""
_NONE = "none"
# PART[ROTOR]=KIND@SECONDS. The part is matched lazily, so that digits at its end are the rotor.
_WORD = re.compile(r"(?P<part>[a-z_]+?)(?P<rotor>[1-9]\d?)?=(?P<kind>[a-z]+)@(?P<after>[\d.]+)")
_MOTOR = "motor"
_KINDS = {kind.name.lower(): kind for kind in Failure if kind is not Failure.NONE}


class TimedFailureError(ValueError):
    """A failure that no vehicle can have; the message names what would be valid."""


@dataclass(frozen=True, slots=True)
class TimedFailure:
    """A part that fails at a moment of the flight and stays failed."""

    part: str
    """Name of a sensor, as in `Failures.fail_sensor`, or `motor`."""
    rotor: int | None
    """Number of the motor, from 1 on; None for sensors."""
    kind: Failure
    after_s: float
    """Simulated seconds after lift-off."""

    def strike(self, plant: Plant) -> None:
        """Make the part fail now.

        Args:
            plant: Vehicle with the part.
        """
        if self.rotor is None:
            plant.failures.fail_sensor(self.part, self.kind)
        else:
            # Users number motors from 1, in the order of the flight stack; the plant numbers rotors
            # from 0.
            rotor = plant.world.airframe.motors[self.rotor - 1]
            plant.failures.fail_rotor(rotor, self.kind)


def parse_failures(text: str, n_rotors: int) -> tuple[TimedFailure, ...]:
    """Read failures such as `gnss=off@5,motor1=off@8`, or `none`.

    Args:
        text: Parts, kinds and seconds after lift-off, separated by commas.
        n_rotors: Number of motors of the vehicle.

    Raises:
        TimedFailureError: If a word is not of this form; the message names the valid parts or
            kinds.
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
    """Makes parts of a vehicle fail at their moments; call `update` after each tick."""

    def __init__(self, plant: Plant, failures: Sequence[TimedFailure]) -> None:
        """Watch a vehicle that stands on its start."""
        self._plant = plant
        self._pending = sorted(failures, key=lambda failure: failure.after_s)
        self._ground_m = plant.truth.position_enu_m[2]
        self._lifted_us: int | None = None

    def update(self) -> None:
        """Make all parts fail whose moment has come."""
        if self._lifted_us is None:
            if self._plant.truth.position_enu_m[2] < self._ground_m + LIFTED_M:
                return
            self._lifted_us = self._plant.time_us
        for failure in self._due((self._plant.time_us - self._lifted_us) * 1e-6):
            failure.strike(self._plant)

    def _due(self, flown_s: float) -> Iterator[TimedFailure]:
        while self._pending and self._pending[0].after_s <= flown_s:
            yield self._pending.pop(0)
