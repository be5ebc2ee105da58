"""Presence of ground stations: the autopilot's data link."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from flightsim.autopilot.autopilot import Autopilot
from flightsim.mavlink.channel import Channel
from flightsim.mavlink.dialect import dialect as mav
from flightsim.mavlink.parsing import Message
from flightsim.mavlink.service import Handler

_PRESENCE_S = 1.5
"""Time for which a heartbeat's sender counts as present: one and a half periods."""


class GroundStationService:
    """Keeps the data link alive while a ground station sends heartbeats.

    Presence is timed by the partner's own clock: a client behind a socket sends a heartbeat once a
    second of wall time, which at fifty times real time is once in fifty simulated seconds.
    """

    def __init__(self, autopilot: Autopilot) -> None:
        self._autopilot = autopilot
        self._last_heard_s: dict[Channel, float] = {}
        self.handlers: Mapping[str, Handler] = {"HEARTBEAT": self._on_heartbeat}

    @property
    def busy(self) -> Collection[Channel]:
        """Ground stations that were heard of late."""
        return self._last_heard_s

    def update(self, channel: Channel) -> None:
        """Report a ground station that is present to the autopilot."""
        heard_s = self._last_heard_s.get(channel)
        if heard_s is None:
            return
        if channel.clock() - heard_s <= _PRESENCE_S:
            self._autopilot.on_link_heartbeat(channel.name)
        else:
            del self._last_heard_s[channel]

    def forget(self, channel: Channel) -> None:
        """Drop a partner that left."""
        self._last_heard_s.pop(channel, None)

    def _on_heartbeat(self, channel: Channel, message: Message) -> None:
        if message.type == mav.MAV_TYPE_GCS:
            self._last_heard_s[channel] = channel.clock()
