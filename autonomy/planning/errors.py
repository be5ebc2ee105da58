"""Errors of planning; every message names the obstacle and the remedy.

A caller distinguishes them by type: another goal may help after `BlockedError`, waiting after
`EvasionError`, a slower flight after `LimitsError`.
"""

from __future__ import annotations


class PlanningError(ValueError):
    """No certified trajectory exists or could be found."""


class BlockedError(PlanningError):
    """Start or goal is in an obstacle, closer to one than the vehicle's radius, or off the map."""


class UnreachableError(PlanningError):
    """No free path joins start and goal.

    Attributes:
        narrowest_enu_m: Narrowest place of the widest path; None if none was sought or found.
    """

    def __init__(self, message: str, narrowest_enu_m: tuple[float, float, float] | None = None):
        """Create the error with its message and the narrowest place of the widest path."""
        super().__init__(message)
        self.narrowest_enu_m = narrowest_enu_m


class LimitsError(PlanningError):
    """The dynamic limits contradict themselves or the state at the start."""


class CertificateError(PlanningError):
    """A trajectory was found, but every attempt broke the clearance or a limit when checked."""


class EvasionError(PlanningError):
    """A moving obstacle is in the way, and no path around it could be proved."""
