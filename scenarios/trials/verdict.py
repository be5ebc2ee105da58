"""The verdict on a flight: a code of a fixed set, by the truth alone.

A pilot's own word decides only if it wanted no landing; otherwise it only explains why there was
none. Objections are ordered from causes to consequences, because the first one gives the code: a
vehicle that hit a wall and fell over has touched the wall.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from enum import StrEnum
from itertools import chain
from typing import Protocol

from aeroscene.scene import InteractionArea
from scenarios.trials.contacts import Contact
from scenarios.trials.figures import Goal
from scenarios.trials.limits import LIMITS
from scenarios.trials.score import AnyScore


class Code(StrEnum):
    """Outcome of a run, for programs; docs/verdict.md explains each."""

    LANDED = "landed"
    """On the assigned area, within every limit."""
    DONE = "done"
    """A pilot that wanted no landing reports that it is done."""
    ENDED = "ended"
    """Nobody flew: nothing is to be judged."""

    STOPPED = "stopped"
    """A signal ended the run before the pilot was done."""
    NEVER_FLEW = "never_flew"
    CONTACT = "contact"
    """The vehicle touched something before touchdown."""
    NEAR_MISS = "near_miss"
    """A mover came too near in flight."""
    FELL_OVER = "fell_over"
    TIME_UP = "time_up"
    """The time was up before it had landed."""
    GAVE_UP = "gave_up"
    """The pilot ended the flight elsewhere, or in the air, and gave a reason."""
    ALTERNATE = "alternate"
    """On another area than the assigned one."""
    OUTSIDE_AREA = "outside_area"
    """Not all soles on any area."""
    MOVING = "moving"
    """Not at rest in the end."""
    ROTORS_TURN = "rotors_turn"
    """The rotors never stopped."""
    SPUN_UP = "spun_up"
    """The rotors took the weight again after the touchdown."""
    HARD_TOUCHDOWN = "hard_touchdown"
    SLID = "slid"
    OFF_TARGET = "off_target"
    """On the area, but too far from the chosen point."""
    TOO_SLOW = "too_slow"
    """Landed, but later above its area than the task allows."""


class Fate(StrEnum):
    """State in which a flight left the vehicle, whatever its task was."""

    SAFE_DOWN = "safe_down"
    """At rest and upright, after a soft touchdown and no contact before it."""
    COLLIDED = "collided"
    """It hit something: an object on the way, or the ground too hard or tilted."""
    LOST = "lost"
    """It never came to rest."""


SUCCESSES = frozenset({Code.LANDED, Code.DONE})


@dataclass(frozen=True, slots=True)
class Verdict:
    """A pilot's own statement on its flight."""

    success: bool
    reason: str


class Word(Protocol):
    """Interface of any pilot's statement on its flight."""

    @property
    def success(self) -> bool:
        """True if the pilot did what it wanted."""
        ...

    @property
    def reason(self) -> str:
        """Reason for success or failure, in words."""
        ...


