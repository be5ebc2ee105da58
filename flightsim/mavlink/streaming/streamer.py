"""Memory of the streaming kernel, and the call to it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from flightsim.mavlink.dialect import Layout
from flightsim.mavlink.streaming.inputs import KernelInputs
from flightsim.mavlink.streaming.kernel import compile_streaming, stream
from flightsim.mavlink.streaming.packing import OVERHEAD_BYTES
from flightsim.mavlink.streaming.record import (
    MOST_PARTS,
    PARTNER_DTYPE,
    STREAMER_DTYPE,
    message_rows,
    value_types,
)

_ANY = -1
# The first fields of a partner are read and written as plain integers: numpy's records are slow.
_SERVICE_MODE, _SEQUENCE, _N_FRAMES, _N_BYTES, _NOW_US = range(5)
assert PARTNER_DTYPE.names is not None
assert PARTNER_DTYPE.names[:5] == ("service_mode", "sequence", "n_frames", "n_bytes", "now_us")
assert STREAMER_DTYPE.names is not None
_NEXT_US = STREAMER_DTYPE.names.index("next_us")


class Streamed:
    """One partner of a streamer: how it is served, and its frames of this tick.

    Attributes:
        n_frames: Number of frames that are due now.
    """

    def __init__(self, partner: np.ndarray, is_due: np.ndarray, room_bytes: int) -> None:
        """Give a partner room for its frames.

        Args:
            partner: `PARTNER_DTYPE` (1,), changed.
            is_due: For each message, 1 if it is due (n,), bytes.
            room_bytes: Size of all frames of one tick at most.
        """
        self.partner, self._is_due = partner, is_due
        self._frames = np.zeros(room_bytes, np.uint8)
        self._bytes = self._frames.data
        self._numbers = partner.data.cast("B").cast("q")
        partner["frames_address"] = self._frames.ctypes.data

    def serve(self, service_mode: int, sequence: int) -> None:
        """Set how the partner is served in this tick, and the number of its next frame."""
        self._numbers[_SERVICE_MODE] = service_mode
        self._numbers[_SEQUENCE] = sequence

    def let_pass(self, now_us: int) -> None:
        """Note a tick at which nothing is due: rates that change count from the latest one."""
        self._numbers[_NOW_US] = now_us

    @property
    def service_mode(self) -> int:
        """How the partner is served in this tick."""
        return self._numbers[_SERVICE_MODE]

    @property
    def n_frames(self) -> int:
        """Number of its frames in this tick."""
        return self._numbers[_N_FRAMES]

    @property
    def frames(self) -> bytes:
        """Its frames of this tick, one after the other."""
        return bytes(self._bytes[: self._numbers[_N_BYTES]])

    def take_due(self) -> Sequence[int]:
        """Return the indexes of due messages for another sender; they are no longer due then."""
        indexes = np.flatnonzero(self._is_due).tolist()
        self._is_due[:] = 0
        return indexes


class Streamer:
    """Frames the due messages for all partners, in one call a tick."""

    def __init__(self, layouts: Sequence[Layout], inputs: KernelInputs | None) -> None:
        """Prepare to stream messages of these types.

        Args:
            layouts: Types of messages; one is named by its index here.
            inputs: Source of the messages that the kernel fills; None if Python packs them all.
        """
        compile_streaming()
        self._inputs = inputs
        self._messages = message_rows(list(layouts))
        # A negative index makes the kernel ask Python for every message.
        if inputs is None:
            self._messages["first_value"] = -1
        self._packed_us: np.ndarray = self._messages["packed_us"]
        self._n_parts: np.ndarray = self._messages["n_parts"]
        self._sizes = [layout.size for layout in layouts]
        self._starts: list[int] = self._messages["payload_start"].tolist()
        room_bytes = MOST_PARTS * sum(self._sizes)
        self._room_bytes = room_bytes + MOST_PARTS * OVERHEAD_BYTES * len(layouts)
        self._payloads = np.zeros(room_bytes, np.uint8)
        self._bytes = self._payloads.data
        self._wanted = np.zeros(len(layouts), np.int64)
        self._types = value_types()
        self._addresses = np.zeros(0, np.int64)
        self._streamer = np.zeros(1, STREAMER_DTYPE)
        self._numbers = self._streamer.data.cast("B").cast("q")
        record: np.void = self._streamer[0]
        record["filled_us"], record["n_messages"] = -1, len(layouts)
        arrays = {
            "messages": self._messages,
            "wanted": self._wanted,
            "payloads": self._payloads,
            "types": self._types,
        }
        if inputs is not None:
            arrays |= {"view": inputs.view, "values": inputs.values}
            record["plant_address"] = inputs.plant_address
        for name, array in arrays.items():
            record[f"{name}_address"] = array.ctypes.data

    def is_filled(self, index: int) -> bool:
        """Return true if the kernel fills a message, and Python does not pack it."""
        return bool(self._messages["first_value"][index] >= 0)

    def new_partner(
        self, partner: np.ndarray, is_due: np.ndarray, system_id: int, component_id: int
    ) -> Streamed:
        """Prepare to stream to a partner.

        Args:
            partner: Record of `PARTNER_DTYPE`, which is changed.
            is_due: Flags of the messages that are due, one for each, which the caller sets.
            system_id: System id of the sender.
            component_id: Component id of the sender.

        Returns:
            The partner, for `serve`.
        """
        partner["system_id"], partner["component_id"] = system_id, component_id
        return Streamed(partner, is_due, self._room_bytes)

    def serve(self, partners: Sequence[Streamed]) -> None:
        """Stream to these partners from now on."""
        # Kept as an attribute: the kernel reads the addresses by its own address.
        self._addresses = np.array([p.partner.ctypes.data for p in partners], np.int64)
        self._streamer["partners_address"] = self._addresses.ctypes.data
        self._streamer["n_partners"] = len(partners)

    def stream(self, now_us: int, pack: Callable[[int], tuple[bytes, ...]]) -> int:
        """Frame the due messages of this tick.

        Args:
            now_us: Simulated time.
            pack: Packs the parts of a message that the kernel does not fill, by its index.

        Returns:
            Time at which a message is due again, if neither rates nor partners change.
        """
        if self._inputs is not None:
            self._inputs.listen()
        n_wanted = stream(self._streamer, now_us, _ANY)
        if n_wanted:
            for index in self._wanted[:n_wanted].tolist():
                self._put(index, now_us, pack(index))
            stream(self._streamer, now_us, _ANY)
        return self._numbers[_NEXT_US]

    def fill(self, index: int, now_us: int) -> tuple[bytes, ...]:
        """Return the present payloads of a message that the kernel fills.

        Args:
            index: Index of the message.
            now_us: Simulated time.

        Returns:
            A payload for each instance of the message; none while its content is unknown.
        """
        if self._inputs is not None:
            self._inputs.listen()
        stream(self._streamer, now_us, index)
        return tuple(self.payloads(index))

    def payloads(self, index: int) -> Iterator[bytes]:
        """Yield the parts of a message as packed last."""
        start, size = self._starts[index], self._sizes[index]
        for part in range(self._n_parts[index]):
            yield bytes(self._bytes[start + part * size : start + (part + 1) * size])

    def _put(self, index: int, now_us: int, parts: tuple[bytes, ...]) -> None:
        joined, start = b"".join(parts[:MOST_PARTS]), self._starts[index]
        self._bytes[start : start + len(joined)] = joined
        self._n_parts[index] = min(MOST_PARTS, len(parts))
        self._packed_us[index] = now_us
