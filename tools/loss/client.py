"""A ground station that repeats itself as https://mavlink.io/en/services/mission.html says.

It keeps simulated time, so that a transfer of minutes at heavy loss is measured in seconds, and the
same seed loses the same datagrams.
"""

from __future__ import annotations

import contextlib
import socket
from collections.abc import Callable, Sequence
from typing import Any

from flightsim.mavlink.dialect import dialect as mav
from flightsim.testbench import Testbench
from loss.proxy import LossyProxy

Message = Any
Item = tuple[int, int, float, float, float, float, int, int, float]
"""Frame, command, four parameters, latitude and longitude in 1e-7 degrees, altitude in m."""

VEHICLE = (1, 1)
_HEADER_BYTES = 10  # header of a frame of MAVLink 2
_TICK_S = 0.02
_TIMEOUT_S, _ITEM_TIMEOUT_S = 1.5, 0.25
"""Times after which a request is repeated, and one for an item; the protocol's own defaults."""


class GaveUpError(Exception):
    """The client has repeated itself as often as it may, or was refused."""


class PatientClient:
    """A client that transfers missions and parameters through a lossy proxy.

    Attributes:
        n_repeats: Number of times that it had to repeat itself.
    """

    def __init__(self, bench: Testbench, proxy: LossyProxy, end: socket.socket, tries: int) -> None:
        """Begin to listen.

        Args:
            bench: The vehicle, which is stepped while the client waits.
            proxy: What stands in between.
            end: The client's socket.
            tries: Number of times that it says the same thing before it gives up.
        """
        self.n_repeats = 0
        self._bench = bench
        self._proxy = proxy
        self._end = end
        self._tries = tries
        self._mav = mav.MAVLink(None, 255, 190)
        self._decoder = mav.MAVLink(None)
        self._decoder.robust_parsing = True
        self._inbox: list[Message] = []

    def upload(self, mission_type: int, items: Sequence[Item]) -> None:
        """Upload a list of items.

        Args:
            mission_type: Kind of the list, MAV_MISSION_TYPE.
            items: Items in their order.

        Raises:
            GaveUpError: If the vehicle refuses the list, or does not answer.
        """
        said = mav.MAVLink_mission_count_message(*VEHICLE, len(items), mission_type)
        # The vehicle asks for each item. If it is silent, its question or our answer was lost, and
        # we say the last thing again.
        while True:
            answer = self._ask(
                said,
                ("MISSION_REQUEST_INT", "MISSION_REQUEST", "MISSION_ACK"),
                lambda m: m.mission_type == mission_type,
            )
            if answer.get_type() == "MISSION_ACK":
                if answer.type == mav.MAV_MISSION_ACCEPTED:
                    return
                raise GaveUpError(f"refused with {answer.type}")
            said = item_message(answer.seq, items[answer.seq], mission_type)

    def download(self, mission_type: int) -> list[Item]:
        """Download a list of items.

        Args:
            mission_type: Kind of the list, MAV_MISSION_TYPE.

        Raises:
            GaveUpError: If the vehicle does not answer.
        """
        request = mav.MAVLink_mission_request_list_message(*VEHICLE, mission_type)
        count = self._ask(
            request, ("MISSION_COUNT",), lambda m: m.mission_type == mission_type
        ).count
        items: list[Item] = []
        for seq in range(count):
            request = mav.MAVLink_mission_request_int_message(*VEHICLE, seq, mission_type)
            item = self._ask(
                request,
                ("MISSION_ITEM_INT",),
                lambda m, seq=seq: m.seq == seq and m.mission_type == mission_type,
                timeout_s=_ITEM_TIMEOUT_S,
            )
            parameters = (item.param1, item.param2, item.param3, item.param4)
            items.append((item.frame, item.command, *parameters, item.x, item.y, item.z))
        self._send(mav.MAVLink_mission_ack_message(*VEHICLE, 0, mission_type))
        return items

    def parameters(self) -> dict[str, bytes]:
        """Read all parameters.

        Returns:
            The four bytes of each value by its name: bits, because integers travel in the field of
            a float.

        Raises:
            GaveUpError: If the vehicle does not answer.
        """
        found: dict[int, tuple[str, bytes]] = {}
        first = self._ask(
            mav.MAVLink_param_request_list_message(*VEHICLE),
            ("PARAM_VALUE",),
            # Answers to other requests have an index that is out of range.
            lambda m: m.param_index < m.param_count,
        )
        last = first
        while last is not None:
            found[last.param_index] = (last.param_id, _value_bytes(last))
            last = self._wait(("PARAM_VALUE",), lambda m: m.param_index < m.param_count, _TIMEOUT_S)
        # The stream of all of them has ended; the lost ones are asked for one by one.
        for index in sorted(set(range(first.param_count)) - set(found)):
            value = self._ask(
                mav.MAVLink_param_request_read_message(*VEHICLE, b"", index),
                ("PARAM_VALUE",),
                lambda m, index=index: m.param_index == index,
            )
            found[index] = (value.param_id, _value_bytes(value))
        return dict(found.values())

    def _ask(
        self,
        said: Message,
        names: Sequence[str],
        is_answer: Callable[[Message], bool],
        *,
        timeout_s: float = _TIMEOUT_S,
    ) -> Message:
        for attempt in range(self._tries):
            self.n_repeats += attempt > 0
            self._send(said)
            answer = self._wait(names, is_answer, timeout_s)
            if answer is not None:
                return answer
        raise GaveUpError(f"no answer to {self._tries} times {said}")

    def _wait(
        self, names: Sequence[str], is_wanted: Callable[[Message], bool], timeout_s: float
    ) -> Message | None:
        """The next wanted message, or None; what came before it is thrown away."""
        for _ in range(round(timeout_s / _TICK_S)):
            while self._inbox:
                message = self._inbox.pop(0)
                if message.get_type() in names and is_wanted(message):
                    return message
            self._tick()
        return None

    def _tick(self) -> None:
        # Before the step, so that the vehicle gets what was just sent, and after it for its
        # answers.
        self._proxy.carry()
        self._bench.simulator.step()
        self._proxy.carry()
        with contextlib.suppress(BlockingIOError):
            while data := self._end.recv(1 << 16):
                self._inbox += self._decoder.parse_buffer(data) or []

    def _send(self, message: Message) -> None:
        self._end.sendto(message.pack(self._mav), ("127.0.0.1", self._proxy.client_port))
        self._mav.seq = (self._mav.seq + 1) % 256


def item_message(seq: int, item: Item, mission_type: int) -> Message:
    """MISSION_ITEM_INT that carries an item of a list.

    Args:
        seq: Place of the item in the list.
        item: Item.
        mission_type: Kind of the list, MAV_MISSION_TYPE.
    """
    frame, command, p1, p2, p3, p4, x, y, z = item
    return mav.MAVLink_mission_item_int_message(
        *VEHICLE, seq, frame, command, 0, 1, p1, p2, p3, p4, x, y, z, mission_type
    )


def _value_bytes(message: Message) -> bytes:
    """Four bytes of a value as they came: of a float, or of an integer bytewise."""
    # The value is the first field of the payload, because the largest fields come first.
    return bytes(message.get_msgbuf()[_HEADER_BYTES : _HEADER_BYTES + 4])
