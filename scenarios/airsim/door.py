"""The door for AirSim's clients of one run: opens a port, and answers for every vehicle."""

from __future__ import annotations

import logging
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
from scenarios.airsim.objects import Objects
from scenarios.airsim.rangers import Rangers
from scenarios.airsim.server import RpcServer, ServerError
from scenarios.airsim.settings import PORT, AirsimSettings, VehicleSettings
from scenarios.airsim.starts import stand
from scenarios.airsim.state_calls import StateCalls
from scenarios.airsim.unsupported import NOT_OFFERED
from scenarios.airsim.weather import Weather, set_wind
from scenarios.airsim.world_calls import WorldCalls

_LOG = logging.getLogger(__name__)
_ADDRESS = "127.0.0.1"
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

    def __init__(
        self, guests: Sequence[Guest], settings: AirsimSettings, *, port: int = PORT
    ) -> None:
        """Listen on loopback, because the protocol knows neither encryption nor passwords.

        Args:
            guests: The vehicles, in their order.
            settings: Their names, cameras and sensors.
            port: TCP port; 0 lets the system choose.

        Raises:
            TestbenchError: If the port cannot be had.
        """
        self._stack = ExitStack()
        self._clock = Clock()
        self._plant = guests[0].vehicle.plant
        names = Names(world=self._plant.world)
        asked = settings.vehicles or _unnamed(len(guests))
        stand([guest.vehicle.plant for guest in guests], asked)
        self._crafts = [
            _craft(guest, each, names) for guest, each in zip(guests, asked, strict=True)
        ]
        self._by_name = {craft.name: craft for craft in self._crafts}
        names.vehicles += self._by_name
        if settings.wind is not None:
            set_wind([guest.vehicle.plant for guest in guests], settings.wind)
        if settings.ignored:
            _LOG.warning("airsim-settings: not honoured: %s", ", ".join(settings.ignored))
        methods = self._methods(settings, asked, names)
        self._names = methods.names
        try:
            self._server = RpcServer(_ADDRESS, port, methods.dispatch)
        except ServerError as error:
            self._stack.close()
            raise TestbenchError(
                f"airsim port {error}; valid: --airsim-port with a port that is free"
            ) from None

    def _methods(
        self, settings: AirsimSettings, asked: Sequence[VehicleSettings], names: Names
    ) -> Methods:
        renderers = self._stack.enter_context(Renderers())
        objects, weather = Objects(self._crafts, names), Weather()
        cameras = {
            craft.name: {
                **default_cameras(craft.vehicle.airframe, settings.lens, settings.lenses),
                **each.cameras,
            }
            for craft, each in zip(self._crafts, asked, strict=True)
        }
        waiting = frozenset(each.name for each in asked if not each.is_created)
        methods = Methods(NOT_OFFERED)
        world = WorldCalls(self._crafts, objects, self._clock, weather, settings.text, waiting)
        for calls in (
            world,
            ControlCalls(self._find),
            StateCalls(self._find),
            ImageCalls(self._find, cameras, renderers, objects, weather),
            DrawingCalls(),
        ):
            methods.add(calls.functions)
        return methods

    @property
    def port(self) -> int:
        """Port on which the door listens."""
        return self._server.port

    @property
    def method_names(self) -> frozenset[str]:
        """Methods that are offered."""
        return self._names

    @property
    def n_answered(self) -> int:
        """Calls so far, with those that were answered by an error."""
        return self._server.n_answered

    @property
    def n_faults(self) -> int:
        """Calls so far that failed by a fault of ours, not of the client's."""
        return self._server.n_faults

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
        """Return True if time may pass; otherwise answer calls for a moment."""
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


def _unnamed(n: int) -> list[VehicleSettings]:
    """Vehicles without settings: AirSim's name for the only one, numbers for several."""
    names = [f"Drone{number + 1}" for number in range(n)] if n > 1 else ["SimpleFlight"]
    return [VehicleSettings(name=name) for name in names]


def _craft(guest: Guest, settings: VehicleSettings, names: Names) -> Craft:
    vehicle = guest.vehicle
    origin = vehicle.plant.truth.position_enu_m
    return Craft(
        name=settings.name,
        vehicle=vehicle,
        flyer=Flyer(vehicle, guest.connect),
        origin_enu_m=origin,
        contacts=Contacts(vehicle, origin, names),
        rangers=Rangers(vehicle.plant, settings.distances, settings.lidars),
    )
