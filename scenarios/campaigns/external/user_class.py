"""A user's class as a pilot: its errors are distinguished from the testbench's own.

An error of the testbench ends a campaign, an error of a pilot only its trial.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from numpy.typing import ArrayLike

from aeroscene.scene import InteractionArea
from autonomy.types import Vector3
from flightsim.cameras import CameraError
from scenarios.baselines.named import MakePilot
from scenarios.run.companion import Aboard, Companion
from scenarios.trials.verdict import Word


class PilotFaultError(Exception):
    """A pilot has raised the cause of this."""


class UserPilot:
    """A `scenarios.Companion` around another one.

    Errors of the inner one become the cause of a `PilotFaultError`, except a `CameraError`: that
    means that this machine has no camera to look through.
    """

    def __init__(self, make: MakePilot, aboard: Aboard) -> None:
        self._pilot: Companion = _blaming(make, aboard)

    @property
    def area(self) -> InteractionArea | None:
        """Area that it wants to land on."""
        return _blaming(getattr, self._pilot, "area")

    @property
    def is_done(self) -> bool:
        """True if it reports that the flight is over."""
        return _blaming(getattr, self._pilot, "is_done")

    @property
    def verdict(self) -> Word:
        """Its own statement on the flight."""
        return _blaming(getattr, self._pilot, "verdict")

    @property
    def planned_enu_m(self) -> ArrayLike | None:
        """Path that it plans to fly, if it gives one."""
        return _blaming(getattr, self._pilot, "planned_enu_m", None)

    @property
    def touchdown_enu_m(self) -> Vector3 | None:
        """Point that it chose to land on, if it gives one."""
        return _blaming(lambda: _point(getattr(self._pilot, "touchdown_enu_m", None)))

    def update(self, time_us: int) -> None:
        """Let it decide and send."""
        _blaming(self._pilot.update, time_us)


def _point(given: Any) -> Vector3 | None:
    """Return a point as a pilot gives it.

    Raises:
        ValueError: If it is not three finite numbers.
    """
    if given is None:
        return None
    x, y, z = (float(c) for c in given)
    if not math.isfinite(x + y + z):
        raise ValueError(f"touchdown_enu_m {given!r} is not valid; valid: three finite numbers, m")
    return (x, y, z)


def _blaming(function: Callable[..., Any], *arguments: Any) -> Any:
    try:
        return function(*arguments)
    # The machine's fault, not the pilot's.
    except CameraError:
        raise
    # A pilot that calls `sys.exit` must not end the campaign.
    except (Exception, SystemExit) as error:
        raise PilotFaultError from error
