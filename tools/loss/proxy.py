"""A UDP proxy that loses a share of the datagrams of both directions, drawn from a seed."""

from __future__ import annotations

import contextlib
import random
import socket
from collections.abc import Iterator

Address = tuple[str, int]


class LossyProxy:
    """A proxy between one client and the vehicle, which carries nothing until it is asked to.

    To carry only on request makes the order of the draws, and so the losses, the same in every run.

    Attributes:
        n_carried: Number of datagrams that came through.
        n_lost: Number of those that did not.
    """

    def __init__(self, client: Address, share: float, seed: int) -> None:
        """Open both ends.

        Args:
            client: Address of the client.
            share: Share of the datagrams that is lost, 0 to 1.
            seed: Seed of the draws.
        """
        self.n_carried = self.n_lost = 0
        self._client = client
        self._vehicle: Address | None = None
        self._share = share
        self._rng = random.Random(seed)
        self._to_client, self._to_vehicle = (_loopback() for _ in range(2))

    @property
    def client_port(self) -> int:
        """Port that the client sends to."""
        return self._to_client.getsockname()[1]

    @property
    def vehicle_port(self) -> int:
        """Port that the vehicle sends to."""
        return self._to_vehicle.getsockname()[1]

    def carry(self) -> None:
        """Pass on, or lose, each datagram that waits at either end."""
        for data, sender in _waiting(self._to_vehicle):
            self._vehicle = sender
            self._pass(self._to_client, data, self._client)
        # The vehicle speaks first: until then its address is unknown.
        for data, _ in _waiting(self._to_client):
            if self._vehicle is not None:
                self._pass(self._to_vehicle, data, self._vehicle)

    def close(self) -> None:
        """Close both ends."""
        self._to_client.close()
        self._to_vehicle.close()

    def _pass(self, out: socket.socket, data: bytes, address: Address) -> None:
        if self._rng.random() < self._share:
            self.n_lost += 1
            return
        self.n_carried += 1
        out.sendto(data, address)


def _loopback() -> socket.socket:
    opened = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    opened.bind(("127.0.0.1", 0))
    opened.setblocking(False)
    return opened


def _waiting(end: socket.socket) -> Iterator[tuple[bytes, Address]]:
    with contextlib.suppress(BlockingIOError):
        while True:
            yield end.recvfrom(1 << 16)
