"""A user's class as a pilot: what it raises is told apart from the testbench's own errors."""

from __future__ import annotations

from aeroscene.scene import InteractionArea
from flightsim.sensors.cameras import CameraError
from scenarios.baselines.named import MakePilot
from scenarios.run.companion import Aboard
from scenarios.trials.verdict import Word


class PilotFaultError(Exception):
    """A pilot has raised the cause of this."""


class UserPilot:
    """A `scenarios.Companion` around another one."""

    def __init__(self, make: MakePilot, aboard: Aboard) -> None:
        """Make the pilot.

        Raises:
            PilotFaultError: If it raises anything.
            CameraError: If it looks, and this machine has no camera.
        """
        try:
            self._pilot = make(aboard)
        except CameraError:
            raise
        except (Exception, SystemExit) as error:
            raise PilotFaultError from error

    @property
    def area(self) -> InteractionArea | None:
        """Area that it wants to land on."""
        return self._pilot.area

    @property
    def is_done(self) -> bool:
        """Whether it says that the flight is over."""
        return self._pilot.is_done

    @property
    def verdict(self) -> Word:
        """What it says of the flight."""
        return self._pilot.verdict

    def update(self, time_us: int) -> None:
        """Let it decide and send.

        Raises:
            PilotFaultError: If it raises anything.
            CameraError: If it looks, and this machine has no camera.
        """
        try:
            self._pilot.update(time_us)
        except CameraError:
            raise
        except (Exception, SystemExit) as error:
            raise PilotFaultError from error