@dataclass(frozen=True, kw_only=True, slots=True)
class Ending:
    """End of a run, besides what the truth shows."""

    word: Word
    """The pilot's own statement."""
    is_done: bool
    """True if the pilot was done."""
    stopped_by: str | None = None
    """Cause that ended the run before that, such as SIGTERM."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Judgement:
    """Code and words of a verdict."""

    code: Code
    reason: str
    fate: Fate | None = None
    """None if it never left the ground, or if nothing was to be judged."""

    @property
    def success(self) -> bool | None:
        """True if the flight counts as done; None if nothing was to be judged."""
        return None if self.code is Code.ENDED else self.code in SUCCESSES


_Objection = tuple[bool, Code, str]


def judge(score: AnyScore, goal: Goal, ending: Ending) -> Judgement:
    """Judge a flight: the first objection decides, and nothing is measured for those after it.

    Args:
        score: Figures of the flight, measured already or on demand.
        goal: Place where it should have ended; without an area the pilot's own statement decides.
        ending: End of the run.
    """
    if goal.area is None:
        objections = chain(
            _to_any_flight(score, ending),
            _to_the_rest(score),
            _to_contacts(score, goal),
            _to_a_word(ending),
        )
        code, reason = Code.DONE, ending.word.reason
    else:
        objections = chain(
            _to_any_flight(score, ending),
            # A collision before a fall: the fall is what followed it.
            _to_the_way(score),
            _to_the_rest(score),
            _to_movers(score),
            _to_the_place(score, goal.area, ending),
            _to_the_touchdown(score),
            _to_the_pace(score, goal),
        )
        error_m = score.touchdown_error_m or 0.0
        code = Code.LANDED
        reason = f"landed on area {goal.area.id}, {error_m:.2f} m from the chosen point"
    found = ((code, reason) for applies, code, reason in objections if applies)
    code, reason = next(found, (code, reason))
    word = ending.word
    # Only a reason that is not quoted already is appended.
    if code not in SUCCESSES and ending.is_done and not word.success and word.reason not in reason:
        reason = f"{reason}; the pilot gave up: {word.reason}"
    return Judgement(code=code, reason=reason, fate=fate_of(score, goal))


def fate_of(score: AnyScore, goal: Goal) -> Fate | None:
    """Return the state in which a flight left the vehicle; None if it never left the ground."""
    if not score.has_flown:
        return None
    # A flight without an area may touch things on purpose.
    # The fate is about the vehicle, so a collision counts before a soft landing after it.
    has_hit = goal.area is not None and score.contacts_before_touchdown > 0
    if has_hit:
        return Fate.COLLIDED
    if not score.is_down:
        return Fate.LOST
    is_tilted = score.tilt_at_rest_deg > LIMITS.tilt_deg
    if is_tilted or (score.touchdown_speed_mps or 0.0) > LIMITS.touchdown_speed_mps:
        return Fate.COLLIDED
    return Fate.SAFE_DOWN if score.is_at_rest else Fate.LOST


def _to_any_flight(score: AnyScore, ending: Ending) -> Iterator[_Objection]:
    word = ending.word.reason
    is_stopped = ending.stopped_by is not None and not ending.is_done
    yield is_stopped, Code.STOPPED, f"stopped by {ending.stopped_by}: {word}"
    why = "" if ending.word.success else f": {word}"
    is_grounded = ending.is_done and not score.has_flown
    yield is_grounded, Code.NEVER_FLEW, f"never left the ground{why}"


def _to_the_rest(score: AnyScore) -> Iterator[_Objection]:
    # At rest on its side, whatever the reason.
    has_fallen = score.is_down and score.tilt_at_rest_deg > LIMITS.tilt_deg
    yield has_fallen, Code.FELL_OVER, f"fell over: {score.tilt_at_rest_deg:.0f} degrees at rest"


def _to_contacts(score: AnyScore, goal: Goal) -> Iterator[_Objection]:
    """Objections to contacts of a flight that wants no landing."""
    touched = goal.stays_up and (score.is_down or score.contacts_before_touchdown > 0)
    yield touched, Code.CONTACT, "touched something"


def _to_a_word(ending: Ending) -> Iterator[_Objection]:
    """Objections of a pilot that wanted no landing: its own."""
    yield not ending.is_done, Code.TIME_UP, f"the time was up: {ending.word.reason}"
    yield not ending.word.success, Code.GAVE_UP, ending.word.reason


def _to_the_way(score: AnyScore) -> Iterator[_Objection]:
    touched = ", ".join(_in_words(contact) for contact in score.touched_before) or "something"
    n = score.contacts_before_touchdown
    yield n > 0, Code.CONTACT, f"touched {touched} before touchdown"


def _to_movers(score: AnyScore) -> Iterator[_Objection]:
    gap_m = math.inf if score.nearest_mover_m is None else score.nearest_mover_m
    yield gap_m < LIMITS.mover_m, Code.NEAR_MISS, f"something that moves came within {gap_m:.2f} m"


def _in_words(contact: Contact) -> str:
    """Describe a contact: object, time and speed."""
    return f"{contact.what} at {contact.time_s:.1f} s and {contact.speed_mps:.1f} m/s"


def _to_the_place(score: AnyScore, area: InteractionArea, ending: Ending) -> Iterator[_Objection]:
    word, n = ending.word.reason, score.n_soles_inside
    is_there = score.landed_area == area.id
    # The order matters: time, then the pilot's reason, then where the soles stand.
    yield not is_there and not ending.is_done, Code.TIME_UP, f"the time was up: {word}"
    # A pilot that is done in the air has given up, whatever it reports.
    gave_up = not score.is_down or not ending.word.success
    yield not is_there and gave_up, Code.GAVE_UP, word
    is_elsewhere = not is_there and score.landed_area is not None
    elsewhere = f"landed on area {score.landed_area} instead of {area.id}"
    yield is_elsewhere, Code.ALTERNATE, elsewhere
    yield (
        not is_there,
        Code.OUTSIDE_AREA,
        f"came to rest with {n} of {score.n_soles} soles inside",
    )


def _to_the_pace(score: AnyScore, goal: Goal) -> Iterator[_Objection]:
    """Objection to a path that took too long; the last one, because all others are worse."""
    most_s, reached_s, lift_off_s = goal.navigation_limit_s, score.reached_s, score.lift_off_s
    if most_s is None or reached_s is None or lift_off_s is None:
        return
    took_s = reached_s - lift_off_s
    says = f"came above its area after {took_s:.1f} s; at most {most_s:.1f} s are allowed"
    yield took_s > most_s, Code.TOO_SLOW, says


def _to_the_touchdown(score: AnyScore) -> Iterator[_Objection]:
    yield not score.is_at_rest, Code.MOVING, "the vehicle still moves"
    yield score.stopped_after_s is None, Code.ROTORS_TURN, "the rotors still turn"
    n = score.rotor_spin_ups
    yield n > 0, Code.SPUN_UP, f"the rotors spun up again {n} times after the touchdown"
    for figure, most, code, says in (
        (
            score.touchdown_speed_mps,
            LIMITS.touchdown_speed_mps,
            Code.HARD_TOUCHDOWN,
            "touched down at {:.2f} m/s",
        ),
        (score.slide_m, LIMITS.slide_m, Code.SLID, "slid {:.2f} m after the touchdown"),
        (
            score.touchdown_error_m,
            LIMITS.touchdown_error_m,
            Code.OFF_TARGET,
            "came to rest {:.2f} m from the chosen point",
        ),
    ):
        # A figure that was not measured breaks no limit.
        value = figure or 0.0
        yield value > most, code, f"{says.format(value)}; at most {most} are allowed"
