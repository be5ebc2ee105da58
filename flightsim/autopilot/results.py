"""Results of requests to the autopilot."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum, unique


@unique
class CommandResult(Enum):
    """Outcome of a request, in MAVLink's vocabulary of results."""

    ACCEPTED = "accepted"
    TEMPORARILY_REJECTED = "temporarily rejected"
    """Valid, but not in the present state; a later request may succeed."""
    DENIED = "denied"
    """Never valid with these values."""
    UNSUPPORTED = "unsupported"
    FAILED = "failed"
    IN_PROGRESS = "in progress"


@dataclass(frozen=True, slots=True)
class Reply:
    """A result and, unless it is `ACCEPTED`, one line with the reason."""

    result: CommandResult
    reason: str = ""

    @property
    def is_accepted(self) -> bool:
        """True if the request was accepted."""
        return self.result is CommandResult.ACCEPTED


ACCEPTED = Reply(CommandResult.ACCEPTED)


def rejected(reason: str) -> Reply:
    """Reply to a request that is valid, but not in the present state."""
    return Reply(CommandResult.TEMPORARILY_REJECTED, reason)


def denied(reason: str) -> Reply:
    """Reply to a request with values that are never valid."""
    return Reply(CommandResult.DENIED, reason)
