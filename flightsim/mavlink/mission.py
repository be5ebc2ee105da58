"""Mission protocol: upload, download, clearing and progress.

One upload of each type runs at a time. Downloads keep no state: every request is answered as it
comes, so a lost item is simply requested again.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from typing import Protocol

from flightsim.autopilot.events import Severity
from flightsim.autopilot.fence import MAX_FENCE_ITEMS, MAX_RALLY_ITEMS
from flightsim.autopilot.mission_check import MAX_MISSION_ITEMS
from flightsim.autopilot.mission_item import MissionError, MissionItem
from flightsim.autopilot.results import Reply
from flightsim.mavlink.channel import Channel
from flightsim.mavlink.dialect import LAYOUTS
from flightsim.mavlink.dialect import dialect as mav
from flightsim.mavlink.mission_items import (
    check_frames,
    item_from_message,
    payload_of_item,
    result_of,
)
from flightsim.mavlink.mission_upload import Upload
from flightsim.mavlink.parsing import Message
from flightsim.mavlink.service import Handler, Partners, send
from flightsim.mavlink.statustext import StatustextSender

MISSION = mav.MAV_MISSION_TYPE_MISSION
FENCE = mav.MAV_MISSION_TYPE_FENCE
RALLY = mav.MAV_MISSION_TYPE_RALLY
_ALL = mav.MAV_MISSION_TYPE_ALL
_MAX_ITEMS = {MISSION: MAX_MISSION_ITEMS, FENCE: MAX_FENCE_ITEMS, RALLY: MAX_RALLY_ITEMS}
_GUIDED_PLACE, _GUIDED_ALTITUDE = 2, 3
_GUIDED = (_GUIDED_PLACE, _GUIDED_ALTITUDE)
"""Values of "current" that ArduPilot's clients send instead of a command to go somewhere."""


class Guide(Protocol):
    """Flies to a single item."""

    def __call__(self, item: MissionItem, *, is_altitude_only: bool) -> Reply:
        """Accept or refuse the item; `is_altitude_only` keeps the horizontal place."""
        ...


class ItemStore(Protocol):
    """Store of the autopilot for one type of items."""

    @property
    def items(self) -> tuple[MissionItem, ...]:
        """Stored items."""
        ...

    def replace(self, items: Iterable[MissionItem]) -> None:
        """Replace the items.

        Args:
            items: All new items.

        Raises:
            MissionError: If one cannot be used; the present items remain.
        """
        ...


