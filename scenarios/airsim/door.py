"""The door for AirSim's clients of one run: opens a port, and answers for every vehicle."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from typing import Self

from flightsim.mavlink.client import MavlinkClient
from flightsim.testbench import TestbenchError, Vehicle
from scenarios.airsim.cameras import Renderers, default_cameras
from scenarios.airsim.clock import Clock
from scenarios.airsim.control_calls import ControlCalls
from scenarios.airsim.craft import Contacts, Craft, Names
from scenarios.airsim.drawing_calls import DrawingCalls
from scenarios.airsim.flyer import Flyer
from scenarios.airsim.image_calls import ImageCalls
from scenarios.airsim.methods import Methods, RpcError
from scenarios.airsim.not_offered import NOT_OFFERED
from scenarios.airsim.objects import Objects
from scenarios.airsim.server import RpcServer, ServerError
from scenarios.airsim.state_calls import StateCalls
from scenarios.airsim.weather import Weather
from scenarios.airsim.world_calls import WorldCalls

PORT = 41451
"""Port of AirSim's clients."""
_SHARE_S = 0.01
"""Wall time for calls between two ticks of a run that is late, or as fast as it goes."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Guest:
    """A vehicle of the run, as the door needs it."""

    vehicle: Vehicle
    connect: Callable[[], MavlinkClient] | None
    """Connects a companion; None where a pilot of this process flies, which clients only watch."""


class AirsimDoor:
    """Answers AirSim's calls between the ticks of a run.

    The simulation calls `on_tick` after each tick, `may_step` before it, and `idle` in the place
    of sleeping.
    """

    def __init__(self, guests: Sequence[Guest], *, address: str, port: int) -> None:
        """Listen.

        Args:
            guests: The vehicles, in their order.
            address: Address to listen on; 127.0.0.1 keeps everything on this machine.
            port: TCP port.

        Raises:
            TestbenchError: If the port cannot be had.
        """
        self._stack = ExitStack()
        self._clock = Clock()
        self._plant = guests[0].vehicle.plant
        names = Names(world=self._plant.world)
        self._crafts = [_craft(guest, i, len(guests), names) for i, guest in enumerate(guests)]
        self._by_name = {craft.name: craft for craft in self._crafts}
        names.vehicles += self._by_name
        try:
            methods = self._methods(names)
            self._server = RpcServer(address, port, methods.dispatch)
        except ServerError as error:
            self._stack.close()
            raise TestbenchError(
                f"airsim port {error}; valid: --airsim-port with a port that is free"
            ) from None
        except BaseException:
            self._stack.close()
            raise

    def _methods(self, names: Names) -> Methods:
        renderers = self._stack.enter_context(Renderers())
        objects, weather = Objects(self._crafts, names), Weather()
        cameras = {craft.name: default_cameras(craft.vehicle.airframe) for craft in self._crafts}
        methods = Methods(NOT_OFFERED)
        methods.add(
            WorldCalls(self._crafts, objects, self._clock, weather, "{}", frozenset()).functions
        )
        methods.add(ControlCalls(self._find).functions)
        methods.add(StateCalls(self._find).functions)
        methods.add(ImageCalls(self._find, cameras, renderers, objects, weather).functions)
        methods.add(DrawingCalls().functions)
        return methods

    @property
    def port(self) -> int:
        """Port on which the door listens."""
        return self._server.port

    def _find(self, name: str) -> Craft:
        """Vehicle by its name; an empty one is the first.

        Raises:
            RpcError: If there is none.
        """
        craft = self._by_name.get(name) if name else self._crafts[0]
        if craft is None:
            raise RpcError(f"vehicle {name[:80]!r} is unknown; valid: {', '.join(self._by_name)}")
        return craft

    def on_tick(self) -> None:
        """Fly and answer, after each tick."""
        self._clock.on_tick(self._plant.time_us)
        for craft in self._crafts:
            craft.contacts.on_tick()
            craft.flyer.on_tick()
        self._server.serve(0.0, _SHARE_S)

    def may_step(self, timeout_s: float) -> bool:
        """Whether time may pass; while it may not, calls are answered for a moment."""
        if not self._clock.may_pass:
            self._server.serve(timeout_s, _SHARE_S)
        return self._clock.may_pass

    def idle(self, seconds: float) -> None:
        """Answer calls for so long, in the place of sleeping."""
        end_s = time.perf_counter() + seconds
        while (left_s := end_s - time.perf_counter()) > 0.0:
            self._server.serve(left_s, left_s)

    def close(self) -> None:
        """Disconnect all clients, and give the port back."""
        self._server.close()
        self._stack.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()


def _craft(guest: Guest, number: int, n: int, names: Names) -> Craft:
    vehicle = guest.vehicle
    origin = vehicle.plant.truth.position_enu_m
    return Craft(
        name=f"Drone{number + 1}" if n > 1 else "SimpleFlight",
        vehicle=vehicle,
        flyer=Flyer(vehicle, guest.connect),
        origin_enu_m=origin,
        contacts=Contacts(vehicle, origin, names),
    )
