"""Log protocol: the list of flight logs, and their bytes, at a rate that clients can take."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass

from flightsim.environment.date import EPOCH_US
from flightsim.mavlink.channel import Channel
from flightsim.mavlink.logs.recorder import FlightRecorder
from flightsim.mavlink.parsing import Message
from flightsim.mavlink.service import Handler, send

_CHUNK_BYTES = 90  # data field of LOG_DATA
_CHUNKS_PER_TICK = 20  # 90 kB in a simulated second


@dataclass
class _Reading:
    """The rest of a log that a partner still wants."""

    log_id: int
    data: bytearray
    offset: int
    end: int


class LogService:
    """Serves the recorder's logs; the first has the number 0."""

    def __init__(self, recorder: FlightRecorder) -> None:
        self._recorder = recorder
        self._readings: dict[Channel, _Reading] = {}
        self.handlers: Mapping[str, Handler] = {
            "LOG_REQUEST_LIST": self._on_list,
            "LOG_REQUEST_DATA": self._on_data,
            "LOG_REQUEST_END": lambda channel, _: self.forget(channel),
            "LOG_ERASE": self._on_erase,
        }

    @property
    def busy(self) -> Collection[Channel]:
        """Partners that read a log."""
        return self._readings

    def update(self, channel: Channel) -> None:
        """Go on sending the log that a partner reads."""
        reading = self._readings.get(channel)
        if reading is None:
            return
        for _ in range(_CHUNKS_PER_TICK):
            end = min(reading.offset + _CHUNK_BYTES, reading.end)
            piece = bytes(reading.data[reading.offset : end])
            self._send(channel, reading.log_id, reading.offset, piece)
            reading.offset = end
            if end >= reading.end:
                del self._readings[channel]
                return

    def forget(self, channel: Channel) -> None:
        """Stop sending to a partner."""
        self._readings.pop(channel, None)

    def _on_list(self, channel: Channel, message: Message) -> None:
        logs = self._recorder.logs
        if not logs:
            send(channel, "LOG_ENTRY")  # log number 0 of 0
            return
        last = min(message.end, len(logs) - 1)
        for log_id in range(message.start, last + 1):
            send(
                channel,
                "LOG_ENTRY",
                id=log_id,
                num_logs=len(logs),
                last_log_num=len(logs) - 1,
                time_utc=(EPOCH_US + logs[log_id].started_us) // 1_000_000,
                size=len(logs[log_id].data),
            )

    def _on_data(self, channel: Channel, message: Message) -> None:
        logs = self._recorder.logs
        # A log that does not exist counts as empty: clients then stop asking.
        data = logs[message.id].data if message.id < len(logs) else bytearray()
        end = min(message.ofs + message.count, len(data))
        if message.ofs >= end:
            self._send(channel, message.id, message.ofs, b"")  # no bytes: the log has ended
            return
        self._readings[channel] = _Reading(message.id, data, message.ofs, end)

    def _on_erase(self, _: Channel, __: Message) -> None:
        self._recorder.erase()

    def _send(self, channel: Channel, log_id: int, offset: int, data: bytes) -> None:
        send(channel, "LOG_DATA", id=log_id, ofs=offset, count=len(data), data=data)
