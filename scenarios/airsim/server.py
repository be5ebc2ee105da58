"""Server for MessagePack-RPC that shares the thread of the simulation.

`serve` reads, answers and writes what is ready, and returns. The simulation calls it between two
ticks, so that a call sees one state of the world, and no lock is needed. Every buffer has a bound:
a client that floods, stalls or vanishes costs a little time and some megabytes at most.

Source: github.com/msgpack-rpc/msgpack-rpc, spec.md.
"""

from __future__ import annotations

import logging
import selectors
import socket
import time
from collections import deque
from collections.abc import Callable
from typing import Any

import msgspec

from scenarios.airsim.framing import FramingError, Splitter
from scenarios.airsim.methods import Later, RpcError

_LOG = logging.getLogger(__name__)

_REQUEST, _RESPONSE, _NOTIFY = 0, 1, 2
_READ_BYTES = 1 << 16
_MOST_CLIENTS = 64
_MOST_PENDING = 64
"""Calls of one client that may be in progress; further ones wait in its socket."""
_MOST_WAITING_BYTES = 64 << 20
"""Answers that wait for a client which does not read; beyond, it is disconnected."""
_PAUSE_READING_BYTES = 1 << 20
"""Answers that wait for a client before its next calls are read."""
_MOST_WARNINGS = 20

Dispatch = Callable[[str, list[Any]], object]
"""Answers a method with its arguments; a `Later` is an answer that comes when something is done."""


class ServerError(OSError):
    """The server's port cannot be opened."""


class RpcServer:
    """Listens on a port, and answers calls when `serve` is called."""

    def __init__(self, address: str, port: int, dispatch: Dispatch) -> None:
        """Listen.

        Args:
            address: Address to listen on; 127.0.0.1 is reached from this machine alone.
            port: TCP port; 0 lets the system choose.
            dispatch: Answers a call.

        Raises:
            ServerError: If the port cannot be had.
        """
        self._dispatch = dispatch
        self._selector = selectors.DefaultSelector()
        self._clients: set[_Client] = set()
        self._warnings = 0
        self.n_answered = 0
        """Calls so far, with those that were answered by an error."""
        self.n_faults = 0
        """Calls that failed by a fault of ours."""
        self._listener = socket.socket()
        self._listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            self._listener.bind((address, port))
            self._listener.listen(16)
        except (OSError, OverflowError) as error:
            self._listener.close()
            self._selector.close()
            raise ServerError(f"{address}:{port}: {error}") from None
        self._listener.setblocking(False)
        self._selector.register(self._listener, selectors.EVENT_READ, None)

    @property
    def port(self) -> int:
        """Port on which it listens."""
        return int(self._listener.getsockname()[1])

    @property
    def n_clients(self) -> int:
        """Number of clients that are connected."""
        return len(self._clients)

    def serve(self, wait_s: float, longest_s: float) -> None:
        """Answer what has come.

        Args:
            wait_s: Time to wait for a first byte.
            longest_s: Time after which calls are left for the next time, so that a flood cannot
                hold the simulation up.
        """
        end_s = time.perf_counter() + longest_s
        self._answer_waiting()
        is_first = True
        while True:
            has_backlog = any(each.has_backlog and each.may_work for each in self._clients)
            events = self._selector.select(wait_s if is_first and not has_backlog else 0.0)
            is_first = False
            if not events and not has_backlog:
                return
            for key, mask in events:
                if key.data is None:
                    self._accept()
                else:
                    self._attend(key.data, mask)
            for client in list(self._clients):
                self._work(client, end_s)
            if time.perf_counter() >= end_s:
                return

    def _accept(self) -> None:
        try:
            peer, _ = self._listener.accept()
        except OSError:
            return
        if len(self._clients) >= _MOST_CLIENTS:
            peer.close()
            self._warn(f"a client beyond {_MOST_CLIENTS} is not served")
            return
        peer.setblocking(False)
        peer.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        client = _Client(peer)
        self._clients.add(client)
        self._selector.register(peer, selectors.EVENT_READ, client)

    def _attend(self, client: _Client, mask: int) -> None:
        try:
            if mask & selectors.EVENT_READ:
                client.read()
            if mask & selectors.EVENT_WRITE:
                client.write()
        except OSError:
            self._drop(client)

    def _work(self, client: _Client, end_s: float) -> None:
        """Answer whole calls of a client while there is time and room for their answers."""
        try:
            while client.may_work and time.perf_counter() < end_s:
                if (message := client.splitter.take()) is None:
                    client.has_backlog = False
                    break
                self._handle(client, message)
            client.write()
        except FramingError as error:
            self._warn(f"a client is disconnected: {error}")
            self._drop(client)
            return
        except OSError:
            self._drop(client)
            return
        if client.is_over and not client.has_backlog and not client.pending and not client.out:
            self._drop(client)
            return
        self._watch(client)

    def _handle(self, client: _Client, message: bytes) -> None:
        try:
            parts = msgspec.msgpack.decode(message)
        except (msgspec.DecodeError, ValueError, TypeError, RecursionError) as error:
            raise FramingError(f"message cannot be decoded: {error}") from None
        if not isinstance(parts, list) or not parts:
            raise FramingError("message is no MessagePack-RPC")
        match parts:
            case [int(kind), int(number), str(method), list(args)] if kind == _REQUEST:
                self._call(client, number, method, args)
            case [int(kind), str(method), list(args)] if kind == _NOTIFY:
                self._call(client, None, method, args)
            case _:
                raise FramingError("message is no request of MessagePack-RPC")

    def _call(self, client: _Client, number: int | None, method: str, args: list[Any]) -> None:
        self.n_answered += 1
        try:
            result = self._dispatch(method, args)
        except RpcError as error:
            client.answer(number, str(error), None)
            return
        except Exception as error:  # a fault of ours must not end a flight  # noqa: BLE001
            self.n_faults += 1
            self._warn(f"{method[:80]!r} failed: {error!r}"[:500])
            client.answer(number, f"{method[:80]} failed: {error!r}"[:500], None)
            return
        if isinstance(result, Later) and not result.is_done:
            if number is not None:
                client.pending.append((number, result))
        elif isinstance(result, Later):
            client.answer(number, result.error, result.value)
        else:
            client.answer(number, None, result)

    def _answer_waiting(self) -> None:
        """Answer the calls that have become done since the last time."""
        for client in list(self._clients):
            done = [each for each in client.pending if each[1].is_done]
            if not done:
                continue
            client.pending = [each for each in client.pending if not each[1].is_done]
            for number, later in done:
                client.answer(number, later.error, later.value)
            try:
                client.write()
            except OSError:
                self._drop(client)
                continue
            self._watch(client)

    def _watch(self, client: _Client) -> None:
        """Wait for what a client can do next."""
        mask = selectors.EVENT_WRITE if client.out else 0
        if client.may_read:
            mask |= selectors.EVENT_READ
        try:
            if mask == client.mask:
                return
            if client.mask == 0:
                self._selector.register(client.peer, mask, client)
            elif mask == 0:
                self._selector.unregister(client.peer)
            else:
                self._selector.modify(client.peer, mask, client)
            client.mask = mask
        except (OSError, KeyError, ValueError):
            self._drop(client)

    def _drop(self, client: _Client) -> None:
        if client.mask:
            self._selector.unregister(client.peer)
        client.peer.close()
        self._clients.discard(client)

    def _warn(self, line: str) -> None:
        """Report a fault, a few times in a run."""
        self._warnings += 1
        if self._warnings <= _MOST_WARNINGS:
            _LOG.warning("AirSim: %s", line)
        if self._warnings == _MOST_WARNINGS:
            _LOG.warning("AirSim: further faults of clients are not reported")

    def close(self) -> None:
        """Disconnect everybody, and give the port back."""
        for client in list(self._clients):
            self._drop(client)
        self._selector.close()
        self._listener.close()


