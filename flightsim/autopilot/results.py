"""How the autopilot answers a request."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum, unique


@unique
class CommandResult(Enum):
    """Outcome of a request, in the vocabulary that every ground station shares."""

    ACCEPTED = "accepted"
    TEMPORARILY_REJECTED = "temporarily rejected"
    """Valid, but not in the present state; asking again later may work."""
    DENIED = "denied"
    """Never valid with these values."""
    UNSUPPORTED = "unsupported"
    FAILED = "failed"
    IN_PROGRESS = "in progress"


@dataclass(frozen=True, slots=True)
class Reply:
    """A result and, unless it is `ACCEPTED`, one line that says why."""

    result: CommandResult
    reason: str = ""

    @property
    def is_accepted(self) -> bool:
        """Whether the request was taken."""
        return self.result is CommandResult.ACCEPTED


ACCEPTED = Reply(CommandResult.ACCEPTED)


def rejected(reason: str) -> Reply:
    """Valid, but not now."""
    return Reply(CommandResult.TEMPORARILY_REJECTED, reason)


def denied(reason: str) -> Reply:
    """Not with these values."""
    return Reply(CommandResult.DENIED, reason)
