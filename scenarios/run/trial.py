"""A trial: one flight of a pilot, judged by the truth."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

from scenarios.run.scoring import FlightScore

if TYPE_CHECKING:
    from scenarios.pilot import Pilot
    from scenarios.run.companion import Companion

MAX_TRIAL_S = 240.0
"""Simulated seconds after which a trial has failed."""
SETTLE_S = 1.0
"""Time for which the vehicle rests after the pilot is done, before it is judged."""
MAX_TILT_AT_REST_DEG = 20.0
"""Beyond this it did not land, it fell over."""


@dataclass(frozen=True, kw_only=True, slots=True)
class TrialResult:
    """Result of a flight, which `--json` prints; figures that do not apply are None."""

    success: bool | None
    reason: str
    scene: str
    vehicle: str
    seed: int
    area: int | None
    sim_seconds: float
    wall_seconds: float
    cpu_seconds: float
    real_time_factor: float
    contacts_before_touchdown: int | None
    touchdown_error_m: float | None
    """Horizontal distance of the resting place from the touchdown point that the pilot chose."""
    position_rmse_m: float | None
    attitude_rmse_deg: float | None
    state_hash: str
    """Hash of every state of the flight: the same seed gives the same one on the same machine."""
    recording: str | None

    def to_plain(self) -> dict[str, Any]:
        """The result as plain data."""
        return asdict(self)


@dataclass(frozen=True, slots=True)
class Verdict:
    """Whether a trial counts as done, and why."""

    success: bool
    reason: str


def rounded(figure: float | None) -> float | None:
    """Round to a millimetre or a thousandth of a degree; None where there is no figure."""
    return None if figure is None or math.isnan(figure) else round(figure, 3)


def decisions(pilot: Pilot) -> dict[str, list[dict[str, Any]]]:
    """Every change of phase and every plan made anew, with its time and reason, as plain data."""
    transitions = [
        {
            "time_s": round(change.time_us * 1e-6, 2),
            "from": change.source.value,
            "to": change.target.value,
            "reason": change.reason,
        }
        for change in pilot.transitions
    ]
    replans = [
        {"time_s": round(replan.time_us * 1e-6, 2), "reason": replan.reason}
        for replan in pilot.replans
    ]
    return {"transitions": transitions, "replans": replans}


def judge(pilot: Companion, score: FlightScore) -> Verdict:
    """A trial succeeds when the pilot says so and the truth agrees."""
    is_landing = pilot.area is not None
    objections: tuple[tuple[bool, str], ...] = (
        (not pilot.is_done or not pilot.verdict.success, pilot.verdict.reason),
        (not score.has_flown, "never left the ground"),
        (
            is_landing and score.contacts_before_touchdown > 0,
            f"touched something {score.contacts_before_touchdown} times before touchdown",
        ),
        (is_landing and not score.is_inside_area, "came to rest outside the chosen landing area"),
        (
            score.tilt_at_rest_deg > MAX_TILT_AT_REST_DEG,
            f"fell over: {score.tilt_at_rest_deg:.0f} degrees at rest",
        ),
    )
    for applies, reason in objections:
        if applies:
            return Verdict(success=False, reason=reason)
    return Verdict(success=True, reason=pilot.verdict.reason)
