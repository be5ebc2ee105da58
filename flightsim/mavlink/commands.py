"""Command protocol: executes COMMAND_LONG and COMMAND_INT, and acknowledges every one.

https://mavlink.io/en/services/command.html. Handlers are in the `*_commands.py` modules, by
subject. Both messages become one `Command`, so that no handler asks which one came. A command
without an answer would cost a client its whole timeout, so unknown ones are acknowledged too.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from flightsim.autopilot.events import Severity
from flightsim.autopilot.mission_item import FRAME_GLOBAL, GEODETIC_FRAMES
from flightsim.autopilot.results import CommandResult, Reply, denied
from flightsim.mavlink.channel import Channel
from flightsim.mavlink.dialect import dialect as mav
from flightsim.mavlink.mission_items import coordinate_from_int
from flightsim.mavlink.parsing import Message
from flightsim.mavlink.service import Handler, send
from flightsim.mavlink.statustext import StatustextSender

RESULTS = {
    CommandResult.ACCEPTED: mav.MAV_RESULT_ACCEPTED,
    CommandResult.TEMPORARILY_REJECTED: mav.MAV_RESULT_TEMPORARILY_REJECTED,
    CommandResult.DENIED: mav.MAV_RESULT_DENIED,
    CommandResult.UNSUPPORTED: mav.MAV_RESULT_UNSUPPORTED,
    CommandResult.FAILED: mav.MAV_RESULT_FAILED,
    CommandResult.IN_PROGRESS: mav.MAV_RESULT_IN_PROGRESS,
}
"""Value of MAV_RESULT for each outcome."""
_PROGRESS_UNKNOWN = 255
UNSUPPORTED = Reply(CommandResult.UNSUPPORTED)


@dataclass(frozen=True, slots=True)
class Order:
    """Number and parameters of a command, from a message or a mission item; NaN is "not given"."""

    number: int
    """Value of MAV_CMD."""
    frame: int
    """MAV_FRAME of the place; GLOBAL for COMMAND_LONG."""
    param1: float
    param2: float
    param3: float
    param4: float
    x: float
    """Parameter 5; latitude in degrees if it is a place."""
    y: float
    """Parameter 6; longitude in degrees if it is a place."""
    z: float
    """Parameter 7; altitude if it is a place."""
    sender: tuple[int, int]
    """System and component id of the sender."""
    param5: float
    """Parameter 5 if it is a number and no place, whichever message carries it."""

    @property
    def is_here(self) -> bool:
        """True if the command names no horizontal place; clients without NaN send (0, 0)."""
        return math.isnan(self.x) or math.isnan(self.y) or (self.x == 0.0 and self.y == 0.0)

    def place_fault(self) -> str | None:
        """Return the description of an invalid place, or None if the place is valid."""
        if self.frame not in GEODETIC_FRAMES:
            return f"frame {self.frame} is no global one; valid are 0, 3, 5, 6, 10, 11"
        if not self.is_here and not (abs(self.x) <= 90.0 and abs(self.y) <= 180.0):
            return f"latitude {self.x:g}, longitude {self.y:g} is off the globe"
        if abs(self.z) > 1e5:
            return f"altitude {self.z:g} m; valid are -100000 to 100000"
        return None

    def altitude_amsl_m(self, home_altitude_m: float) -> float:
        """Return the altitude above mean sea level, m; NaN if not given.

        Args:
            home_altitude_m: Altitude of home above mean sea level. Terrain counts as the height of
                home.
        """
        return self.z if self.frame in FRAME_GLOBAL else self.z + home_altitude_m


@dataclass(frozen=True, slots=True)
class Command(Order):
    """An order from a client that waits for its acknowledgement."""

    channel: Channel


Executor = Callable[[Command], Reply | None]
"""Carries out a command; None means that the acknowledgement comes later."""


class CommandService:
    """Dispatches commands to their handlers and acknowledges the result."""

    def __init__(self, executors: Mapping[int, Executor], statustext: StatustextSender) -> None:
        self._executors = executors
        self._statustext = statustext
        self.handlers: Mapping[str, Handler] = {
            "COMMAND_LONG": self._on_long,
            "COMMAND_INT": self._on_int,
        }

    def _on_long(self, channel: Channel, m: Message) -> None:
        values = (m.param1, m.param2, m.param3, m.param4, m.param5, m.param6, m.param7)
        self._execute(Command(m.command, 0, *values, _sender(m), m.param5, channel))

    def _on_int(self, channel: Channel, m: Message) -> None:
        # The same integers serve places and plain numbers; `param5` keeps the plain one.
        x, y = (coordinate_from_int(value, m.frame) for value in (m.x, m.y))
        values = (m.param1, m.param2, m.param3, m.param4, x, y, m.z)
        self._execute(Command(m.command, m.frame, *values, _sender(m), float(m.x), channel))

    def _execute(self, command: Command) -> None:
        executor = self._executors.get(command.number)
        if executor is None:
            reply = UNSUPPORTED
        # NaN means "not given", but infinity would pass range checks and spread through the state.
        elif any(map(math.isinf, _values(command))):
            reply = denied("a parameter is infinite")
        else:
            reply = executor(command)
        if reply is None:
            return
        if reply.reason:
            text = explanation(f"Command {command.number}", reply)
            self._statustext.broadcast(Severity.WARNING, text)
        acknowledge(command, reply)


def acknowledge(command: Command, reply: Reply) -> None:
    """Send the result of a command to the client that sent it."""
    is_in_progress = reply.result is CommandResult.IN_PROGRESS
    system, component = command.sender
    send(
        command.channel,
        "COMMAND_ACK",
        command=command.number,
        result=RESULTS[reply.result],
        progress=_PROGRESS_UNKNOWN if is_in_progress else 0,
        target_system=system,
        target_component=component,
    )


def _sender(message: Message) -> tuple[int, int]:
    return (message.get_srcSystem(), message.get_srcComponent())


def explanation(request: str, reply: Reply) -> str:
    """Return a line for people that says why a request was refused.

    Args:
        request: Name of the request, such as Takeoff.
        reply: Result, with the autopilot's reason.
    """
    if " denied: " in reply.reason:  # the autopilot itself announces what it denies
        return reply.reason[0].upper() + reply.reason[1:]
    return f"{request} {reply.result.value}: {reply.reason}"


def _values(c: Order) -> tuple[float, ...]:
    return (c.param1, c.param2, c.param3, c.param4, c.x, c.y, c.z)


def given(value: float) -> float | None:
    """Return the value, or None for NaN."""
    return None if math.isnan(value) else value


def choice(value: float, default: int | None = None) -> int | None:
    """Return the whole number in a parameter that selects an option.

    Args:
        value: The parameter.
        default: Result for NaN, "not given".

    Returns:
        None if the value is not whole.
    """
    if math.isnan(value):
        return default
    return int(value) if value == int(value) else None
