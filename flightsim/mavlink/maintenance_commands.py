"""Maintenance on the ground: calibration, reboot, and why there is no autotune.

The sensors come calibrated, so a calibration at rest ends as soon as it has begun, in PX4's words,
which SDKs read. A calibration for which the vehicle must be turned by hand is impossible here and
is denied.
"""

from __future__ import annotations

from collections.abc import Mapping

from flightsim.autopilot.events import Severity
from flightsim.autopilot.modes import LandedState
from flightsim.autopilot.results import ACCEPTED, CommandResult, Reply, denied, rejected
from flightsim.mavlink.commands import UNSUPPORTED, Command, Executor, choice
from flightsim.mavlink.dialect import dialect as mav
from flightsim.mavlink.statustext import StatustextSender
from flightsim.mavlink.view import VehicleView

_AT_REST = {
    (1, 1): "gyro",
    (3, 1): "baro",
    (5, 2): "level",
    (5, 4): "accel",
    (6, 1): "airspeed",
}
"""Sensors that are calibrated at rest, by parameter and value of MAV_CMD_PREFLIGHT_CALIBRATION."""
_BY_HAND = {(2, 1): "mag", (5, 1): "accel"}
"""Sensors for whose calibration the vehicle has to be turned to all sides."""
_DONE_PERCENT = (0, 50, 100)  # SDKs show a progress bar
_NO_CHOICE = -1
# As of PX4 without its module, and of ArduCopter, where autotune is a mode.
_NO_AUTOTUNE = Reply(
    CommandResult.UNSUPPORTED, "gains follow from mass, inertia and motors: nothing to tune"
)
_REBOOT = 1


class MaintenanceCommands:
    """Executes commands of maintenance, which an armed vehicle refuses.

    Our sensors need no calibration. One at rest is accepted and reported as done; one by hand is
    denied.
    """

    def __init__(self, view: VehicleView, statustext: StatustextSender) -> None:
        self._autopilot = view.autopilot
        self._statustext = statustext
        self.executors: Mapping[int, Executor] = {
            mav.MAV_CMD_PREFLIGHT_CALIBRATION: self._calibrate,
            mav.MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN: self._reboot,
            mav.MAV_CMD_DO_AUTOTUNE_ENABLE: lambda _: _NO_AUTOTUNE,
        }

    def _calibrate(self, c: Command) -> Reply:
        values = (c.param1, c.param2, c.param3, c.param4, c.x, c.y, c.z)
        asked = {
            (number, _NO_CHOICE if chosen is None else chosen)
            for number, value in enumerate(values, start=1)
            if (chosen := choice(value, default=0)) != 0
        }
        # All parameters 0 is MAVLink's cancellation.
        if not asked:
            self._statustext.broadcast(Severity.INFO, "[cal] calibration cancelled")
            return ACCEPTED
        if not asked <= _AT_REST.keys() | _BY_HAND.keys():
            return UNSUPPORTED
        if self._autopilot.is_armed:
            return rejected("the vehicle is armed")
        if by_hand := sorted(asked & _BY_HAND.keys()):
            name = _BY_HAND[by_hand[0]]
            return denied(f"calibration of {name} wants the vehicle turned by hand; it needs none")
        if self._autopilot.landed_state is not LandedState.ON_GROUND:
            return rejected("the vehicle is not at rest")
        for what in sorted(asked & _AT_REST.keys()):
            self._report(_AT_REST[what])
        return ACCEPTED

    def _report(self, name: str) -> None:
        """Report a calibration from its beginning to its end."""
        broadcast = self._statustext.broadcast
        broadcast(Severity.INFO, f"[cal] calibration started: 2 {name}")
        for percent in _DONE_PERCENT:
            broadcast(Severity.INFO, f"[cal] progress <{percent}>")
        broadcast(Severity.INFO, f"[cal] calibration done: {name}")

    def _reboot(self, c: Command) -> Reply:
        """Restart the autopilot; the testbench itself ends only where it was started."""
        if choice(c.param1, default=0) == 0 and choice(c.param2, default=0) == 0:
            return ACCEPTED  # nothing is asked for
        if choice(c.param1) != _REBOOT:
            return UNSUPPORTED
        return self._autopilot.restart()
