"""File transfer: a small read-only tree of the vehicle's own, with no file of the host in it.

https://mavlink.io/en/services/ftp.html. Files are bytes in memory, found by their whole path, so
that no path leads out. A well-formed refusal matters: MAVProxy waits 11 s after one that it cannot
parse.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass

from flightsim.mavlink.channel import Channel
from flightsim.mavlink.crc32 import crc32
from flightsim.mavlink.parsing import Message
from flightsim.mavlink.service import Handler, send

Tree = Callable[[], Mapping[str, bytes | bytearray]]
"""Finds the files: bytes by path, such as `log/0.ulg`. Files may grow, and none is copied whole."""

_HEADER = struct.Struct("<HBBBBBxI")
"""Sequence, session, opcode, size, request, burst complete, padding, offset; the data follow."""
_DATA_BYTES = 239  # what a payload of 251 bytes leaves beside the header
_NONE, _TERMINATE, _RESET, _LIST, _OPEN, _READ, _CRC, _BURST = 0, 1, 2, 3, 4, 5, 14, 15
_WRITES = frozenset(range(6, 14))
_ACK, _NAK = 128, 129
_INVALID_SESSION, _NO_SESSION, _END_OF_FILE = 4, 5, 6
_UNKNOWN_COMMAND, _PROTECTED, _NOT_FOUND = 7, 9, 10
_MOST_SESSIONS = 8
"""Most files that a partner may have open at a time."""
_CHUNKS_PER_TICK = 8  # so that a burst shares the link with telemetry


@dataclass(frozen=True, kw_only=True)
class _Request:
    """One request, with its sender."""

    partner: tuple[int, int]
    sequence: int
    session: int
    opcode: int
    size: int
    offset: int
    data: bytes

    @property
    def path(self) -> str:
        """Path in the data, without slashes and dots around it."""
        return self.data.split(b"\0")[0].decode("utf-8", "replace").strip("/.")


@dataclass
class _Burst:
    """The rest of a file that is sent without further requests."""

    request: _Request
    sequence: int
    offset: int


@dataclass
class _Session:
    """A file that a partner reads, with the size that it had when it was opened."""

    data: bytes | bytearray
    size: int
    burst: _Burst | None = None


class FtpError(Exception):
    """A request is refused; `code` is the protocol's error number."""

    def __init__(self, code: int) -> None:
        super().__init__(f"refused with error {code}")
        self.code = code


