"""TIMESYNC and PING: clients compare clocks and measure the round trip."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from flightsim.mavlink.channel import Channel
from flightsim.mavlink.parsing import Message
from flightsim.mavlink.service import Handler, send


class TimesyncService:
    """Answers with the simulated time since the start.

    A client that compares clocks therefore learns simulated time, however fast the run is.
    """

    def __init__(self, now_us: Callable[[], int]) -> None:
        self._now_us = now_us
        self.handlers: Mapping[str, Handler] = {
            "TIMESYNC": self._on_timesync,
            "PING": self._on_ping,
        }

    def _on_timesync(self, channel: Channel, message: Message) -> None:
        if message.tc1 == 0:  # a request; any other value is an answer of another system
            send(channel, "TIMESYNC", tc1=self._now_us() * 1000, ts1=message.ts1)

    def _on_ping(self, channel: Channel, message: Message) -> None:
        # Addressed pings are answers to somebody's own ping.
        if message.target_system == 0 and message.target_component == 0:
            send(
                channel,
                "PING",
                time_usec=message.time_usec,
                seq=message.seq,
                target_system=message.get_srcSystem(),
                target_component=message.get_srcComponent(),
            )
