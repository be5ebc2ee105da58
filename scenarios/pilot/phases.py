"""The states of our pilot and every change between them, in one table.

docs/pilot.md draws it. `Transition` refuses what is not in it: no change is made in passing.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from types import MappingProxyType


class Phase(Enum):
    """What the pilot is doing."""

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
"""Of every phase in the air: wait, go home, let the autopilot do it, or it is over already."""

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
        _P.SEARCH: frozenset({_P.ALIGN, _P.NAVIGATE}) | _WAYS_OUT,
        _P.ALIGN: frozenset({_P.DESCEND, _P.NAVIGATE}) | _WAYS_OUT,
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
"""Where each phase may lead."""

TIME_LIMIT_S: Mapping[Phase, float] = MappingProxyType(
    {
        _P.CONNECT: 10.0,
        _P.PREPARE: 60.0,
        _P.ARM: 20.0,
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
"""Simulated seconds after which a phase has failed."""

IN_THE_AIR = frozenset(
    phase for phase, targets in TRANSITIONS.items() if targets & {_P.RETURN, _P.HOLD}
)
"""Phases in which the pilot steers and the vehicle has to stay armed and in offboard mode."""

ON_THE_WAY = frozenset({_P.NAVIGATE, _P.RETURN})
"""Phases that fly a plan through the map, which can be made anew from any point of it."""

LOOKS_AROUND = frozenset({Phase.TAKEOFF, Phase.NAVIGATE, Phase.HOLD, Phase.CLIMB, Phase.RETURN})
"""Phases that may turn to look out for what moves; the others look down on one place."""

Step = tuple[Phase, str] | None
"""The next phase and why; None to stay."""


class TransitionError(RuntimeError):
    """A change of phase that the table does not have."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Transition:
    """A change of phase."""

    time_us: int
    source: Phase
    target: Phase
    reason: str

    def __post_init__(self) -> None:
        """Refuse what the table does not have.

        Raises:
            TransitionError: Naming both phases and what may follow.
        """
        valid = TRANSITIONS[self.source]
        if self.target not in valid:
            raise TransitionError(
                f"phase {self.target.value} does not follow {self.source.value}; "
                f"valid: {', '.join(sorted(phase.value for phase in valid)) or 'none'}"
            )


@dataclass(frozen=True, kw_only=True, slots=True)
class Replan:
    """A plan that was made anew without a change of phase."""

    time_us: int
    reason: str


@dataclass(frozen=True, kw_only=True, slots=True)
class PilotVerdict:
    """How a flight ended, as far as the pilot can know."""

    success: bool
    reason: str
    touchdown_error_m: float | None = None
    """Estimated resting place against the chosen point, horizontally."""
