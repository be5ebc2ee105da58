"""One upload of mission, fence or rally items, robust against loss in both directions.

https://mavlink.io/en/services/mission.html: the vehicle asks for one item after the other.
"""

from __future__ import annotations

from collections.abc import Sequence

from flightsim.autopilot.mission import MissionItem
from flightsim.mavlink.channel import Channel
from flightsim.mavlink.mission_items import item_from_message
from flightsim.mavlink.parsing import Message
from flightsim.mavlink.service import send

RETRY_S = 0.25
TIMEOUT_S = 5.0
"""Twenty unanswered requests end an upload: at a quarter of frames lost, one in ten million."""

_REQUESTS_BEFORE_OLD_STYLE = 4


class Upload:
    """Asks a partner for items until it has them all, or the partner falls silent."""

    def __init__(
        self,
        channel: Channel,
        partner: tuple[int, int],
        mission_type: int,
        *,
        first: int,
        count: int,
        previous: Sequence[MissionItem] = (),
    ) -> None:
        """Start an upload.

        Args:
            channel: Where the partner is.
            partner: Its system and component id.
            mission_type: MAV_MISSION_TYPE.
            first: Index of the first item to come.
            count: Items to come, at least 1.
            previous: Items of the list of which a part is replaced.
        """
        self.channel = channel
        self.partner = partner
        self.mission_type = mission_type
        self._items = list(previous)
        self._received: list[MissionItem] = []
        self._first = first
        self._count = count
        self._n_requests = 0
        self._is_int = True
        self._last_request_s = 0.0
        self._last_heard_s = channel.clock()
        self._request()

    @property
    def is_complete(self) -> bool:
        """Whether all items are here."""
        return len(self._received) == self._count

    @property
    def is_abandoned(self) -> bool:
        """Whether the partner has been silent for too long."""
        return self.channel.clock() - self._last_heard_s > TIMEOUT_S

    @property
    def items(self) -> tuple[MissionItem, ...]:
        """The whole list with what was uploaded in its place."""
        merged = list(self._items)
        merged[self._first : self._first + self._count] = self._received
        return tuple(merged)

    def is_from(self, channel: Channel, message: Message) -> bool:
        """Whether a message belongs to this upload."""
        return channel is self.channel and message.mission_type == self.mission_type

    def receive(self, message: Message) -> None:
        """Take the item if it is the one that was asked for, and ask for the next."""
        self._last_heard_s = self.channel.clock()
        if message.seq != self._expected:
            return  # a late copy: the request that is under way will be repeated if need be
        self._is_int = message.get_type() == "MISSION_ITEM_INT"
        self._received.append(item_from_message(message))
        self._n_requests = 0
        if not self.is_complete:
            self._request()

    def update(self) -> None:
        """Repeat the request if it stayed unanswered."""
        if self.channel.clock() - self._last_request_s >= RETRY_S:
            self._request()

    @property
    def _expected(self) -> int:
        return self._first + len(self._received)

    def _request(self) -> None:
        self._last_request_s = self.channel.clock()
        self._n_requests += 1
        is_int = self._is_int
        if not self._received and self._n_requests > _REQUESTS_BEFORE_OLD_STYLE:
            # Clients from before MISSION_REQUEST_INT hear only MISSION_REQUEST.
            is_int = bool(self._n_requests % 2)
        send(
            self.channel,
            "MISSION_REQUEST_INT" if is_int else "MISSION_REQUEST",
            target_system=self.partner[0],
            target_component=self.partner[1],
            seq=self._expected,
            mission_type=self.mission_type,
        )