class MissionService:
    """Transfers items between partners and the autopilot's stores."""

    def __init__(
        self,
        stores: Mapping[int, ItemStore],
        partners: Partners,
        statustext: StatustextSender,
        guide: Guide | None = None,
        *,
        requests_int: bool = True,
    ) -> None:
        """Serve one store for each mission type.

        Args:
            stores: The autopilot's stores by MAV_MISSION_TYPE.
            partners: All partners, which get reports of progress.
            statustext: Texts for people, with reasons of refusals.
            guide: Flies single items outside any mission; None ignores them.
            requests_int: True requests uploads with MISSION_REQUEST_INT.
        """
        self._stores = stores
        self._guide = guide
        self._requests_int = requests_int
        self._partners = partners
        self._statustext = statustext
        self._uploads: dict[int, Upload] = {}
        # Acks that may have been lost: (channel, type) -> (result, last index).
        self._finished: dict[tuple[Channel, int], tuple[int, int]] = {}
        self.handlers: Mapping[str, Handler] = {
            "MISSION_COUNT": self._on_count,
            "MISSION_WRITE_PARTIAL_LIST": self._on_partial,
            "MISSION_ITEM_INT": self._on_item,
            "MISSION_ITEM": self._on_item,
            "MISSION_ACK": self._on_ack,
            "MISSION_CLEAR_ALL": self._on_clear,
            "MISSION_REQUEST_LIST": self._on_request_list,
            "MISSION_REQUEST_INT": self._on_request,
            "MISSION_REQUEST": self._on_request,
            "MISSION_REQUEST_PARTIAL_LIST": self._on_request_partial,
        }

    @property
    def busy(self) -> Collection[Channel]:
        """Partners that upload."""
        return {upload.channel for upload in self._uploads.values()} if self._uploads else ()

    def update(self, channel: Channel) -> None:
        """Repeat requests to a partner; abandon its uploads if it is silent.

        An abandoned upload changes nothing: the items before it remain.
        """
        for mission_type, upload in list(self._uploads.items()):
            if upload.channel is not channel:
                continue
            if upload.is_abandoned:
                del self._uploads[mission_type]
                self._statustext.broadcast(Severity.WARNING, "Mission upload timed out")
                cancelled = mav.MAV_MISSION_OPERATION_CANCELLED
                self._ack(channel, upload.partner, mission_type, cancelled)
            else:
                upload.update()

    def forget(self, channel: Channel) -> None:
        """Abandon the uploads of a partner that left."""
        self._uploads = {t: u for t, u in self._uploads.items() if u.channel is not channel}
        self._finished = {k: v for k, v in self._finished.items() if k[0] is not channel}

    def announce_reached(self, index: int) -> None:
        """Send all partners the report that the mission reached an item."""
        message = LAYOUTS["MISSION_ITEM_REACHED"]
        self._partners.broadcast(message, message.encode(seq=index))

    # --- upload ---

    def _on_count(self, channel: Channel, message: Message) -> None:
        # An upload of no items clears the list: there is nothing to request.
        if message.count == 0 and message.mission_type in self._stores:
            self._store(channel, _sender(message), message.mission_type, ())
            return
        self._begin(channel, message, first=0, count=message.count)

    def _on_partial(self, channel: Channel, message: Message) -> None:
        store = self._stores.get(message.mission_type)
        last = message.end_index
        if store is None or not 0 <= message.start_index <= last < len(store.items):
            self._ack(
                channel, _sender(message), message.mission_type, mav.MAV_MISSION_INVALID_SEQUENCE
            )
            return
        count = last - message.start_index + 1
        self._begin(channel, message, first=message.start_index, count=count, previous=store.items)

    def _begin(
        self,
        channel: Channel,
        message: Message,
        *,
        first: int,
        count: int,
        previous: tuple[MissionItem, ...] = (),
    ) -> None:
        mission_type = message.mission_type
        refusal = self._refusal(channel, mission_type, count)
        if refusal is not None:
            self._ack(channel, _sender(message), mission_type, refusal)
            return
        # A new upload makes the last acknowledgement of this type meaningless.
        self._finished.pop((channel, mission_type), None)
        self._uploads[mission_type] = Upload(
            channel,
            _sender(message),
            mission_type,
            first=first,
            count=count,
            previous=previous,
            requests_int=self._requests_int,
        )

    def _refusal(self, channel: Channel, mission_type: int, count: int) -> int | None:
        if mission_type not in self._stores:
            return mav.MAV_MISSION_UNSUPPORTED
        if count > _MAX_ITEMS[mission_type]:
            return mav.MAV_MISSION_NO_SPACE
        upload = self._uploads.get(mission_type)
        is_busy = upload is not None and upload.channel is not channel
        return mav.MAV_MISSION_DENIED if is_busy else None

    def _on_item(self, channel: Channel, message: Message) -> None:
        # Such an item is a command in disguise, even during an upload.
        if self._guide is not None and message.current in _GUIDED:
            is_altitude_only = message.current == _GUIDED_ALTITUDE
            reply = self._guide(item_from_message(message), is_altitude_only=is_altitude_only)
            if reply.reason:
                self._statustext.broadcast(Severity.WARNING, f"Item refused: {reply.reason}")
            result = mav.MAV_MISSION_ACCEPTED if reply.is_accepted else mav.MAV_MISSION_DENIED
            self._ack(channel, _sender(message), message.mission_type, result)
            return
        upload = self._uploads.get(message.mission_type)
        if upload is None or not upload.is_from(channel, message):
            self._repeat_ack(channel, message)
            return
        upload.receive(message)
        if upload.is_complete:
            del self._uploads[upload.mission_type]
            result = self._store(channel, upload.partner, upload.mission_type, upload.items)
            self._finished[channel, upload.mission_type] = (result, message.seq)

    def _repeat_ack(self, channel: Channel, message: Message) -> None:
        """Repeat the acknowledgement if the last item arrives again, because it was lost."""
        result, last = self._finished.get((channel, message.mission_type), (0, -1))
        if message.seq == last:
            self._ack(channel, _sender(message), message.mission_type, result)

    def _store(
        self,
        channel: Channel,
        partner: tuple[int, int],
        mission_type: int,
        items: tuple[MissionItem, ...],
    ) -> int:
        try:
            check_frames(items)
            self._stores[mission_type].replace(items)
        except MissionError as error:
            self._statustext.broadcast(Severity.ERROR, f"Mission refused: {error}")
            result = result_of(error)
        else:
            result = mav.MAV_MISSION_ACCEPTED
        self._ack(channel, partner, mission_type, result)
        return result

    def _on_ack(self, channel: Channel, message: Message) -> None:
        """Cancel the partner's upload; acknowledgements of downloads need no action."""
        upload = self._uploads.get(message.mission_type)
        if upload and upload.is_from(channel, message) and message.type != mav.MAV_MISSION_ACCEPTED:
            del self._uploads[message.mission_type]

    def _on_clear(self, channel: Channel, message: Message) -> None:
        mission_type = message.mission_type
        if mission_type != _ALL and mission_type not in self._stores:
            self._ack(channel, _sender(message), mission_type, mav.MAV_MISSION_UNSUPPORTED)
            return
        for cleared in self._stores if mission_type == _ALL else (mission_type,):
            # A list that is cleared must not be filled again by an upload that is under way.
            self._uploads.pop(cleared, None)
            self._stores[cleared].replace(())
        self._ack(channel, _sender(message), mission_type, mav.MAV_MISSION_ACCEPTED)

    # --- download ---

    def _on_request_list(self, channel: Channel, message: Message) -> None:
        mission_type = message.mission_type
        if mission_type not in self._stores:
            self._ack(channel, _sender(message), mission_type, mav.MAV_MISSION_UNSUPPORTED)
            return
        system, component = _sender(message)
        send(
            channel,
            "MISSION_COUNT",
            target_system=system,
            target_component=component,
            count=len(self._stores[mission_type].items),
            mission_type=mission_type,
        )

    def _on_request(self, channel: Channel, message: Message) -> None:
        mission_type = message.mission_type
        store = self._stores.get(mission_type)
        if store is None or message.seq >= len(store.items):
            result = (
                mav.MAV_MISSION_UNSUPPORTED if store is None else mav.MAV_MISSION_INVALID_SEQUENCE
            )
            self._ack(channel, _sender(message), mission_type, result)
            return
        is_int = message.get_type() == "MISSION_REQUEST_INT"
        payload = payload_of_item(
            store.items[message.seq],
            message.seq,
            is_int=is_int,
            is_current=message.seq == getattr(store, "current_index", -1),
            target=_sender(message),
            mission_type=mission_type,
        )
        channel.send(LAYOUTS["MISSION_ITEM_INT" if is_int else "MISSION_ITEM"], payload)

    def _on_request_partial(self, channel: Channel, message: Message) -> None:
        # Not offered: requests of single items serve the same purpose.
        self._ack(channel, _sender(message), message.mission_type, mav.MAV_MISSION_UNSUPPORTED)

    def _ack(
        self, channel: Channel, partner: tuple[int, int], mission_type: int, result: int
    ) -> None:
        send(
            channel,
            "MISSION_ACK",
            target_system=partner[0],
            target_component=partner[1],
            type=result,
            mission_type=mission_type,
        )


def _sender(message: Message) -> tuple[int, int]:
    return (message.get_srcSystem(), message.get_srcComponent())