class FileService:
    """Answers requests to list and read.

    A session has the number with which the client opened it, as in ArduPilot. Clients may begin the
    next session before they end one.
    """

    def __init__(self, tree: Tree) -> None:
        self._tree = tree
        self._sessions: dict[Channel, dict[int, _Session]] = {}
        self.handlers: Mapping[str, Handler] = {"FILE_TRANSFER_PROTOCOL": self._on_ftp}

    @property
    def busy(self) -> Collection[Channel]:
        """Partners that have files open."""
        return self._sessions

    def update(self, channel: Channel) -> None:
        """Continue the bursts of a partner, by at most 8 chunks a tick for each file.

        A burst sends a file without being asked for each chunk; all at once it would block the
        link.
        """
        for session in self._sessions[channel].values():
            for _ in range(_CHUNKS_PER_TICK):
                burst = session.burst
                if burst is None:
                    break
                end = min(burst.offset + _chunk_bytes(burst.request), session.size)
                is_last = end >= session.size
                piece = bytes(session.data[burst.offset : end])
                _send(channel, burst.request, _ACK, piece, burst.offset, burst.sequence, is_last)
                burst.offset = end
                burst.sequence += 1
                if is_last:
                    session.burst = None

    def forget(self, channel: Channel) -> None:
        """Close the files of a partner that left."""
        self._sessions.pop(channel, None)

    def _on_ftp(self, channel: Channel, message: Message) -> None:
        payload = bytes(message.payload)
        sequence, session, opcode, size, _, _, offset = _HEADER.unpack_from(payload)
        if opcode in {_ACK, _NAK}:
            return  # an answer meant for another system
        request = _Request(
            partner=(message.get_srcSystem(), message.get_srcComponent()),
            sequence=sequence,
            session=session,
            opcode=opcode,
            size=size,
            offset=offset,
            data=payload[_HEADER.size : _HEADER.size + min(size, _DATA_BYTES)],
        )
        session = self._sessions.get(channel, {}).get(request.session)
        # Any request in a session ends its burst: the client has changed its mind.
        if session is not None:
            session.burst = None
        try:
            data = self._answer(channel, request)
        except FtpError as error:
            _send(channel, request, _NAK, bytes((error.code,)), offset)
            return
        if data is not None:
            _send(channel, request, _ACK, data, offset)

    def _answer(self, channel: Channel, request: _Request) -> bytes | None:
        """Return the data of the answer; None if it comes in a burst.

        Raises:
            FtpError: If the request is refused.
        """
        opcode = request.opcode
        if opcode == _NONE:
            return b""
        if opcode == _TERMINATE:
            self._close(channel, request.session)
            return b""
        if opcode == _RESET:
            self.forget(channel)
            return b""
        if opcode == _LIST:
            return self._list(request)
        if opcode in {_OPEN, _CRC}:
            data = self._file(request.path)
            if opcode == _CRC:
                return struct.pack("<I", crc32(data))
            self._open(channel, request.session, data)
            return struct.pack("<I", len(data))
        if opcode in {_READ, _BURST}:
            return self._read(channel, request)
        raise FtpError(_PROTECTED if opcode in _WRITES else _UNKNOWN_COMMAND)

    def _read(self, channel: Channel, request: _Request) -> bytes | None:
        session = self._sessions.get(channel, {}).get(request.session)
        if session is None:
            raise FtpError(_INVALID_SESSION)
        if request.offset >= session.size:
            raise FtpError(_END_OF_FILE)
        if request.opcode == _BURST:
            # Answers carry the number of the request plus one; each chunk of a burst counts on.
            session.burst = _Burst(request, request.sequence + 1, request.offset)
            return None
        end = min(request.offset + _chunk_bytes(request), session.size)
        return bytes(session.data[request.offset : end])

    def _open(self, channel: Channel, number: int, data: bytes | bytearray) -> None:
        sessions = self._sessions.setdefault(channel, {})
        if number not in sessions and len(sessions) == _MOST_SESSIONS:
            raise FtpError(_NO_SESSION)
        sessions[number] = _Session(data, len(data))

    def _close(self, channel: Channel, number: int) -> None:
        sessions = self._sessions.get(channel, {})
        sessions.pop(number, None)
        if not sessions:
            self.forget(channel)

    def _file(self, path: str) -> bytes | bytearray:
        data = self._tree().get(path.partition("?")[0])  # ArduPilot's stations append options
        if data is None:
            raise FtpError(_NOT_FOUND)
        return data

    def _list(self, request: _Request) -> bytes:
        """Return entries of a directory from the one that the offset counts, as many as fit."""
        prefix = f"{request.path}/" if request.path else ""
        below = {
            path[len(prefix) :]: data
            for path, data in self._tree().items()
            if path.startswith(prefix)
        }
        if prefix and not below:
            raise FtpError(_NOT_FOUND)
        entries = sorted(
            # A set: a directory appears once, however many files are below it.
            {
                f"D{name.split('/', 1)[0]}" if "/" in name else f"F{name}\t{len(data)}"
                for name, data in below.items()
            }
        )
        if request.offset >= len(entries):
            raise FtpError(_END_OF_FILE)
        listed = b""
        for entry in entries[request.offset :]:
            line = entry.encode() + b"\0"
            if len(listed) + len(line) > _DATA_BYTES:
                break
            listed += line
        return listed


def _chunk_bytes(request: _Request) -> int:
    return min(request.size, _DATA_BYTES) or _DATA_BYTES


def _send(
    channel: Channel,
    request: _Request,
    opcode: int,
    data: bytes,
    offset: int,
    sequence: int | None = None,
    is_last: bool = False,
) -> None:
    number = request.sequence + 1 if sequence is None else sequence
    header = _HEADER.pack(
        number & 0xFFFF, request.session, opcode, len(data), request.opcode, int(is_last), offset
    )
    send(
        channel,
        "FILE_TRANSFER_PROTOCOL",
        target_system=request.partner[0],
        target_component=request.partner[1],
        payload=header + data,
    )
