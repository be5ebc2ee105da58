"""SETUP_SIGNING: a client on this machine sets the key, changes it or removes it.

The message holds the key for everybody to read. So it is accepted from loopback, from serial lines
and from this process only, while the vehicle is disarmed. Once there is a key, the message must be
signed with it like any other. Its timestamp means nothing to a vehicle that has a clock.
"""

from __future__ import annotations

from collections.abc import Mapping

from flightsim.autopilot.autopilot import Autopilot
from flightsim.autopilot.events import Severity
from flightsim.mavlink.channel import Channel
from flightsim.mavlink.parsing import Message
from flightsim.mavlink.service import Handler
from flightsim.mavlink.signing.signing import Signing
from flightsim.mavlink.statustext import StatustextSender


class SigningSetup:
    """Sets the key that all links sign with, when a client sends one.

    A key over a network is refused, since others could read it, and so is one to an armed vehicle.
    """

    def __init__(
        self, signing: Signing, autopilot: Autopilot, statustext: StatustextSender
    ) -> None:
        self._signing = signing
        self._autopilot = autopilot
        self._statustext = statustext
        self.handlers: Mapping[str, Handler] = {"SETUP_SIGNING": self._on_setup}

    def _on_setup(self, channel: Channel, message: Message) -> None:
        refusal = self._refusal(channel)
        if refusal is not None:
            self._statustext.broadcast(Severity.WARNING, f"Signing key refused: {refusal}")
            return
        key = bytes(message.secret_key)
        # A key of zeros ends signing, as MAVLink defines.
        self._signing.key = key if any(key) else None
        self._statustext.broadcast(Severity.NOTICE, f"Signing is {'on' if any(key) else 'off'}")

    def _refusal(self, channel: Channel) -> str | None:
        if not channel.is_local:
            return "it came over a network, where others read it"
        if self._autopilot.is_armed:
            return "the vehicle is armed"
        return None
