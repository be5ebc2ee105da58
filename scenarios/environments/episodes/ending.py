"""Verdict on an episode: the same as of a trial (`scenarios.trials.verdict`), by the same history.

A policy is thus rewarded for exactly what campaigns count as a success.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from flightsim.vehicles.airframe import Airframe
from scenarios.trials.bounds import Touched, lift_off_row
from scenarios.trials.contacts import Contact, ContactFinder, MoverPoses
from scenarios.trials.figures import Figures, Goal
from scenarios.trials.verdict import Ending, Judgement, judge

_CONTACT_ROWS = 10
"""Number of control ticks of 4 ms between two checks of contacts."""


@dataclass(frozen=True, slots=True)
class Outcome:
    """End of an episode."""

    judgement: Judgement
    seconds: float
    """Simulated duration of the episode."""

    def to_info(self) -> dict[str, Any]:
        """Return the outcome as entries of `info`."""
        return {
            "is_success": bool(self.judgement.success),
            "code": self.judgement.code.value,
            "reason": self.judgement.reason,
            "seconds": self.seconds,
        }


def judge_episode(
    history: np.ndarray,
    n_before: int,
    airframe: Airframe,
    goal: Goal,
    ending: Ending,
    contacts: ContactFinder | None = None,
) -> Judgement:
    """Return the verdict on an episode.

    Args:
        history: Rows of its control ticks, at least from a second before the first contact on.
        n_before: Number of rows before those.
        airframe: Vehicle that flew.
        goal: Goal of the episode; its area, if it should land.
        ending: End of the episode.
        contacts: Finder of touched objects, so that only the area's own surface counts as the area;
            needed if the goal has an area.
    """
    # Without an area any contact ends a flight, so the objects need not be known.
    touched = None
    if goal.area is not None and contacts is not None:
        touched = Touched(contacts=_touched(history, n_before, contacts))
    return judge(Figures(history, airframe, goal, touched), goal, ending)


def _touched(history: np.ndarray, n_before: int, contacts: ContactFinder) -> tuple[Contact, ...]:
    """Return the contacts after lift-off; only the vehicle moves there.

    Rows that only continue a contact are looked at every 40 ms. Contacts closer than 200 ms count
    as one anyway, and otherwise a vehicle at rest would cost as much as its flight.
    """
    is_touching = history["is_touching"] > 0
    begins = is_touching & ~np.concatenate([[False], is_touching[:-1]])
    n_rows = len(history)
    # Counted from the beginning of the flight, so that the choice does not depend on dropped rows.
    is_sampled = np.arange(n_before, n_before + n_rows) % _CONTACT_ROWS == 0
    counts = (begins | is_sampled) & (np.arange(n_rows) >= lift_off_row(history))
    still = MoverPoses(position_enu_m=np.zeros((n_rows, 0, 3)), quat_wxyz=np.zeros((n_rows, 0, 4)))
    return contacts.find(history, still, counts)
