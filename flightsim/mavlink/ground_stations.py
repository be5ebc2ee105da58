"""Which ground stations are there: the autopilot's data link."""

from __future__ import annotations

from collections.abc import Mapping

from flightsim.autopilot.autopilot import Autopilot
from flightsim.mavlink.channel import Channel
from flightsim.mavlink.parsing import Message
from flightsim.mavlink.service import Handler

_MAV_TYPE_GCS = 6
_PRESENCE_S = 1.5
"""A heartbeat's period and a half: until then its sender counts as present."""


class GroundStationService:
    """Keeps the data link alive while a ground station's heartbeats come.

    Presence runs by the partner's own clock: a client behind a socket beats once a second of wall
    time, which at fifty times real time is once in fifty simulated seconds.
    """

    def __init__(self, autopilot: Autopilot) -> None:
        self._autopilot = autopilot
        self._last_heard_s: dict[Channel, float] = {}
        self.handlers: Mapping[str, Handler] = {"HEARTBEAT": self._on_heartbeat}

    def update(self) -> None:
        """Tell the autopilot of ground stations that are there."""
        for channel, heard_s in list(self._last_heard_s.items()):
            if channel.clock() - heard_s <= _PRESENCE_S:
                self._autopilot.on_link_heartbeat(channel.name)
            else:
                del self._last_heard_s[channel]

    def forget(self, channel: Channel) -> None:
        """A partner is gone."""
        self._last_heard_s.pop(channel, None)

    def _on_heartbeat(self, channel: Channel, message: Message) -> None:
        if message.type == _MAV_TYPE_GCS:
            self._last_heard_s[channel] = channel.clock()
