"""Client end of MAVLink in tests: pymavlink's own encoder and decoder."""

from __future__ import annotations

import time
from collections.abc import Iterable, Sequence
from functools import cached_property
from typing import Any

from flightsim.mavlink.channel import Channel
from flightsim.mavlink.dialect import dialect, layout


class Wire:
    """Encodes messages as a ground station does, and decodes those of a vehicle."""

    def __init__(self, system_id: int = 255, component_id: int = 190, *, is_version_1=False):
        self._encoder = dialect.MAVLink(None, system_id, component_id)
        self._decoder = dialect.MAVLink(None)
        self._decoder.robust_parsing = True
        self.is_version_1 = is_version_1

    def sign(self, key: bytes | None, seconds: float | None = None, *, link_id: int = 0) -> None:
        """Sign from now on and believe signed messages only, as pymavlink does; None ends that."""
        now_s = time.time() if seconds is None else seconds
        for end in (self._encoder, self._decoder):
            end.signing.secret_key = key
            end.signing.link_id = link_id
            end.signing.timestamp = int((now_s - 1_420_070_400) * 100_000)
        self._encoder.signing.sign_outgoing = key is not None

    def encode(self, name: str, *values: Any, **named: Any) -> bytes:
        """Frame of the message with this name."""
        message = dialect.mavlink_map[layout(name).message_id](*values, **named)
        frame = message.pack(self._encoder, force_mavlink1=self.is_version_1)
        self._encoder.seq = (self._encoder.seq + 1) % 256
        return bytes(frame)

    def decode(self, data: bytes) -> list[Any]:
        """All messages in the bytes."""
        return self._decoder.parse_buffer(data) or []


class Heard(Sequence[Any]):
    """Messages of some ticks. Most are never looked at, and decoding costs more than the flight."""

    def __init__(self, wire: Wire, data: bytes):
        self._wire, self._data = wire, data

    @cached_property
    def _messages(self) -> list[Any]:
        return self._wire.decode(self._data)

    def __len__(self) -> int:
        return len(self._messages)

    def __getitem__(self, index: Any) -> Any:
        return self._messages[index]


class Loop:
    """Channel without a socket, with a record of what was written and a manual clock."""

    def __init__(self, *, is_version_1: bool = False):
        self.now_s = 0.0
        self.wire = Wire(is_version_1=is_version_1)
        self.sent = bytearray()
        self.channel = Channel(
            "loop",
            lambda frames: self.sent.extend(b"".join(frames)),
            profile="normal",
            clock=lambda: self.now_s,
            is_datagram=False,
        )

    def deliver(self, name: str, *values: Any, **named: Any) -> list[Any]:
        """Send a message to the vehicle and return what its channel holds for the services."""
        self.channel.receive(self.wire.encode(name, *values, **named))
        return self.channel.take_messages()

    def answers(self) -> list[Any]:
        """Messages that the vehicle sent since the last call."""
        self.channel.flush()
        data = bytes(self.sent)
        self.sent.clear()
        return self.wire.decode(data)


def named(messages: Iterable[Any], name: str) -> list[Any]:
    """Messages of one type."""
    return [message for message in messages if message.get_type() == name]
