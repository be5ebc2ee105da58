"""Result of a run, which `--json` prints and a recording keeps."""

from __future__ import annotations

import math
from collections.abc import Sized
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

from aeroscene.scene import InteractionArea
from autonomy.types import Vector3
from scenarios.trials.score import FlightScore
from scenarios.trials.verdict import Code, Fate

if TYPE_CHECKING:
    from scenarios.pilot import Pilot


@dataclass(frozen=True, kw_only=True, slots=True)
class TrialResult:
    """Result of a run; figures that do not apply are None. docs/verdict.md explains each."""

    success: bool | None
    reason: str
    code: Code
    fate: Fate | None
    """State in which the flight left the vehicle, whatever its task was."""
    scene: str
    vehicle: str
    seed: int
    start: Vector3
    """Point that the vehicle stood on at the start, ENU."""
    goal: str
    """`area`, or the grade of the goal in words."""
    text: str | None
    """Goal in words."""
    area: int | None
    """Assigned area. For a goal in words, the area of its place on which the flight ended, or the
    nearest one to that."""
    navigated: bool | None
    """True if it came above the assigned area, without a contact on the way."""
    landed_area: int | None
    """Area that all soles ended on."""
    sim_seconds: float
    wall_seconds: float
    cpu_seconds: float
    real_time_factor: float
    contacts_before_touchdown: int | None
    touchdown_error_m: float | None
    """Horizontal distance of the resting place from the assigned area's chosen point."""
    touchdown_speed_mps: float | None
    slide_m: float | None
    """Greatest horizontal distance, after the first contact with the area, from that place."""
    soles_inside: bool | None
    """True if all soles ended on the assigned area."""
    tilt_at_rest_deg: float | None
    stopped_after_s: float | None
    """Time from touchdown until the rotors stood still for good."""
    rotor_spin_ups: int | None
    """Times that the rotors took the weight again after the touchdown."""
    navigation_s: float | None
    """Time from lift-off until it was first above the assigned area."""
    flight_s: float | None
    """Time from lift-off to touchdown."""
    energy_j: float | None
    """Electrical energy from lift-off to touchdown, or to the end."""
    jerk_rms_mps3: float | None
    replans: int | None
    """Number of plans that the pilot made anew; None if it does not count them."""
    least_clearance_m: float | None
    nearest_mover_m: float | None
    navigation_error_m: float | None = None
    """Distance from the end of the flight to the place that the text means."""
    oracle_error_m: float | None = None
    """Least distance to that place at any time of the flight."""
    path_m: float | None = None
    """Length of the flown path to a goal in words."""
    position_rmse_m: float | None
    attitude_rmse_deg: float | None
    contacts: tuple[dict[str, Any], ...]
    """All contacts after lift-off: object, time, place and speed."""
    state_hash: str
    """Hash of every state of the flight: the same seed gives the same one on the same machine."""
    recording: str | None
    lockstep: dict[str, int] | None = None
    """Number of steps that a flight stack of another project has answered, see
    docs/flight_stacks.md; None if ours flew."""

    def to_plain(self) -> dict[str, Any]:
        """Return the result as plain data."""
        # Enumerations become their words.
        fate = None if self.fate is None else self.fate.value
        return asdict(self) | {"code": self.code.value, "fate": fate}


def figures(
    score: FlightScore, area: InteractionArea | None, pilot: object = None
) -> dict[str, Any]:
    """Return the fields of a `TrialResult` that a score has, and those that a pilot may report.

    Args:
        score: Score of the flight.
        area: Assigned area; None if there was none.
        pilot: The pilot, with its `replans` if it counts them; None if nobody flew.
    """
    # A pilot of a user's need not count its plans.
    replans: Sized | None = getattr(pilot, "replans", None)
    return {
        "area": None if area is None else area.id,
        "navigated": None if area is None else _has_navigated(score),
        "landed_area": score.landed_area,
        "contacts_before_touchdown": None if area is None else score.contacts_before_touchdown,
        "touchdown_error_m": rounded(score.touchdown_error_m),
        "touchdown_speed_mps": rounded(score.touchdown_speed_mps),
        "slide_m": rounded(score.slide_m),
        # Without an assigned area there is nothing for soles to be inside of.
        "soles_inside": None if area is None else score.n_soles_inside == score.n_soles,
        "tilt_at_rest_deg": rounded(score.tilt_at_rest_deg) if score.is_down else None,
        "stopped_after_s": rounded(score.stopped_after_s),
        "rotor_spin_ups": score.rotor_spin_ups if score.is_down else None,
        **{name: rounded(figure) for name, figure in asdict(score.effort).items()},
        "replans": None if replans is None else len(replans),
        "least_clearance_m": rounded(score.least_clearance_m),
        "nearest_mover_m": rounded(score.nearest_mover_m),
        "position_rmse_m": rounded(score.position_rmse_m),
        "attitude_rmse_deg": rounded(score.attitude_rmse_deg),
        "contacts": tuple(contact.to_plain() for contact in score.contacts),
    }


def _has_navigated(score: FlightScore) -> bool:
    reached_s = score.reached_s
    # A contact on the way there is no clean navigation, even if the area was reached.
    return reached_s is not None and all(each.time_s >= reached_s for each in score.contacts)


def rounded(figure: float | None) -> float | None:
    """Round to a millimetre or a thousandth of a degree; None if there is no figure."""
    # JSON has no NaN, so that both become null.
    return None if figure is None or math.isnan(figure) else round(figure, 3)


def decisions(pilot: Pilot) -> dict[str, list[dict[str, Any]]]:
    """Return every change of phase and every new plan, with time and reason, as plain data."""
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
