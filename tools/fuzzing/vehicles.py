"""Vehicle under fire, beside a twin that nobody talks to."""

from __future__ import annotations

import contextlib
import itertools
import math
from collections.abc import Iterator

from aeroscene.sources import load_scene
from flightsim.mavlink.dialect import LAYOUTS
from flightsim.mavlink.dialect import dialect as mav
from flightsim.testbench import Testbench, TestbenchCfg
from fuzzing.clients import Access, LinkName

FRAMES_PER_TICK = 20
"""Number of frames that one client may send in a tick without losing any."""
HEIGHT_M = 10.0
_LOWEST_M, _FARTHEST_M = 1.0, 1e3
"""Height and distance at which a vehicle starts again, so that hostile traffic meets a flight."""
_SETTLE_S = 30.0  # to climb, and for the hover to become still
_LEAST_CHARGE = 0.3
"""Charge at which a battery is changed; with less, an autopilot soon flies home."""
_TICK_S = 0.02
_SILENCE: Iterator[bytes] = iter(())
_PING = LAYOUTS["PING"]


class DeadVehicleError(AssertionError):
    """The vehicle no longer answers an honest client."""


class Vehicle:
    """A hovering vehicle on the field, with hostile clients on a link and an honest one beside."""

    def __init__(self, link: LinkName | None, n_clients: int = 1, personality: str = "px4") -> None:
        """Take off and hover.

        Args:
            link: Link of the hostile clients; None for a twin that has none.
            n_clients: Number of hostile clients; a serial line has one.
            personality: Flight stack that the vehicle imitates.
        """
        self._stack = contextlib.ExitStack()
        self._access = self._stack.enter_context(Access(link, n_clients))
        cfg = TestbenchCfg(speed="max", seed=1, personality=personality)
        bench = Testbench(load_scene("field"), cfg, has_network=False, links=[self._access.links])
        self.bench = self._stack.enter_context(bench)
        self.take_off()
        self.clients = self._access.connect()
        self._n_pings = 0

    def take_off(self) -> None:
        """Climb to the height and come to rest there."""
        bench, autopilot = self.bench, self.bench.autopilot
        # The estimator settles on the ground before it lets the vehicle arm.
        bench.run(5.0)
        autopilot.parameters.reset()
        autopilot.parameters.set("MIS_TAKEOFF_ALT", HEIGHT_M)
        autopilot.parameters.set("GF_ACTION", 0)  # Hostile fences are none to be obeyed here.
        autopilot.arm()
        autopilot.takeoff()
        bench.run(_SETTLE_S)

    @property
    def n_received(self) -> int:
        """Number of valid messages from hostile clients that the vehicle has received."""
        return sum(channel.n_received for link in self._access.links for channel in link.channels)

    @property
    def is_flying(self) -> bool:
        """True if the vehicle is armed, up and near."""
        x, y, z = self.bench.plant.truth.position_enu_m
        return self.bench.autopilot.is_armed and z > _LOWEST_M and math.hypot(x, y) < _FARTHEST_M

    @property
    def is_spent(self) -> bool:
        """True if the battery has to be changed."""
        return self.bench.plant.battery.remaining < _LEAST_CHARGE

    def tick(self, traffic: Iterator[bytes] = _SILENCE) -> None:
        """Let each hostile client send its frames, and step by 20 ms.

        Args:
            traffic: Frames to send; an empty one is left out, and counts as sent.
        """
        for client in self.clients:
            for data in filter(None, itertools.islice(traffic, FRAMES_PER_TICK)):
                client.send(data)
        self._access.now_s += _TICK_S
        self.bench.simulator.step()
        # Read, so that no buffer fills up and blocks the vehicle.
        for client in self.clients:
            client.recv()

    def require_life(self) -> None:
        """Hold that an honest client is answered within a tick.

        Raises:
            DeadVehicleError: If no answer with the right number comes.
        """
        client = self.bench.stack.pipe()
        # Answers of earlier ticks are thrown away.
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
        """Close every link, and the testbench."""
        self._stack.close()
