"""The states of our pilot, how long each may take, and what it reports of them."""

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
    RETURN = "return"
    DONE = "done"
    FAILED = "failed"


TIME_LIMIT_S: Mapping[Phase, float] = MappingProxyType(
    {
        Phase.CONNECT: 10.0,
        Phase.PREPARE: 60.0,
        Phase.ARM: 20.0,
        Phase.TAKEOFF: 30.0,
        Phase.NAVIGATE: 120.0,
        Phase.SEARCH: 20.0,
        Phase.ALIGN: 30.0,
        Phase.DESCEND: 40.0,
        Phase.TOUCHDOWN: 20.0,
        Phase.DISARM: 10.0,
        Phase.CLIMB: 30.0,
        Phase.RETURN: 5.0,
    }
)
"""Simulated seconds after which a phase has failed."""

IN_THE_AIR = frozenset(
    {
        Phase.TAKEOFF,
        Phase.NAVIGATE,
        Phase.SEARCH,
        Phase.ALIGN,
        Phase.DESCEND,
        Phase.TOUCHDOWN,
        Phase.CLIMB,
    }
)
"""Phases in which the pilot steers and the vehicle has to stay armed and in offboard mode."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Transition:
    """A change of phase."""

    time_us: int
    source: Phase
    target: Phase
    reason: str


@dataclass(frozen=True, kw_only=True, slots=True)
class PilotVerdict:
    """How a flight ended, as far as the pilot can know."""

    success: bool
    reason: str
    touchdown_error_m: float | None = None
    """Estimated resting place against the chosen point, horizontally."""
