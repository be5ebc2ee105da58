"""Testbench: a scene with a vehicle, whoever flies it, and MAVLink, in one loop."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Self

from aeroscene.scene import Scene
from flightsim.autopilot.autopilot import Autopilot
from flightsim.bridges import BridgeError, ExternalStack
from flightsim.environment.movers import MovingObstacle
from flightsim.frames import Geodetic, LocalFrame
from flightsim.lidars import Lidar, lidar_by_name
from flightsim.mavlink.client import MavlinkClient
from flightsim.mavlink.links import InProcessLink, Link, LinkError
from flightsim.mavlink.server import MavlinkServer
from flightsim.payload import Payload, VideoError
from flightsim.plant import Plant
from flightsim.simulator import Controller, Server, Simulator
from flightsim.testbench.cfg import TestbenchCfg, TestbenchError
from flightsim.testbench.own_stack import OwnStack
from flightsim.testbench.remains import free_ended, note_end
from flightsim.vehicles import Airframe, airframe_by_name
from flightsim.vehicles.camera_options import with_cameras
from flightsim.world import World, build_world


class Testbench:
    """Builds every part of a run and owns what must be closed.

    Attributes:
        simulator: Simulation loop; its `run` and `step` advance time.
        stack: Whoever flies: our own flight stack, or an external one.
        lidar: Lidar that the vehicle carries; None without one.
        observers: Called in this order at the end of each tick; append functions to watch.
    """

    def __init__(
        self,
        scene: Scene,
        cfg: TestbenchCfg,
        *,
        airframe: Airframe | None = None,
        traffic: Sequence[MovingObstacle] | None = None,
        has_network: bool = True,
        extra_links: Sequence[Link] = (),
        captures: Path | None = None,
        has_video: bool = False,
        plant: Plant | None = None,
    ) -> None:
        """Build the world of a scene and open the links.

        Args:
            scene: Scene to fly in.
            cfg: Settings of the simulation.
            airframe: Vehicle of one's own instead of the configured one.
            traffic: Movers on paths of their own instead of the configured ones.
            has_network: Whether clients outside this process can connect.
            extra_links: MAVLink links besides the in-process one and the network's.
            captures: Folder for photographs and films of the gimbal's camera; None keeps none.
            has_video: Whether that camera's picture is streamed to a port of this machine.
            plant: The vehicle, where it is one of several in a world; `SharedTestbench` has the
                loop then, and there are no other vehicle and no other movers to choose.

        Raises:
            WorldError: If the vehicle cannot start there.
            TrafficError: If the scene has no room for the traffic.
            PortInUseError: If a MAVLink port is taken.
            TestbenchError: If the folder cannot be made, there is nothing to encode video with, or
                the external flight stack cannot be had.
        """
        free_ended()
        self.cfg, self.scene = cfg, scene
        if plant is None:
            airframe = with_cameras(airframe or airframe_by_name(cfg.vehicle), cfg.camera)
            movers = cfg.traffic_cfg if traffic is None else traffic
            plant = Plant(build_world(scene, airframe, traffic=movers), cfg.plant_cfg)
        self.plant = plant
        self.world: World = plant.world
        self.airframe = plant.world.airframe
        self.frame = LocalFrame(
            Geodetic(self.scene.latitude_deg, self.scene.longitude_deg, self.scene.altitude_m)
        )
        self.observers: list[Callable[[], None]] = []
        self.lidar = Lidar(self.plant, lidar_by_name(cfg.lidar)) if cfg.lidar else None
        if self.lidar is not None:
            self.observers.append(self._scan)
        self._own: OwnStack | None = None
        self.stack: OwnStack | ExternalStack
        """Whoever flies."""
        self.parts: tuple[Controller, Server]
        """Who commands the plant, and who speaks for it."""
        if cfg.autopilot == "builtin":
            self._own = self._build_own(has_network, extra_links, captures, has_video)
            self.stack, self.parts = self._own, (self._own.autopilot, self._own.server)
        else:
            if captures is not None or has_video:
                raise TestbenchError(
                    "captures and video are of the camera that our autopilot has, and "
                    f"{cfg.autopilot} flies; valid: --autopilot builtin"
                )
            self.stack = self._open_external()
            self.parts = self.stack.monitor, self.stack
        self.simulator = Simulator(
            self.plant, *self.parts, observers=self.observers, speed=cfg.speed
        )

    def _scan(self) -> None:
        """Let the lidar fire what is due."""
        if self.lidar is not None:
            self.lidar.update()

    def _build_own(
        self, has_network: bool, links: Sequence[Link], captures: Path | None, has_video: bool
    ) -> OwnStack:
        try:
            return OwnStack(
                self.plant,
                self.frame,
                self.cfg,
                has_network=has_network,
                extra_links=links,
                captures=captures,
                has_video=has_video,
            )
        except VideoError as error:
            raise TestbenchError(str(error)) from error
        except LinkError:
            raise
        except OSError as error:
            raise TestbenchError(f"captures {str(captures)!r} cannot be made: {error}") from error

    def _open_external(self) -> ExternalStack:
        cfg = self.cfg
        binary = Path(cfg.autopilot_binary) if cfg.autopilot_binary else None
        try:
            return ExternalStack(
                cfg.autopilot, self.plant, self.frame, instance=cfg.instance, binary=binary
            )
        except BridgeError as error:
            raise TestbenchError(str(error)) from error

    @property
    def own(self) -> OwnStack:
        """Our own flight stack.

        Raises:
            TestbenchError: If another one flies.
        """
        if self._own is None:
            raise TestbenchError(f"{self.cfg.autopilot} flies; valid: autopilot builtin")
        return self._own

    @property
    def external(self) -> ExternalStack | None:
        """The external flight stack that flies, if one does."""
        return self.stack if isinstance(self.stack, ExternalStack) else None

    @property
    def autopilot(self) -> Autopilot:
        """Our autopilot, where it flies."""
        return self.own.autopilot

    @property
    def server(self) -> MavlinkServer:
        """MAVLink of our autopilot, where it flies."""
        return self.own.server

    @property
    def payload(self) -> Payload:
        """Gimbal and camera of our autopilot, where it flies."""
        return self.own.payload

    @property
    def pilot_link(self) -> InProcessLink:
        """Lockstep MAVLink to our autopilot for a companion inside this process."""
        return self.own.pilot_link

    @property
    def is_over(self) -> bool:
        """Whether no more time will pass; `stack.fault` says why."""
        return bool(self.stack.fault)

    def connect(self) -> MavlinkClient:
        """Create a companion by MAVLink; `update` it with `plant.time_us` after each tick."""
        return MavlinkClient(self.stack.pipe(), self.frame, habits=self.stack.habits)

    def run(self, seconds: float, until: Callable[[], bool] | None = None) -> None:
        """Advance simulated time at the configured speed, until `until()` holds if it is given."""
        self.simulator.run(until_us=self.plant.time_us + round(seconds * 1e6), stop=until)

    def close(self) -> None:
        """Close every link, and end what flies."""
        self.stack.close()
        note_end(self.plant)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()
