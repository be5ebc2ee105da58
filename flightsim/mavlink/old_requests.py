"""Requests that are messages of their own, older than the command protocol."""

from __future__ import annotations

from collections.abc import Mapping

from flightsim.autopilot.events import Severity
from flightsim.mavlink.channel import Channel
from flightsim.mavlink.dialect import LAYOUTS
from flightsim.mavlink.flight_commands import FlightCommands
from flightsim.mavlink.parsing import Message
from flightsim.mavlink.service import Handler
from flightsim.mavlink.statustext import StatustextSender
from flightsim.mavlink.telemetry import TelemetryService


class OldRequestService:
    """Answers them as commands of the same meaning are executed; none has an acknowledgement."""

    def __init__(
        self, commands: FlightCommands, telemetry: TelemetryService, statustext: StatustextSender
    ) -> None:
        self._commands = commands
        self._telemetry = telemetry
        self._statustext = statustext
        self.handlers: Mapping[str, Handler] = {
            "SET_MODE": self._on_set_mode,
            "MISSION_SET_CURRENT": self._on_set_current,
            "SET_GPS_GLOBAL_ORIGIN": self._on_set_origin,
        }

    def _on_set_mode(self, _: Channel, message: Message) -> None:
        self._commands.set_custom_mode(message.base_mode, message.custom_mode)

    def _on_set_current(self, channel: Channel, message: Message) -> None:
        if self._commands.set_current_item(message.seq).is_accepted:
            self._telemetry.broadcast("MISSION_CURRENT")
        else:
            self._telemetry.send_now(channel, LAYOUTS["MISSION_CURRENT"].message_id)

    def _on_set_origin(self, channel: Channel, _: Message) -> None:
        # PX4 answers with the origin that holds; here that is where the vehicle started.
        self._statustext.say(Severity.NOTICE, "The origin stays where the vehicle started")
        self._telemetry.send_now(channel, LAYOUTS["GPS_GLOBAL_ORIGIN"].message_id)
