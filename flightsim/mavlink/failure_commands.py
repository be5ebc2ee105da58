"""Failure injection: sensors and sticks that fall silent, and come back, at a client's command."""

from __future__ import annotations

from collections.abc import Mapping

from flightsim.autopilot.events import Severity
from flightsim.autopilot.results import ACCEPTED, Reply, denied, rejected
from flightsim.mavlink.commands import UNSUPPORTED, Command, Executor, choice
from flightsim.mavlink.dialect import dialect as mav
from flightsim.mavlink.statustext import StatustextSender
from flightsim.mavlink.view import VehicleView

_SENSORS = {
    mav.FAILURE_UNIT_SENSOR_MAG: "mag",
    mav.FAILURE_UNIT_SENSOR_BARO: "baro",
    mav.FAILURE_UNIT_SENSOR_GPS: "gnss",
    mav.FAILURE_UNIT_SENSOR_VIO: "vio",
    mav.FAILURE_UNIT_SENSOR_DISTANCE_SENSOR: "range",
    mav.FAILURE_UNIT_SENSOR_AIRSPEED: "airspeed",
}
_IS_WORKING = {mav.FAILURE_TYPE_OK: True, mav.FAILURE_TYPE_OFF: False}
_ONLY_INSTANCE = 1


class FailureCommands:
    """Executes MAV_CMD_INJECT_FAILURE where SYS_FAILURE_EN allows it; there is one of each part."""

    def __init__(self, view: VehicleView, statustext: StatustextSender) -> None:
        self._view = view
        self._statustext = statustext
        self.executors: Mapping[int, Executor] = {mav.MAV_CMD_INJECT_FAILURE: self._inject}

    def _inject(self, c: Command) -> Reply:
        if self._view.autopilot.parameters["SYS_FAILURE_EN"] != 1:
            return rejected("SYS_FAILURE_EN is 0; valid is 1")
        unit, kind = choice(c.param1), choice(c.param2)
        instance = choice(c.param3, default=0)
        if instance not in {0, _ONLY_INSTANCE}:
            return denied(f"instance {c.param3:g}; valid are 0 (all) and 1")
        if kind not in _IS_WORKING:
            return UNSUPPORTED
        is_working = _IS_WORKING[kind]
        if unit in _SENSORS:
            name = _SENSORS[unit]
            self._view.plant.set_sensor_enabled(name, is_enabled=is_working)
        elif unit == mav.FAILURE_UNIT_SYSTEM_RC_SIGNAL:
            name = "manual control"
            self._view.autopilot.set_sticks_heard(is_heard=is_working)
        else:
            return UNSUPPORTED
        word = "works again" if is_working else "fails"
        self._statustext.say(Severity.WARNING, f"Injected: {name} {word}")
        return ACCEPTED
