"""Testbench: a scene with its vehicles, their flight stacks, and MAVLink, in one loop.

It is the one place where the parts of a run are put together, for the command line, the tests and a
user's script alike. It builds all or nothing: if a port is taken or a vehicle cannot stand, those
that were opened before are closed again.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, closing
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Self

from aeroscene.scene import Scene
from flightsim.autopilot.autopilot import Autopilot
from flightsim.bridges import ExternalStack
from flightsim.environment.movers import MovingObstacle
from flightsim.frames import Geodetic, LocalFrame
from flightsim.looks.light import light_of
from flightsim.mavlink.client import MavlinkClient
from flightsim.mavlink.links import Link
from flightsim.mavlink.server import MavlinkServer
from flightsim.plant import Plant
from flightsim.simulator import Controller, Observer, Server, Simulator
from flightsim.testbench.cfg import MAX_INSTANCES, TestbenchCfg, TestbenchError
from flightsim.testbench.ended_vehicles import free_ended
from flightsim.testbench.vehicle import Vehicle
from flightsim.vehicles import Airframe, airframe_by_name
from flightsim.vehicles.camera_options import with_cameras
from flightsim.world import build_world


class Testbench:
    """A run with all of its parts, which owns those that must be closed.

    Vehicle i is instance `cfg.instance` + i: its system id and its ports follow from that, as if it
    had been started alone. The first one has all that there can be only once, such as a serial
    line.

    Attributes:
        vehicles: The vehicles, in their order.
        plant, airframe, stack: Those of the first vehicle.
        frame: Frame of the scene on the earth.
        simulator: Simulation loop; its `run` and `step` advance time.
        observers: Called in this order at the end of each tick; append functions to watch.
    """

    def __init__(
        self,
        scene: Scene,
        cfg: TestbenchCfg,
        *,
        airframes: Sequence[Airframe] = (),
        traffic: Sequence[MovingObstacle] | None = None,
        has_network: bool = True,
        links: Sequence[Sequence[Link]] = (),
        captures: Path | None = None,
        has_video: bool = False,
    ) -> None:
        """Build the world of a scene and open the links of every vehicle, or nothing.

        Args:
            scene: Scene to fly in; the first vehicle has its start, the others places beside it.
            cfg: Settings of the simulation.
            airframes: Vehicles instead of the configured one.
            traffic: Movers on paths of their own instead of the configured ones.
            has_network: True lets clients outside this process connect.
            links: MAVLink links besides the in-process one and the network's, for the first
                vehicle, the second and so on.
            captures: Folder for photographs and films of the gimbal's camera, with a folder for
                each of several vehicles; None keeps none.
            has_video: True streams that camera's picture to a port of this machine.

        Raises:
            WorldError: If the start has not enough room, or a vehicle cannot stand.
            TrafficError: If the scene has no room for the traffic.
            PortInUseError: If a MAVLink port is taken.
            TestbenchError: If the folder cannot be made, there is no encoder for the video, the
                external flight stack cannot be had, or there are too many vehicles for it or for
                the ports.
        """
        # Before this one is built, the memory of those before it is needed.
        free_ended()
        self.cfg, self.scene = cfg, scene
        airframes = airframes or (airframe_by_name(cfg.vehicle),)
        _check_number(cfg, len(airframes))
        airframes = [with_cameras(airframe, cfg.camera) for airframe in airframes]
        world = build_world(
            scene,
            *airframes,
            traffic=cfg.traffic_cfg if traffic is None else traffic,
            light=light_of(cfg.weather, scene.latitude_deg, scene.longitude_deg),
        )
        # The first plant owns time, and makes those of the other vehicles.
        first = Plant(world, cfg.plant_cfg)
        self.frame = LocalFrame(Geodetic(scene.latitude_deg, scene.longitude_deg, scene.altitude_m))
        vehicle = partial(Vehicle, has_network=has_network, captures=captures, has_video=has_video)
        with ExitStack() as stack:
            self.vehicles = tuple(
                stack.enter_context(closing(vehicle(plant, self.frame, own_cfg, links=own_links)))
                for plant, own_cfg, own_links in _parts(first, cfg, links)
            )
            # All are open: from here on `close` closes them, and leaving the block does not.
            self._stack = stack.pop_all()
        self.plant, self.airframe, self.stack = first, airframes[0], self.vehicles[0].stack
        # Lidars first, so a user's observer finds the scan of this tick.
        self.observers: list[Observer] = [each.lidar.update for each in self.vehicles if each.lidar]
        if cfg.fail != "none":
            self.observers += [each.failures.update for each in self.vehicles]
        self.simulator = Simulator(
            first,
            _Controllers([vehicle.controller for vehicle in self.vehicles]),
            _Servers([vehicle.server for vehicle in self.vehicles]),
            observers=self.observers,
            speed=cfg.speed,
        )

    @property
    def autopilot(self) -> Autopilot:
        """Our autopilot of the first vehicle.

        Raises:
            TestbenchError: If an external flight stack flies.
        """
        return self.vehicles[0].autopilot

    @property
    def server(self) -> MavlinkServer:
        """MAVLink server of the first vehicle's autopilot.

        Raises:
            TestbenchError: If an external flight stack flies.
        """
        return self.vehicles[0].own.server

    @property
    def external(self) -> ExternalStack | None:
        """External flight stack that flies; None if our autopilot does."""
        return self.vehicles[0].external

    @property
    def fault(self) -> str:
        """Words that say why time will pass no more; empty while it passes."""
        return next((fault for each in self.vehicles if (fault := each.stack.fault)), "")

    def connect(self) -> MavlinkClient:
        """Return a new companion of the first vehicle; see `Vehicle.connect`."""
        return self.vehicles[0].connect()

    def run(self, seconds: float, until: Callable[[], bool] | None = None) -> None:
        """Advance simulated time at the configured speed.

        Args:
            seconds: Greatest advance, of simulated time.
            until: Called before each tick; once it returns True the run ends.
        """
        self.simulator.run(until_us=self.plant.time_us + round(seconds * 1e6), stop=until)

    def close(self) -> None:
        """Close every link, and end the flight stacks."""
        self._stack.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()


class _Controllers:
    """Controllers of all vehicles as one."""

    def __init__(self, controllers: Sequence[Controller]) -> None:
        self._controllers = controllers

    def update(self) -> None:
        for controller in self._controllers:
            controller.update()


class _Servers:
    """Servers of all vehicles as one; time passes when each of them lets it."""

    def __init__(self, servers: Sequence[Server]) -> None:
        self._servers = servers

    def update(self) -> None:
        for server in self._servers:
            server.update()

    def wait_for_tick(self, timeout_s: float) -> bool:
        return all(server.wait_for_tick(timeout_s) for server in self._servers)


def _parts(
    first: Plant, cfg: TestbenchCfg, links: Sequence[Sequence[Link]]
) -> Iterator[tuple[Plant, TestbenchCfg, Sequence[Link]]]:
    """Yield plant, settings and links of each vehicle.

    Instances count up, and only the first has the serial line.
    """
    for i, plant in enumerate((first, *first.other_plants)):
        own = replace(cfg, instance=cfg.instance + i, serial="" if i else cfg.serial)
        yield plant, own, links[i] if i < len(links) else ()


def _check_number(cfg: TestbenchCfg, n: int) -> None:
    """Refuse several vehicles of another flight stack, and more than there are instances.

    Raises:
        TestbenchError: If the number is too large.
    """
    if cfg.autopilot != "builtin" and n > 1:
        raise TestbenchError(
            f"vehicles {n} are our autopilot's, and {cfg.autopilot} flies; valid: "
            "--autopilot builtin, or one vehicle"
        )
    last = cfg.instance + n - 1
    if last >= MAX_INSTANCES:
        raise TestbenchError(
            f"vehicles {n} from instance {cfg.instance} on reach instance {last}; "
            f"valid: up to {MAX_INSTANCES - 1}"
        )
