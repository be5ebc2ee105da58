"""A vehicle under fire, beside its twin that nobody talks to."""

from __future__ import annotations

import contextlib
import itertools
import math
import socket
from collections.abc import Iterator, Sequence
from typing import Literal, Protocol

from aeroscene.sources import open_scene
from flightsim.mavlink.dialect import LAYOUTS
from flightsim.mavlink.dialect import dialect as mav
from flightsim.mavlink.links import InProcessLink, Link, TcpServerLink, UdpLink
from flightsim.testbench import Testbench, TestbenchCfg

LinkName = Literal["in-process", "udp", "tcp"]
LINKS: tuple[LinkName, ...] = ("in-process", "udp", "tcp")
FRAMES_PER_TICK = 20
"""As many as one client may send without losing any."""
HEIGHT_M = 10.0
_LOWEST_M, _FARTHEST_M = 1.0, 1e3
"""Beyond these a vehicle starts again, so that hostile traffic meets a flight."""
_SETTLE_S = 30.0
_SILENCE: Iterator[bytes] = iter(())
_PING = LAYOUTS["PING"]


class Client(Protocol):
    """A client that sends whole frames and throws away what it gets."""

    def send(self, data: bytes) -> None:
        """Send one or more frames."""
        ...

    def recv(self) -> bytes:
        """What came, possibly nothing."""
        ...


class _SocketClient:
    def __init__(self, link: socket.socket, address: tuple[str, int]) -> None:
        link.connect(address)
        link.setblocking(False)
        self._socket = link

    def send(self, data: bytes) -> None:
        with contextlib.suppress(BlockingIOError):
            self._socket.send(data)

    def recv(self) -> bytes:
        data = b""
        with contextlib.suppress(BlockingIOError):
            while more := self._socket.recv(1 << 16):
                data = more
        return data

    def close(self) -> None:
        self._socket.close()


class DeadVehicleError(AssertionError):
    """The vehicle no longer answers an honest client."""


class Vehicle:
    """A hovering vehicle on the field, with hostile clients on a link and an honest one beside."""

    def __init__(self, link: LinkName | None, n_clients: int = 1, personality: str = "px4") -> None:
        """Take off and hover.

        Args:
            link: Link of the hostile clients; None for a twin that has none.
            n_clients: Number of hostile clients.
            personality: Flight stack that the vehicle imitates.
        """
        self._stack = contextlib.ExitStack()
        ports = _free_ports()
        links: list[Link] = []
        if link == "udp":
            links = [UdpLink(local_port=ports[0], remote_port=ports[1])]
        elif link == "tcp":
            links = [TcpServerLink(port=ports[2])]
        elif link == "in-process":
            links = [InProcessLink() for _ in range(n_clients)]
        cfg = TestbenchCfg(speed="max", seed=1, personality=personality)
        bench = Testbench(open_scene("field"), cfg, has_network=False, extra_links=links)
        self.bench = self._stack.enter_context(bench)
        self.take_off()
        n_clients = 0 if link is None else n_clients
        self.clients = [self._client(link, links, ports, index) for index in range(n_clients)]
        self._links = links
        self._n_pings = 0

    def take_off(self) -> None:
        """Climb to the height and come to rest there."""
        bench, autopilot = self.bench, self.bench.autopilot
        bench.run(5.0)
        autopilot.parameters.reset()
        autopilot.parameters.set("MIS_TAKEOFF_ALT", HEIGHT_M)
        autopilot.parameters.set("GF_ACTION", 0)  # Hostile fences are none to be obeyed here.
        autopilot.arm()
        autopilot.takeoff()
        bench.run(_SETTLE_S)

    def _client(
        self, link: LinkName | None, links: Sequence[Link], ports: Sequence[int], index: int
    ) -> Client:
        if link == "in-process":
            found = links[index]
            assert isinstance(found, InProcessLink)
            return found.client
        kind = socket.SOCK_DGRAM if link == "udp" else socket.SOCK_STREAM
        raw = socket.socket(socket.AF_INET, kind)
        client = _SocketClient(raw, ("127.0.0.1", ports[0 if link == "udp" else 2]))
        self._stack.callback(client.close)
        return client

    @property
    def n_received(self) -> int:
        """Number of valid messages that the hostile clients have brought through."""
        return sum(channel.n_received for link in self._links for channel in link.channels)

    @property
    def is_flying(self) -> bool:
        """Whether it is armed, up and near."""
        x, y, z = self.bench.plant.truth.position_enu_m
        return self.bench.autopilot.is_armed and z > _LOWEST_M and math.hypot(x, y) < _FARTHEST_M

    def tick(self, traffic: Iterator[bytes] = _SILENCE) -> None:
        """Let each hostile client send, and step by 20 ms."""
        for client in self.clients:
            for data in itertools.islice(traffic, FRAMES_PER_TICK):
                client.send(data)
        self.bench.simulator.step()
        for client in self.clients:
            client.recv()

    def require_life(self) -> None:
        """Hold that an honest client is answered within a tick.

        Raises:
            DeadVehicleError: If it is not.
        """
        client = self.bench.pilot_link.client
        client.recv()
        self._n_pings += 1
        payload = _PING.encode(seq=self._n_pings)
        client.send(_PING.frame_v2(payload, 0, 77, 190))
        self.bench.simulator.step()
        decoder = mav.MAVLink(None)
        decoder.robust_parsing = True
        came = decoder.parse_buffer(client.recv()) or []
        answers = [m.to_dict() for m in came if m.get_type() == "PING"]
        if not any(answer["seq"] == self._n_pings for answer in answers):
            raise DeadVehicleError("an honest client's ping was not answered")

    def close(self) -> None:
        """Close every link."""
        self._stack.close()


def _free_ports() -> list[int]:
    """Three ports that nothing has: two of UDP and one of TCP."""
    with contextlib.ExitStack() as stack:
        kinds = (socket.SOCK_DGRAM, socket.SOCK_DGRAM, socket.SOCK_STREAM)
        probes = [stack.enter_context(socket.socket(socket.AF_INET, kind)) for kind in kinds]
        for probe in probes:
            probe.bind(("127.0.0.1", 0))
        return [probe.getsockname()[1] for probe in probes]
