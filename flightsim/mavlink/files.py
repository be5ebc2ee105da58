"""File transfer and log download: both are empty, and clients learn that at once.

A well-formed refusal matters: MAVProxy waits 11 s after one that it cannot parse.
"""

from __future__ import annotations

from collections.abc import Mapping

from flightsim.mavlink.channel import Channel
from flightsim.mavlink.parsing import Message
from flightsim.mavlink.service import Handler, send

# https://mavlink.io/en/services/ftp.html: seq 0..1, session 2, opcode 3, size 4, request 5,
# burst 6, offset 8..11, data from 12.
_HEADER_BYTES = 12
_PAYLOAD_BYTES = 251
_NONE, _TERMINATE_SESSION, _RESET_SESSIONS, _LAST_REQUEST = 0, 1, 2, 15
_ACK, _NAK = 128, 129
_LIST_DIRECTORY = 3
_END_OF_FILE, _UNKNOWN_COMMAND, _FILE_NOT_FOUND = 6, 7, 10
_KNOWN_OPCODES = range(_LAST_REQUEST + 1)


class FileService:
    """An empty file system and an empty list of logs."""

    def __init__(self) -> None:
        self.handlers: Mapping[str, Handler] = {
            "FILE_TRANSFER_PROTOCOL": self._on_ftp,
            "LOG_REQUEST_LIST": self._on_log_list,
            "LOG_REQUEST_DATA": self._on_log_data,
        }

    def _on_ftp(self, channel: Channel, message: Message) -> None:
        opcode = message.payload[3]
        if opcode in {_ACK, _NAK}:
            return  # an answer meant for another system
        send(
            channel,
            "FILE_TRANSFER_PROTOCOL",
            target_system=message.get_srcSystem(),
            target_component=message.get_srcComponent(),
            payload=_answer(message.payload),
        )

    def _on_log_list(self, channel: Channel, _: Message) -> None:
        send(channel, "LOG_ENTRY")  # log number 0 of 0

    def _on_log_data(self, channel: Channel, message: Message) -> None:
        # No bytes mean that the log has ended.
        send(channel, "LOG_DATA", id=message.id, ofs=message.ofs, count=0)


def _answer(request: list[int]) -> bytes:
    """Reply to an FTP request: its header with the next sequence number, and no data."""
    sequence = (request[0] + (request[1] << 8) + 1) & 0xFFFF
    session, opcode = request[2], request[3]
    answer = bytearray(_PAYLOAD_BYTES)
    answer[0:2] = sequence.to_bytes(2, "little")
    answer[2], answer[5] = session, opcode
    answer[8:12] = bytes(request[8:_HEADER_BYTES])
    if opcode in {_NONE, _TERMINATE_SESSION, _RESET_SESSIONS}:
        answer[3] = _ACK
        return bytes(answer)
    answer[3], answer[4] = _NAK, 1
    answer[12] = _refusal(opcode, bytes(request[_HEADER_BYTES : _HEADER_BYTES + request[4]]))
    return bytes(answer)


def _refusal(opcode: int, path: bytes) -> int:
    if opcode == _LIST_DIRECTORY and not path.strip(b"/.\0"):
        return _END_OF_FILE  # the root directory exists and is empty
    return _FILE_NOT_FOUND if opcode in _KNOWN_OPCODES else _UNKNOWN_COMMAND
