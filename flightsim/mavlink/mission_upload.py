"""Upload of mission, fence or rally items, robust against loss in both directions.

https://mavlink.io/en/services/mission.html: the vehicle requests one item after the other. It
repeats a request until the item comes, so it does not matter whether the request or the item was
lost.
"""

from __future__ import annotations

from collections.abc import Sequence

from flightsim.autopilot.mission_item import MissionItem
from flightsim.mavlink.channel import Channel
from flightsim.mavlink.mission_items import item_from_message
from flightsim.mavlink.parsing import Message
from flightsim.mavlink.service import send

RETRY_S = 0.25  # MAVLink's recommended repetition
TIMEOUT_S = 5.0
"""Time of twenty unanswered requests; at 25% frame loss, one item in ten million fails."""

_REQUESTS_BEFORE_OLD_STYLE = 4  # as many before a client counts as too old for MISSION_REQUEST_INT


class Upload:
    """Requests items from a partner until the list is complete or the partner falls silent."""

    def __init__(
        self,
        channel: Channel,
        partner: tuple[int, int],
        mission_type: int,
        *,
        first: int,
        count: int,
        previous: Sequence[MissionItem] = (),
        requests_int: bool = True,
    ) -> None:
        """Start an upload, and request its first item.

        Args:
            channel: Channel to the partner.
            partner: System and component id of the partner.
            mission_type: MAV_MISSION_TYPE.
            first: Index of the first item to request.
            count: Number of items to request, at least 1.
            previous: Items of the list that is replaced in part.
            requests_int: True asks with MISSION_REQUEST_INT; ArduPilot asks with MISSION_REQUEST,
                to which clients may send either kind of item.
        """
        self.channel = channel
        self.partner = partner
        self.mission_type = mission_type
        self._items = list(previous)
        self._received: list[MissionItem] = []
        self._first = first
        self._count = count
        self._n_requests = 0
        self._requests_int = self._is_int = requests_int
        self._last_request_s = 0.0
        self._last_heard_s = channel.clock()
        self._request()

    @property
    def is_complete(self) -> bool:
        """True if all items have arrived."""
        return len(self._received) == self._count

    @property
    def is_abandoned(self) -> bool:
        """True if the partner has been silent for too long."""
        return self.channel.clock() - self._last_heard_s > TIMEOUT_S

    @property
    def items(self) -> tuple[MissionItem, ...]:
        """The whole list, with uploaded items in their places."""
        merged = list(self._items)
        merged[self._first : self._first + self._count] = self._received
        return tuple(merged)

    def is_from(self, channel: Channel, message: Message) -> bool:
        """Return true if a message belongs to this upload."""
        return channel is self.channel and message.mission_type == self.mission_type

    def receive(self, message: Message) -> None:
        """Store the item if it is the requested one, and request the next.

        Args:
            message: An item; a second copy of an earlier one is left out.
        """
        self._last_heard_s = self.channel.clock()
        if message.seq != self._expected:
            return  # a late copy: the pending request is repeated if necessary
        # The partner has shown which kind of item it knows; ask for that kind from now on.
        self._is_int = self._requests_int and message.get_type() == "MISSION_ITEM_INT"
        self._received.append(item_from_message(message))
        self._n_requests = 0
        if not self.is_complete:
            self._request()

    def update(self) -> None:
        """Repeat the request if it has not been answered for `RETRY_S`."""
        if self.channel.clock() - self._last_request_s >= RETRY_S:
            self._request()

    @property
    def _expected(self) -> int:
        return self._first + len(self._received)

    def _request(self) -> None:
        self._last_request_s = self.channel.clock()
        self._n_requests += 1
        is_int = self._is_int
        # Alternating: a slow client of the new kind must not be taken for an old one.
        if self._is_int and not self._received and self._n_requests > _REQUESTS_BEFORE_OLD_STYLE:
            # Clients older than MISSION_REQUEST_INT answer only MISSION_REQUEST.
            is_int = bool(self._n_requests % 2)
        send(
            self.channel,
            "MISSION_REQUEST_INT" if is_int else "MISSION_REQUEST",
            target_system=self.partner[0],
            target_component=self.partner[1],
            seq=self._expected,
            mission_type=self.mission_type,
        )
