"""A client that shares the thread of the simulation: time passes while it waits for answers."""

import itertools
import socket
from typing import Any

import msgspec

from scenarios.run.sitl import Sitl

_PATIENCE_TICKS = 12_000
"""Four minutes of simulated time."""


class CallError(Exception):
    """The server has answered with an error."""


class Caller:
    """Calls the methods of a run; the simulation is stepped until the answer has come."""

    def __init__(self, sitl: Sitl, port: int) -> None:
        self.sitl = sitl
        self._socket = socket.create_connection(("127.0.0.1", port))
        self._socket.setblocking(False)
        self._numbers = itertools.count(1)
        self._data = b""

    def call(self, method: str, *args: object) -> Any:
        """Answer of a call.

        Raises:
            CallError: If it is an error.
        """
        return self.wait(self.send(method, *args))

    def send(self, method: str, *args: object) -> int:
        """Begin a call; its number."""
        number = next(self._numbers)
        self._socket.sendall(msgspec.msgpack.encode([0, number, method, list(args)]))
        return number

    def wait(self, number: int) -> Any:
        """Step until a call is answered."""
        for _ in range(_PATIENCE_TICKS):
            self.tick()
            try:
                self._data += self._socket.recv(1 << 24)
            except BlockingIOError:
                continue
            try:
                kind, answered, error, result = msgspec.msgpack.decode(self._data)
            except msgspec.DecodeError:
                continue  # It has not come whole.
            self._data = b""
            assert (kind, answered) == (1, number)
            if error is not None:
                raise CallError(error)
            return result
        raise TimeoutError

    def tick(self) -> None:
        """Let a tick pass, unless time stands still."""
        simulator = self.sitl.bench.simulator
        interlude = simulator.interlude
        assert interlude is not None
        if interlude.may_step(0.0):
            simulator.step()

    def close(self) -> None:
        """Disconnect."""
        self._socket.close()


def vector(x: float, y: float, z: float) -> dict[str, float]:
    """A vector as clients send it."""
    return {"x_val": x, "y_val": y, "z_val": z}


def pose(x: float, y: float, z: float) -> dict[str, Any]:
    """A level pose that looks north."""
    level = {"w_val": 1.0, "x_val": 0.0, "y_val": 0.0, "z_val": 0.0}
    return {"position": vector(x, y, z), "orientation": level}
