"""Commands of the shell: a small part of PX4's, executed here without any program of the host."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from fnmatch import fnmatchcase

from flightsim.autopilot.modes import Mode
from flightsim.autopilot.parameters import ParameterError
from flightsim.autopilot.results import Reply
from flightsim.mavlink.view import VehicleView

_MOST_LINES = 400  # longest output: a client cannot make the vehicle send without end
_MODES = {mode.value.lower(): mode for mode in Mode if mode not in {Mode.DESCEND, Mode.TERMINATION}}


class ShellCommands:
    """Executes lines of a shell, one at a time, in the manner of PX4's console."""

    def __init__(self, view: VehicleView) -> None:
        self._view = view
        self._commands: Mapping[str, tuple[str, Callable[[Sequence[str]], str]]] = {
            "help": ("", self._help),
            "ver": ("all", self._ver),
            "param": ("show [PATTERN] | set NAME VALUE", self._param),
            "commander": (
                "status | check | arm [-f] | disarm [-f] | takeoff | land | mode NAME",
                self._commander,
            ),
            "listener": ("TOPIC", self._listener),
        }
        self._topics: Mapping[str, Callable[[], Mapping[str, object]]] = {
            "battery_status": self._battery_status,
            "home_position": self._home_position,
            "sensor_gps": self._sensor_gps,
            "vehicle_attitude": self._vehicle_attitude,
            "vehicle_local_position": self._vehicle_local_position,
            "vehicle_status": self._vehicle_status,
        }

    def run(self, line: str) -> str:
        """Return the output of a line, cut after `_MOST_LINES` lines.

        Args:
            line: The line as typed; an empty one has no output.
        """
        name, *words = line.split() or [""]
        if not name:
            return ""
        if name not in self._commands:
            # As PX4's shell answers; the name is cut, because the client chose it.
            return f"nsh: {name[:32]}: command not found"
        lines = self._commands[name][1](words).splitlines()
        if len(lines) > _MOST_LINES:
            lines = [*lines[:_MOST_LINES], f"... and {len(lines) - _MOST_LINES} more"]
        return "\n".join(lines)

    def _usage(self, name: str) -> str:
        return f"usage: {name} {self._commands[name][0]}"

    def _help(self, _: Sequence[str]) -> str:
        return "\n".join(f"{name} {how}".rstrip() for name, (how, _) in self._commands.items())

    def _ver(self, _: Sequence[str]) -> str:
        airframe = self._view.plant.world.airframe
        return f"HW arch: AEROSCENE_SITL\nVehicle: {airframe.title}\nPX4 version: 1.15.4 (imitated)"

    def _param(self, words: Sequence[str]) -> str:
        parameters = self._view.autopilot.parameters
        match words:
            case ["show"]:
                wanted = "*"
            case ["show", pattern]:
                wanted = pattern
            case ["set", name, value]:
                try:
                    return f"{name}: {parameters.set(name, float(value)):g}"
                except ParameterError as error:
                    return f"ERROR {error}"
                except ValueError:
                    return f"ERROR {value[:32]!r} is no number"
            case _:
                return self._usage("param")
        found = [name for name in parameters if fnmatchcase(name, wanted)]
        lines = (f"{name}: {parameters[name]:g}" for name in found)
        return "\n".join(lines) or f"ERROR no parameter is like {wanted[:32]!r}"

    def _commander(self, words: Sequence[str]) -> str:
        autopilot = self._view.autopilot
        if len(words) == 2 and words[0] == "mode":
            if words[1] in _MODES:
                return _told(autopilot.set_mode(_MODES[words[1]]))
            return f"valid modes are {', '.join(_MODES)}"
        actions: Mapping[str, Callable[[], str]] = {
            "status": self._status,
            "check": self._check,
            "arm": lambda: _told(autopilot.arm()),
            "arm -f": lambda: _told(autopilot.arm(is_forced=True)),
            "disarm": lambda: _told(autopilot.disarm()),
            "disarm -f": lambda: _told(autopilot.disarm(is_forced=True)),
            "takeoff": self._takeoff,
            "land": lambda: _told(autopilot.land()),
        }
        action = actions.get(" ".join(words))
        return self._usage("commander") if action is None else action()

    def _status(self) -> str:
        autopilot = self._view.autopilot
        word = "armed" if autopilot.is_armed else "disarmed"
        return f"{word}, mode {autopilot.mode.value}, {autopilot.landed_state.value}"

    def _check(self) -> str:
        reasons = self._view.autopilot.prearm.reasons
        return "\n".join(("FAILED", *reasons)) if reasons else "OK"

    def _takeoff(self) -> str:
        autopilot = self._view.autopilot
        # The mode first: arming checks depend on it.
        reply = autopilot.takeoff()
        return _told(autopilot.arm() if reply.is_accepted else reply)

    def _listener(self, words: Sequence[str]) -> str:
        if len(words) != 1 or words[0] not in self._topics:
            return f"{self._usage('listener')}; there are {', '.join(self._topics)}"
        values = self._topics[words[0]]()
        lines = (f"    {name}: {_written(value)}" for name, value in values.items())
        return "\n".join((f"TOPIC: {words[0]}", *lines))

    def _battery_status(self) -> Mapping[str, object]:
        battery = self._view.autopilot.battery
        return {
            "voltage_v": battery.voltage_v,
            "current_a": battery.current_a,
            "discharged_mah": battery.consumed_mah,
            "remaining": battery.remaining,
            "cell_count": battery.n_cells,
        }

    def _home_position(self) -> Mapping[str, object]:
        home = self._view.autopilot.home
        if home is None:
            return {"valid": False}
        place = home.geodetic
        return {"lat": place.latitude_deg, "lon": place.longitude_deg, "alt": place.altitude_m}

    def _sensor_gps(self) -> Mapping[str, object]:
        gnss = self._view.plant.sensors.gnss
        return {
            "timestamp": gnss.time_us,
            "fix_type": gnss.fix_type,
            "eph": gnss.eph_m,
            "epv": gnss.epv_m,
            "satellites_used": gnss.n_satellites,
        }

    def _vehicle_attitude(self) -> Mapping[str, object]:
        view = self._view
        degrees = [math.degrees(angle) for angle in view.rpy_rad]
        return {"timestamp": view.time_us, "q": view.quat_ned_frd, "rpy_deg": degrees}

    def _vehicle_local_position(self) -> Mapping[str, object]:
        view = self._view
        names = ("x", "y", "z", "vx", "vy", "vz")
        values = (*view.position_ned_m, *view.velocity_ned_mps)
        return {"timestamp": view.time_us, **dict(zip(names, values, strict=True))}

    def _vehicle_status(self) -> Mapping[str, object]:
        autopilot = self._view.autopilot
        reason = autopilot.failsafe
        return {
            "armed": autopilot.is_armed,
            "mode": autopilot.mode.value,
            "system_state": autopilot.system_state.value,
            "failsafe": "none" if reason is None else reason.value,
        }


def _told(reply: Reply) -> str:
    return reply.result.value if reply.is_accepted else f"{reply.result.value}: {reply.reason}"


def _written(value: object) -> str:
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(map(_written, value))}]"
    return f"{value:.7g}" if isinstance(value, float) else str(value)
