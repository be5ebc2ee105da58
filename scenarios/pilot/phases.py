"""Phases of our pilot and all transitions between them, in one table.

A table can be read, drawn (docs/pilot.md does) and enforced, whereas transitions spread over the
actions could not. `Transition` refuses any change that the table does not have.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from types import MappingProxyType


class Phase(Enum):
    """Activity of the pilot."""

    CONNECT = "connect"
    PREPARE = "wait for health"
    ARM = "arm"
    TAKEOFF = "take off"
    NAVIGATE = "navigate"
    SEARCH = "search"
    ALIGN = "align"
    DESCEND = "descend"
    TOUCHDOWN = "touch down"
    DISARM = "disarm"
    CLIMB = "climb"
    HOLD = "hold"
    RETURN = "return"
    LAND_HOME = "land at home"
    HAND_OVER = "hand over"
    DONE = "done"
    FAILED = "failed"


_P = Phase
_WAYS_OUT = frozenset({_P.HOLD, _P.RETURN, _P.HAND_OVER, _P.FAILED})
"""Exits of every phase in the air: wait, go home, hand over to the autopilot, or fail."""

TRANSITIONS: Mapping[Phase, frozenset[Phase]] = MappingProxyType(
    {
        # On the ground
        _P.CONNECT: frozenset({_P.PREPARE, _P.FAILED}),
        _P.PREPARE: frozenset({_P.ARM, _P.FAILED}),
        _P.ARM: frozenset({_P.TAKEOFF, _P.DISARM, _P.FAILED}),
        # Navigation
        _P.TAKEOFF: frozenset({_P.NAVIGATE}) | _WAYS_OUT,
        _P.NAVIGATE: frozenset({_P.SEARCH}) | _WAYS_OUT,
        # Interaction; NAVIGATE leads on to the next area
        _P.SEARCH: frozenset({_P.ALIGN, _P.DESCEND, _P.NAVIGATE}) | _WAYS_OUT,
        _P.ALIGN: frozenset({_P.DESCEND, _P.SEARCH, _P.NAVIGATE}) | _WAYS_OUT,
        _P.DESCEND: frozenset({_P.TOUCHDOWN, _P.CLIMB}) | _WAYS_OUT,
        _P.TOUCHDOWN: frozenset({_P.DISARM, _P.CLIMB}) | _WAYS_OUT,
        _P.CLIMB: frozenset({_P.SEARCH, _P.NAVIGATE}) | _WAYS_OUT,
        # When something is in the way
        _P.HOLD: frozenset({_P.NAVIGATE, _P.CLIMB}) | _WAYS_OUT - {_P.HOLD},
        _P.RETURN: frozenset({_P.LAND_HOME}) | _WAYS_OUT - {_P.RETURN},
        _P.LAND_HOME: frozenset({_P.DISARM}) | _WAYS_OUT,
        # The end
        _P.DISARM: frozenset({_P.DONE, _P.FAILED}),
        _P.HAND_OVER: frozenset({_P.FAILED}),
        _P.DONE: frozenset(),
        _P.FAILED: frozenset(),
    }
)
"""Allowed successors of each phase; anything else raises `TransitionError`."""

TIME_LIMIT_S: Mapping[Phase, float] = MappingProxyType(
    {
        _P.CONNECT: 10.0,
        _P.PREPARE: 150.0,
        _P.ARM: 60.0,
        _P.TAKEOFF: 45.0,
        _P.NAVIGATE: 120.0,
        _P.SEARCH: 20.0,
        _P.ALIGN: 30.0,
        _P.DESCEND: 40.0,
        _P.TOUCHDOWN: 20.0,
        _P.DISARM: 10.0,
        _P.CLIMB: 30.0,
        _P.HOLD: 20.0,
        _P.RETURN: 120.0,
        _P.LAND_HOME: 40.0,
        _P.HAND_OVER: 5.0,
    }
)
"""Simulated seconds after which a phase fails."""

# Phases on the ground have neither of these two exits.
IN_THE_AIR = frozenset(
    phase for phase, targets in TRANSITIONS.items() if targets & {_P.RETURN, _P.HOLD}
)
"""Phases in which the pilot steers and the vehicle must stay armed and in offboard mode."""

FOLLOWS = IN_THE_AIR - {Phase.TOUCHDOWN, Phase.LAND_HOME}
"""Phases in which the vehicle's deviation shows how well it follows. Near the ground other effects
add to it."""

ON_THE_WAY = frozenset({_P.NAVIGATE, _P.RETURN})
"""Phases that fly a plan through the map, which can be replanned from any of its points."""

LOOKS_AROUND = frozenset({Phase.TAKEOFF, Phase.NAVIGATE, Phase.HOLD, Phase.CLIMB, Phase.RETURN})
"""Phases that may turn to look out for movers; the others look down at one place."""

Step = tuple[Phase, str] | None
"""The next phase with the reason; None to stay."""


class TransitionError(RuntimeError):
    """The table does not have this change of phase: a defect of the pilot."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Transition:
    """A change of phase."""

    time_us: int
    source: Phase
    target: Phase
    reason: str

    def __post_init__(self) -> None:
        """Refuse a change that the table does not have.

        Raises:
            TransitionError: Naming both phases and the allowed successors.
        """
        valid = TRANSITIONS[self.source]
        if self.target not in valid:
            raise TransitionError(
                f"phase {self.target.value} does not follow {self.source.value}; "
                f"valid: {', '.join(sorted(phase.value for phase in valid)) or 'none'}"
            )


@dataclass(frozen=True, kw_only=True, slots=True)
class Replan:
    """A replacement of the plan without a change of phase."""

    time_us: int
    reason: str


@dataclass(frozen=True, kw_only=True, slots=True)
class PilotVerdict:
    """Outcome of a flight, as far as the pilot can know it.

    The judged outcome comes from the true history instead; see `scenarios.trials.verdict`.
    """

    success: bool
    reason: str
    touchdown_error_m: float | None = None
    """Horizontal distance of the estimated resting place from the chosen point."""
