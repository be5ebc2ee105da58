"""Requests that are messages of their own, older than the command protocol."""

from __future__ import annotations

from collections.abc import Mapping

from flightsim.autopilot.events import Severity
from flightsim.autopilot.results import Reply
from flightsim.mavlink.channel import Channel
from flightsim.mavlink.commands import RESULTS, explanation
from flightsim.mavlink.dialect import LAYOUTS
from flightsim.mavlink.flight_commands import FlightCommands
from flightsim.mavlink.parsing import Message
from flightsim.mavlink.personalities import Personality
from flightsim.mavlink.service import Handler, send
from flightsim.mavlink.statustext import StatustextSender
from flightsim.mavlink.telemetry import TelemetryService

_SET_MODE = LAYOUTS["SET_MODE"].message_id


class OldRequestService:
    """Answers old requests as the commands of the same meaning.

    PX4 acknowledges none of them. ArduPilot acknowledges SET_MODE, by the number of the message.
    """

    def __init__(
        self,
        commands: FlightCommands,
        personality: Personality,
        telemetry: TelemetryService,
        statustext: StatustextSender,
    ) -> None:
        self._commands = commands
        self._acknowledges_set_mode = personality.acknowledges_set_mode
        self._telemetry = telemetry
        self._statustext = statustext
        self.handlers: Mapping[str, Handler] = {
            "SET_MODE": self._on_set_mode,
            "MISSION_SET_CURRENT": self._on_set_current,
            "SET_GPS_GLOBAL_ORIGIN": self._on_set_origin,
        }

    def _on_set_mode(self, channel: Channel, message: Message) -> None:
        reply = self._commands.set_custom_mode(message.base_mode, message.custom_mode)
        if reply.reason:
            self._statustext.broadcast(Severity.WARNING, explanation("SET_MODE", reply))
        if self._acknowledges_set_mode:
            _acknowledge_mode(channel, message, reply)

    def _on_set_current(self, channel: Channel, message: Message) -> None:
        if self._commands.set_current_item(message.seq).is_accepted:
            # All partners show the mission's progress; only the sender learns that nothing has
            # changed.
            self._telemetry.broadcast("MISSION_CURRENT")
        else:
            self._telemetry.send_now(channel, LAYOUTS["MISSION_CURRENT"].message_id)

    def _on_set_origin(self, channel: Channel, _: Message) -> None:
        # PX4 answers with the origin that holds; here that is where the vehicle started.
        self._statustext.broadcast(Severity.NOTICE, "The origin stays where the vehicle started")
        self._telemetry.send_now(channel, LAYOUTS["GPS_GLOBAL_ORIGIN"].message_id)


def _acknowledge_mode(channel: Channel, message: Message, reply: Reply) -> None:
    """Acknowledge SET_MODE by its own number, 11, which is no command.

    Source: ArduPilot 4.5, GCS_Common.cpp, handle_set_mode.
    """
    send(
        channel,
        "COMMAND_ACK",
        command=_SET_MODE,
        result=RESULTS[reply.result],
        target_system=message.get_srcSystem(),
        target_component=message.get_srcComponent(),
    )
