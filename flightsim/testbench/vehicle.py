"""One vehicle of a testbench: its plant, its flight stack, and MAVLink."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from flightsim.autopilot.autopilot import Autopilot
from flightsim.bridges import BridgeError, ExternalStack
from flightsim.frames import LocalFrame
from flightsim.lidars import Lidar, lidar_by_name
from flightsim.mavlink.client import MavlinkClient
from flightsim.mavlink.links import Link
from flightsim.plant import Plant
from flightsim.plant.timed_failures import FailureTimer, parse_failures
from flightsim.simulator import Controller, Server
from flightsim.testbench.cfg import TestbenchCfg, TestbenchError
from flightsim.testbench.ended_vehicles import note_end
from flightsim.testbench.own_stack import OwnStack


class Vehicle:
    """A vehicle of a testbench, which opens its links and owns all that must be closed.

    Attributes:
        plant: The vehicle in its world.
        airframe: Its airframe.
        scene: The scene, with its start.
        frame: Frame of the scene on the earth.
        cfg: Settings of the testbench, with the instance of this vehicle.
        lidar: Lidar that it carries; None without one.
        failures: Timer that lets parts fail in flight, as the settings say.
        stack: Flight stack: our own, or an external one.
        controller: Controller that commands the plant after each tick.
        server: Server that talks with clients.
    """

    def __init__(
        self,
        plant: Plant,
        frame: LocalFrame,
        cfg: TestbenchCfg,
        *,
        has_network: bool,
        links: Sequence[Link],
        captures: Path | None,
        has_video: bool,
    ) -> None:
        """Build the stack of a vehicle and open its links.

        Args:
            plant: Vehicle in its world.
            frame: Frame of the scene on the earth.
            cfg: Settings, with the instance of this vehicle.
            has_network: True lets clients outside this process connect.
            links: MAVLink links besides the in-process one and the network's.
            captures: Folder for photographs and films; None keeps none.
            has_video: True streams the camera's picture to a port.

        Raises:
            PortInUseError: If a MAVLink port is taken.
            TestbenchError: If the flight stack cannot be had, or lacks what is asked for.
        """
        self.plant, self.frame, self.cfg = plant, frame, cfg
        self.airframe, self.scene = plant.world.airframe, plant.world.scene
        self.lidar = Lidar(plant, lidar_by_name(cfg.lidar)) if cfg.lidar else None
        # Motors are counted by the airframe, so its failures are checked against it.
        ahead = parse_failures(cfg.fail, len(self.airframe.motors))
        self.failures = FailureTimer(plant, ahead)
        self._own: OwnStack | None = None
        self.stack: OwnStack | ExternalStack
        self.controller: Controller
        self.server: Server
        if cfg.autopilot == "builtin":
            self._own = self.stack = OwnStack(
                plant,
                frame,
                cfg,
                has_network=has_network,
                links=links,
                captures=captures,
                has_video=has_video,
            )
            self.controller, self.server = self._own.autopilot, self._own.server
            return
        if captures is not None or has_video:
            raise TestbenchError(
                "captures and video are of the camera that our autopilot has, and "
                f"{cfg.autopilot} flies; valid: --autopilot builtin"
            )
        # An external stack commands the rotors inside a tick; its monitor only reads what it
        # reports.
        self.stack = self._open_external()
        self.controller, self.server = self.stack.monitor, self.stack

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
        """Our own flight stack: autopilot, payload and MAVLink.

        Raises:
            TestbenchError: If another one flies.
        """
        if self._own is None:
            raise TestbenchError(f"{self.cfg.autopilot} flies; valid: autopilot builtin")
        return self._own

    @property
    def external(self) -> ExternalStack | None:
        """External flight stack that flies; None if our own does."""
        return self.stack if isinstance(self.stack, ExternalStack) else None

    @property
    def autopilot(self) -> Autopilot:
        """Our autopilot of this vehicle.

        Raises:
            TestbenchError: If an external flight stack flies.
        """
        return self.own.autopilot

    def connect(self) -> MavlinkClient:
        """Return a new companion by MAVLink.

        Call its `update` with `plant.time_us` after each tick, else it neither reads nor sends.
        """
        return MavlinkClient(self.stack.pipe(), self.frame, habits=self.stack.habits)

    def close(self) -> None:
        """Close every link, and end the flight stack."""
        # The plant stays in memory until the collector has run; see `ended_vehicles`.
        self.stack.close()
        note_end(self.plant)
