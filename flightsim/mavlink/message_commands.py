"""Message commands: request one message, an interval or the list of flight modes."""

from __future__ import annotations

import math
from collections.abc import Mapping

from flightsim.autopilot.events import Severity
from flightsim.autopilot.modes import Mode
from flightsim.autopilot.results import ACCEPTED, CommandResult, Reply, rejected
from flightsim.mavlink.channel import Channel
from flightsim.mavlink.commands import Command, Executor, choice
from flightsim.mavlink.dialect import LAYOUTS
from flightsim.mavlink.dialect import dialect as mav
from flightsim.mavlink.personalities import ModeEntry, Personality
from flightsim.mavlink.service import send
from flightsim.mavlink.statustext import StatustextSender
from flightsim.mavlink.telemetry import TelemetryService

DENIED = Reply(CommandResult.DENIED)
"""Denial without a reason: clients request messages regularly, and a text for each would be noise.
"""

_AVAILABLE_MODES = LAYOUTS["AVAILABLE_MODES"].message_id
_AUTOPILOT_VERSION = LAYOUTS["AUTOPILOT_VERSION"].message_id
_PROTOCOL_VERSION = LAYOUTS["PROTOCOL_VERSION"].message_id
_HOME_POSITION = LAYOUTS["HOME_POSITION"].message_id
_ADVANCED_MODES = frozenset({Mode.MANUAL, Mode.ACRO, Mode.OFFBOARD})
_DO_SEND_BANNER = 42428
"""Command of ArduPilot's own dialect."""
# MAV_MODE_PROPERTY
_IS_ADVANCED, _NOT_SELECTABLE = 1, 2


class MessageCommands:
    """Executes a component's commands that request messages and intervals."""

    def __init__(self, telemetry: TelemetryService) -> None:
        self._telemetry = telemetry
        self.executors: Mapping[int, Executor] = {
            mav.MAV_CMD_GET_MESSAGE_INTERVAL: self._get_interval,
            mav.MAV_CMD_SET_MESSAGE_INTERVAL: self._set_interval,
            mav.MAV_CMD_REQUEST_MESSAGE: self.request,
        }

    def request(self, c: Command) -> Reply:
        """Send the message that a MAV_CMD_REQUEST_MESSAGE asks for.

        Args:
            c: Command, whose first parameter is the message's id.

        Returns:
            Acceptance, or a denial if the component does not have the message.
        """
        message_id = choice(c.param1)
        return DENIED if message_id is None else self.send_once(c.channel, message_id)

    def send_once(self, channel: Channel, message_id: int) -> Reply:
        """Send a message to a partner once.

        Args:
            channel: The partner.
            message_id: Number of the message.

        Returns:
            Denied if the message is unknown, rejected if it has nothing to say yet.
        """
        if not self._telemetry.is_known(message_id):
            return DENIED
        return ACCEPTED if self._telemetry.send_now(channel, message_id) else rejected("")

    def _get_interval(self, c: Command) -> Reply:
        message_id = choice(c.param1)
        is_sent = message_id is not None and self._telemetry.send_interval(c.channel, message_id)
        return ACCEPTED if is_sent else DENIED

    def _set_interval(self, c: Command) -> Reply:
        message_id = choice(c.param1)
        if message_id is None or math.isnan(c.param2):
            return DENIED
        is_set = self._telemetry.set_interval(c.channel, message_id, c.param2)
        return ACCEPTED if is_set else DENIED


class IdentityCommands:
    """Executes the autopilot's commands that request its identity, its modes and its home.

    They go beyond `MessageCommands`, and replace its answer to a request for the list of modes.
    """

    def __init__(
        self, messages: MessageCommands, personality: Personality, statustext: StatustextSender
    ) -> None:
        self._messages = messages
        self._statustext = statustext
        self._banner = personality.banner
        self._modes = _distinct(personality.modes)

        def sends(message_id: int) -> Executor:
            return lambda c: messages.send_once(c.channel, message_id)

        self.executors: Mapping[int, Executor] = {
            mav.MAV_CMD_GET_HOME_POSITION: sends(_HOME_POSITION),
            mav.MAV_CMD_REQUEST_MESSAGE: self._request_message,
            mav.MAV_CMD_REQUEST_PROTOCOL_VERSION: sends(_PROTOCOL_VERSION),
            mav.MAV_CMD_REQUEST_AUTOPILOT_CAPABILITIES: sends(_AUTOPILOT_VERSION),
            **({_DO_SEND_BANNER: self._send_banner} if personality.banner else {}),
        }

    def _request_message(self, c: Command) -> Reply:
        is_modes = choice(c.param1) == _AVAILABLE_MODES
        return self._send_modes(c) if is_modes else self._messages.request(c)

    def _send_banner(self, _: Command) -> Reply:
        self._statustext.broadcast(Severity.INFO, self._banner)
        return ACCEPTED

    def _send_modes(self, c: Command) -> Reply:
        """Send AVAILABLE_MODES: one by its index from 1, or all for index 0."""
        index = choice(c.param2, default=0)
        if index is None or not 0 <= index <= len(self._modes):
            return DENIED
        chosen = range(1, len(self._modes) + 1) if index == 0 else (index,)
        for i in chosen:
            entry = self._modes[i - 1]
            send(
                c.channel,
                "AVAILABLE_MODES",
                number_modes=len(self._modes),
                mode_index=i,
                standard_mode=entry.standard_mode,
                custom_mode=entry.custom_mode,
                properties=_properties(entry),
                mode_name=entry.title or entry.mode.value,
            )
        return ACCEPTED


def _distinct(entries: tuple[ModeEntry, ...]) -> tuple[ModeEntry, ...]:
    """Return the first entry of each custom mode: clients must not see a number twice."""
    first: dict[int, ModeEntry] = {}
    for entry in entries:
        first.setdefault(entry.custom_mode, entry)
    return tuple(first.values())


def _properties(entry: ModeEntry) -> int:
    advanced = _IS_ADVANCED if entry.mode in _ADVANCED_MODES else 0
    return advanced | (0 if entry.is_selectable else _NOT_SELECTABLE)
