"""Verdict on an episode: that of a trial (`scenarios.trials.verdict`), from the same history."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from flightsim.plant.record import HISTORY_DTYPE, with_rotors
from flightsim.vehicles.airframe import Airframe
from scenarios.trials.score import Goal, is_at_rest, rotors_turn, score_flight
from scenarios.trials.verdict import Ending, Judgement, judge


@dataclass(frozen=True, slots=True)
class Outcome:
    """How an episode ended."""

    judgement: Judgement
    seconds: float
    """Simulated time that it took."""

    def to_info(self) -> dict[str, Any]:
        """What `info` says of it."""
        return {
            "is_success": bool(self.judgement.success),
            "code": self.judgement.code.value,
            "reason": self.judgement.reason,
            "seconds": self.seconds,
        }


class EpisodeLog:
    """Rows of an episode, one for each control tick, as bytes.

    numpy copies records of many fields one field at a time, and the rows of one world alone cost as
    much as those of all: so each log keeps those of all, and looks only at its own.
    """

    def __init__(self, index: int, n_bytes: int) -> None:
        """Look at world `index`, whose rows of an advance take `n_bytes`."""
        self._own = slice(index * n_bytes, (index + 1) * n_bytes)
        self._ticks: list[bytes] = []

    def add(self, rows: bytes) -> None:
        """Take the rows of an advance of all worlds, `HISTORY_DTYPE` (n, k)."""
        self._ticks.append(rows)

    def is_still(self, airframe: Airframe, n_advances: int) -> bool:
        """Whether vehicle and rotors were at rest over the last advances."""
        last = self._rows(-n_advances, airframe)
        return is_at_rest(last) and not rotors_turn(last, airframe)[-1]

    def judge(self, airframe: Airframe, goal: Goal, ending: Ending) -> Judgement:
        """Verdict on all of it."""
        return judge(score_flight(self._rows(0, airframe), airframe, goal), goal, ending)

    def _rows(self, first: int, airframe: Airframe) -> np.ndarray:
        own = (rows[self._own] for rows in self._ticks[first:])
        wide = np.frombuffer(b"".join(own), HISTORY_DTYPE)
        return with_rotors(wide, len(airframe.quadrotor.rotors))
