"""Verdict on an episode: that of a trial (`scenarios.trials.verdict`), from the same history."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from flightsim.plant.record import HISTORY_DTYPE, with_rotors
from flightsim.vehicles.airframe import Airframe
from scenarios.trials.bounds import Touched, lift_off_row
from scenarios.trials.contacts import Contact, ContactFinder, MoverPoses
from scenarios.trials.score import Goal, is_at_rest, rotors_turn, score_flight
from scenarios.trials.verdict import Ending, Judgement, judge

_CONTACT_ROWS = 10
"""Control ticks of 4 ms between two looks at what is touched."""


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

    def judge(
        self, airframe: Airframe, goal: Goal, ending: Ending, contacts: ContactFinder | None = None
    ) -> Judgement:
        """Verdict on all of it.

        Args:
            airframe: Vehicle that flew.
            goal: Where it should have landed, if it should.
            ending: How the episode ended.
            contacts: Finds what was touched, so that only the area's own surface counts as the
                area; needed if the goal has an area.
        """
        history = self._rows(0, airframe)
        touched = None
        if goal.area is not None and contacts is not None:
            touched = Touched(contacts=_touched(history, contacts))
        return judge(score_flight(history, airframe, goal, touched), goal, ending)

    def _rows(self, first: int, airframe: Airframe) -> np.ndarray:
        own = (rows[self._own] for rows in self._ticks[first:])
        wide = np.frombuffer(b"".join(own), HISTORY_DTYPE)
        return with_rotors(wide, len(airframe.quadrotor.rotors))


def _touched(history: np.ndarray, contacts: ContactFinder) -> tuple[Contact, ...]:
    """What was touched after lift-off; nothing moves there but the vehicle.

    Rows that only continue a contact are looked at every 40 ms: contacts closer than 200 ms count
    as one anyway, and a vehicle at rest would cost as much as its flight.
    """
    is_touching = history["is_touching"] > 0
    begins = is_touching & ~np.concatenate([[False], is_touching[:-1]])
    is_sampled = np.arange(len(history)) % _CONTACT_ROWS == 0
    counts = (begins | is_sampled) & (np.arange(len(history)) >= lift_off_row(history))
    n_rows = len(history)
    still = MoverPoses(position_enu_m=np.zeros((n_rows, 0, 3)), quat_wxyz=np.zeros((n_rows, 0, 4)))
    return contacts.find(history, still, counts)
