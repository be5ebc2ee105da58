"""Failure injection: sensors, motors, battery and links that fail at a client's command."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial

from flightsim.autopilot.battery_monitor import BATTERY_FAILURES
from flightsim.autopilot.events import Severity
from flightsim.autopilot.results import ACCEPTED, Reply, denied
from flightsim.autopilot.streams import DatalinkWatch, StickStream
from flightsim.mavlink.commands import UNSUPPORTED, Command, Executor, choice
from flightsim.mavlink.dialect import dialect as mav
from flightsim.mavlink.statustext import StatustextSender
from flightsim.mavlink.view import VehicleView
from flightsim.plant.failures import ROTOR_FAILURES
from flightsim.sensors.failure import Failure
from flightsim.sensors.optical_flow import OPTICAL_FLOW

_SENSORS = {
    mav.FAILURE_UNIT_SENSOR_GYRO: "gyroscope",
    mav.FAILURE_UNIT_SENSOR_ACCEL: "accelerometer",
    mav.FAILURE_UNIT_SENSOR_MAG: "mag",
    mav.FAILURE_UNIT_SENSOR_BARO: "baro",
    mav.FAILURE_UNIT_SENSOR_GPS: "gnss",
    mav.FAILURE_UNIT_SENSOR_VIO: "vio",
    mav.FAILURE_UNIT_SENSOR_DISTANCE_SENSOR: "range",
    mav.FAILURE_UNIT_SENSOR_AIRSPEED: "airspeed",
    mav.FAILURE_UNIT_SENSOR_OPTICAL_FLOW: "optical_flow",
}
_LINK_FAILURES = frozenset({Failure.NONE, Failure.OFF})
_ANY = frozenset(Failure)
_ALL = 0
Unit = tuple[frozenset[Failure], Callable[[Failure], None]]
"""Kinds of failure that a part can have, and the function that makes it fail."""


class FailureCommands:
    """Executes MAV_CMD_INJECT_FAILURE if SYS_FAILURE_EN allows it, as in PX4.

    Sensors, motors, the battery and links can fail, each instance in the ways that its part has.
    """

    def __init__(self, view: VehicleView, statustext: StatustextSender) -> None:
        self._view = view
        self._statustext = statustext
        self._units = self._parts()
        self.executors: Mapping[int, Executor] = {mav.MAV_CMD_INJECT_FAILURE: self._inject}

    def _parts(self) -> Mapping[int, tuple[str, tuple[Unit, ...]]]:
        """Return name and instances of each FAILURE_UNIT that the vehicle has."""
        plant, autopilot = self._view.plant, self._view.autopilot
        motors = plant.world.airframe.motors
        return {
            **{
                unit: (name, ((_ANY, partial(plant.failures.fail_sensor, name)),))
                for unit, name in _SENSORS.items()
                if name != OPTICAL_FLOW.name or plant.cfg.has(name)
            },
            mav.FAILURE_UNIT_SYSTEM_MOTOR: (
                "motor",
                tuple(
                    (ROTOR_FAILURES, partial(plant.failures.fail_rotor, rotor)) for rotor in motors
                ),
            ),
            mav.FAILURE_UNIT_SYSTEM_BATTERY: (
                "battery",
                ((BATTERY_FAILURES, partial(setattr, autopilot.battery_monitor, "failure")),),
            ),
            mav.FAILURE_UNIT_SYSTEM_RC_SIGNAL: (
                "manual control",
                ((_LINK_FAILURES, partial(_silence, autopilot.sticks)),),
            ),
            mav.FAILURE_UNIT_SYSTEM_MAVLINK_SIGNAL: (
                "ground station",
                ((_LINK_FAILURES, partial(_silence, autopilot.datalink)),),
            ),
        }

    def _inject(self, c: Command) -> Reply:
        if self._view.autopilot.parameters["SYS_FAILURE_EN"] != 1:
            return denied("SYS_FAILURE_EN is 0; valid is 1")
        unit, kind = choice(c.param1), choice(c.param2)
        instance = choice(c.param3, default=_ALL)
        if unit is None or unit not in self._units or kind is None or kind not in _ANY:
            return UNSUPPORTED
        name, instances = self._units[unit]
        failure = Failure(kind)
        # Instances count from 1; 0 means all.
        if instance is None or not _ALL <= instance <= len(instances):
            return denied(f"instance {c.param3:g}; valid are 0 (all) to {len(instances)}")
        chosen = instances if instance == _ALL else instances[instance - 1 : instance]
        # Checked for all chosen instances before the first fails, so that a refusal changes
        # nothing.
        if any(failure not in kinds for kinds, _ in chosen):
            return UNSUPPORTED
        for _, fail in chosen:
            fail(failure)
        title = f"{name} {instance}" if instance != _ALL and len(instances) > 1 else name
        word = "works again" if failure is Failure.NONE else f"fails ({failure.name.lower()})"
        self._statustext.broadcast(Severity.WARNING, f"Injected: {title} {word}")
        return ACCEPTED


def _silence(stream: StickStream | DatalinkWatch, failure: Failure) -> None:
    stream.is_heard = failure is Failure.NONE
