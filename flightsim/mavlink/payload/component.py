"""A component of the vehicle besides its autopilot: heartbeat, streams, requests and commands."""

from __future__ import annotations

from collections.abc import Mapping

from flightsim.mavlink.channel import Channel
from flightsim.mavlink.commands import CommandService, Executor
from flightsim.mavlink.dialect import LAYOUTS, layout
from flightsim.mavlink.dialect import dialect as mav
from flightsim.mavlink.faults import Faults
from flightsim.mavlink.ignored_messages import reason_for
from flightsim.mavlink.message_commands import MessageCommands
from flightsim.mavlink.parsing import Message
from flightsim.mavlink.service import Handler, Partners
from flightsim.mavlink.statustext import StatustextSender
from flightsim.mavlink.telemetry import Producer, TelemetryService
from flightsim.mavlink.view import VehicleView

_HEARTBEAT = layout("HEARTBEAT")


class Component:
    """Introduces itself to all partners, and streams to those that have addressed it.

    Its messages exist in MAVLink 2 only. Clients that do not tell components apart hear nothing of
    it until they address it: they would take its heartbeat for the autopilot's.

    Attributes:
        telemetry: Its messages.
    """

    def __init__(
        self,
        component_id: int,
        kind: int,
        *,
        view: VehicleView,
        everybody: Partners,
        statustext: StatustextSender,
        faults: Faults,
        producers: Mapping[str, Producer],
        handlers: Mapping[str, Handler],
    ) -> None:
        """Prepare a component.

        Args:
            component_id: Value of MAV_COMPONENT.
            kind: Value of MAV_TYPE.
            view: State of the vehicle.
            everybody: All partners of the vehicle.
            statustext: Texts for people.
            faults: Guards work for clients.
            producers: Its messages besides the heartbeat.
            handlers: Handlers of messages besides commands.
        """
        self._id = component_id
        self._everybody = everybody
        self._statustext = statustext
        self._heartbeat = _HEARTBEAT.encode(
            type=kind,
            autopilot=mav.MAV_AUTOPILOT_INVALID,
            system_status=mav.MAV_STATE_ACTIVE,
            mavlink_version=3,
        )
        self._own: dict[Channel, Channel] = {}
        # Partners that have addressed it. The others receive its messages by `broadcast`.
        self._partners = Partners()
        self.telemetry = TelemetryService(
            {"HEARTBEAT": lambda: self._heartbeat, **producers},
            self._partners,
            lambda: view.plant.time_us,
            faults,
        )
        self._own_handlers = handlers
        self._handlers: dict[int, Handler] = {}

    def execute(self, executors: Mapping[int, Executor]) -> None:
        """Answer commands from now on: those for messages and intervals, and the given ones."""
        messages = MessageCommands(self.telemetry)
        commands = CommandService({**messages.executors, **executors}, self._statustext)
        handlers = {**self._own_handlers, **commands.handlers}
        self._handlers = {LAYOUTS[name].message_id: handler for name, handler in handlers.items()}

    def channel_for(self, channel: Channel) -> Channel:
        """Return a partner's channel as this component's, which streams to it from now on."""
        own = channel.as_component(self._id)
        if own is not channel and channel not in self._own:
            self._own[channel] = own
            self._partners.channels = tuple(self._own.values())
        return own

    def handle(self, channel: Channel, message: Message) -> str | None:
        """Handle a message that is addressed to this component.

        Returns:
            The reason why it changes nothing; None if it does, or if something else reports that.
        """
        handler = self._handlers.get(message.get_msgId())
        if handler is None:
            reason = reason_for(message)
            return reason and f"component {self._id}: {reason}"
        return handler(self.channel_for(channel), message)

    def broadcast(self, name: str, payload: bytes) -> None:
        """Send a message to all partners that speak MAVLink 2."""
        for channel in self._everybody.channels:
            if channel.speaks_version_2:
                channel.as_component(self._id).send(LAYOUTS[name], payload)

    def introduce(self) -> None:
        """Send the heartbeat to those who have not addressed this component."""
        for channel in self._everybody.channels:
            if channel.knows_components and channel not in self._own:
                channel.as_component(self._id).stream_one(_HEARTBEAT, self._heartbeat)

    def forget(self, channel: Channel) -> None:
        """Drop a partner that left."""
        own = self._own.pop(channel, None)
        if own is not None:
            self._partners.channels = tuple(self._own.values())
            self.telemetry.forget(own)
