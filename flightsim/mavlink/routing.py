"""Routing: messages of one partner go on to the others.

https://mavlink.io/en/guide/routing.html. A message for nobody in particular goes to all other
partners. One for a system or component goes to those behind whom it has been heard. None ever goes
back to where it came from. So a ground station can command a companion's camera through the
vehicle.
"""

from __future__ import annotations

from flightsim.mavlink.channel import Channel
from flightsim.mavlink.dialect import LAYOUTS
from flightsim.mavlink.parsing import Message
from flightsim.mavlink.service import Partners

_KEPT = frozenset(LAYOUTS[name].message_id for name in ("RADIO_STATUS", "SETUP_SIGNING"))
"""Messages that mean one link alone: the state of its radio, and a key that nobody else may see."""
_MOST_BEHIND_ONE = 64
"""Most systems and components remembered behind one partner; no client can make this grow."""

Address = tuple[int, int]
"""System and component id."""


class Router:
    """Forwards messages between partners, as an autopilot with several links does.

    It remembers which systems were heard behind each partner. A message with a target goes to the
    partners behind which that is, one without a target to all others.
    """

    def __init__(self, partners: Partners, own: Address) -> None:
        """Route between all present partners.

        Args:
            partners: Partners to route between.
            own: Address of this vehicle's autopilot.
        """
        self._partners = partners
        self._own = own
        self._heard: dict[Channel, set[Address]] = {}

    def forget(self, channel: Channel) -> None:
        """Drop what was heard from a partner that left."""
        self._heard.pop(channel, None)

    def route(self, origin: Channel, message: Message) -> None:
        """Forward a message to the partners that it may concern.

        Args:
            origin: Partner that sent it; it never gets it back.
            message: The message. One for this autopilot concerns nobody else.
        """
        heard = self._heard.setdefault(origin, set())
        if len(heard) < _MOST_BEHIND_ONE:
            heard.add((message.get_srcSystem(), message.get_srcComponent()))
        system, component = _target(message)
        if (system, component) == self._own or message.get_msgId() in _KEPT:
            return
        for channel in self._partners.channels:
            if channel is not origin and (
                not system or self._is_behind(channel, system, component)
            ):
                channel.forward(message)

    def _is_behind(self, channel: Channel, system: int, component: int) -> bool:
        heard = self._heard.get(channel, ())
        if component:
            # A message for a whole system goes wherever any of its components was heard.
            return (system, component) in heard
        return any(known == system for known, _ in heard)


def _target(message: Message) -> Address:
    """Return the addressed system and component; 0 means all."""
    system = getattr(message, "target_system", None)
    if system is None:
        # MANUAL_CONTROL alone names its addressee "target".
        system = getattr(message, "target", 0) if message.get_type() == "MANUAL_CONTROL" else 0
    return system, getattr(message, "target_component", 0)
