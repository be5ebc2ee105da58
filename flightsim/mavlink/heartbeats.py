"""Heartbeats of partners: presence of a ground station, and companions that read little."""

from __future__ import annotations

from collections.abc import Mapping

from flightsim.autopilot.autopilot import Autopilot
from flightsim.mavlink.channel import Channel
from flightsim.mavlink.dialect import dialect as mav
from flightsim.mavlink.parsing import Message
from flightsim.mavlink.service import Handler

_PRESENCE_S = 1.5
"""Time for which a heartbeat's sender counts as present: one and a half periods."""
_TICKS_BETWEEN_LOOKS = 10
"""Ticks between two looks: a fifth of a simulated second. The shortest silence that counts as a
loss is five seconds."""


class HeartbeatService:
    """Keeps the data link alive while a ground station sends heartbeats.

    Presence is timed by the partner's own clock. A client behind a socket sends a heartbeat once a
    second of wall time, which at fifty times real time is once in fifty simulated seconds.
    """

    def __init__(self, autopilot: Autopilot) -> None:
        self._autopilot = autopilot
        self._last_heard_s: dict[Channel, float] = {}
        self._n_ticks = 0
        self.handlers: Mapping[str, Handler] = {"HEARTBEAT": self._on_heartbeat}

    def update(self) -> None:
        """Report to the autopilot that a ground station is present, if one is."""
        self._n_ticks += 1
        if self._n_ticks % _TICKS_BETWEEN_LOOKS:
            return
        for channel, heard_s in self._last_heard_s.items():
            if channel.clock() - heard_s <= _PRESENCE_S:
                self._autopilot.on_link_heartbeat()
                return
        # All of them have fallen silent: the autopilot notices by the missing reports.
        self._last_heard_s.clear()

    def forget(self, channel: Channel) -> None:
        """Drop a partner that left."""
        self._last_heard_s.pop(channel, None)

    def _on_heartbeat(self, channel: Channel, message: Message) -> None:
        if message.type == mav.MAV_TYPE_GCS:
            self._last_heard_s[channel] = channel.clock()
            self._autopilot.on_link_heartbeat()
        elif message.type == mav.MAV_TYPE_ONBOARD_CONTROLLER:
            channel.keep_datagrams_short()  # mavros sends this type
