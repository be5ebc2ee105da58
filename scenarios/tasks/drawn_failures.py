"""Failures of a recipe, which leave open when they strike and which motor they take.

A failure at a fixed time would always find the vehicle at the same place. A recipe says
`gnss+vio=off@2:8` or `motor=off@3:10`: parts that fail together, how, and the seconds after
lift-off between which the moment is drawn. A task has one moment and one motor, in the words of
`flightsim.plant.timed_failures`.
"""

from __future__ import annotations

import numpy as np

from autonomy.model.quadrotor import MAX_ROTORS
from flightsim.plant.timed_failures import TimedFailureError, parse_failures
from flightsim.testbench import TestbenchError

_NONE = "none"
_MOTOR = "motor"


def require_failures(word: str) -> None:
    """Refuse a word of a recipe that no vehicle can draw from.

    Raises:
        TestbenchError: If it is none; one line says what would be valid.
    """
    try:
        # Try it with the most rotors: a vehicle with fewer is checked when its task is drawn.
        parse_failures(_drawn(word, np.random.default_rng(0), MAX_ROTORS), MAX_ROTORS)
    except (TimedFailureError, ValueError) as error:
        raise TestbenchError(
            f"failures {word!r} is not valid ({error}); valid: none, or PART=KIND@FROM:TO in "
            "seconds after lift-off, such as gnss+vio=off@2:8 or motor=off@3:10"
        ) from None


def draw_failures(word: str, rng: np.random.Generator, n_rotors: int) -> str:
    """Draw the failures of one task.

    Args:
        word: A word of the recipe that `require_failures` has accepted.
        rng: Generator for moment and motor. Every word uses the same number of draws, so that later
            draws of the task do not depend on it.
        n_rotors: Motors of the vehicle.
    """
    return _drawn(word, rng, n_rotors)


def _drawn(word: str, rng: np.random.Generator, n_rotors: int) -> str:
    share, rotor = float(rng.random()), 1 + int(rng.integers(n_rotors))
    if word == _NONE:
        return word
    parts, _, rest = word.partition("=")
    kind, _, times = rest.partition("@")
    first, _, last = times.partition(":")
    low_s, high_s = float(first), float(last or first)
    if not low_s <= high_s:
        raise ValueError(f"{times} is no range")
    moment_s = round(low_s + share * (high_s - low_s), 2)
    names = [f"{name}{rotor}" if name == _MOTOR else name for name in parts.split("+")]
    return ",".join(f"{name}={kind}@{moment_s:g}" for name in names)