class _Client:
    """A connection with what has come and what has to go."""

    def __init__(self, peer: socket.socket) -> None:
        self.peer = peer
        self.splitter = Splitter()
        self.out: deque[memoryview] = deque()
        self.n_out = 0
        self.pending: list[tuple[int, Later]] = []
        self.mask: int = selectors.EVENT_READ
        self.has_backlog = False
        """True if the splitter may hold calls that were not looked at."""
        self.is_over = False
        """True if the client has closed its side."""

    @property
    def may_work(self) -> bool:
        """Return True if there is room for the answer to another call."""
        return len(self.pending) < _MOST_PENDING and self.n_out < _PAUSE_READING_BYTES

    @property
    def may_read(self) -> bool:
        """Return True if the connection should be read further."""
        return not self.is_over and not self.has_backlog and self.may_work

    def read(self) -> None:
        """Read what is there.

        Raises:
            OSError: If the connection is broken.
        """
        try:
            data = self.peer.recv(_READ_BYTES)
        except BlockingIOError:
            return
        if not data:
            self.is_over = True
            # Whoever has closed its side waits for nothing: calls in progress have no reader.
            self.pending.clear()
            return
        self.splitter.feed(data)
        self.has_backlog = True

    def answer(self, number: int | None, error: str | None, result: object) -> None:
        """Queue the answer of a call; a notification has no number, and gets none.

        Raises:
            OSError: If too many answers wait for this client.
        """
        if number is None:
            return
        try:
            data = msgspec.msgpack.encode((_RESPONSE, number, error, result))
        except (TypeError, ValueError, OverflowError) as fault:  # a fault of ours, not of a client
            line = f"the answer cannot be encoded: {fault}"
            data = msgspec.msgpack.encode((_RESPONSE, number, line, None))
        self.out.append(memoryview(data))
        self.n_out += len(data)
        if self.n_out > _MOST_WAITING_BYTES:
            raise OSError("a client reads no answers")

    def write(self) -> None:
        """Send what can be sent without waiting.

        Raises:
            OSError: If the connection is broken.
        """
        while self.out:
            try:
                n = self.peer.send(self.out[0])
            except BlockingIOError:
                return
            self.n_out -= n
            if n == len(self.out[0]):
                self.out.popleft()
            else:
                self.out[0] = self.out[0][n:]
