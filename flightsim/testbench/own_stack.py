"""Our flight stack around a plant: autopilot, payload and MAVLink.

It has the same interface as `ExternalStack`, so the testbench need not know which of the two flies.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from flightsim.autopilot.autopilot import Autopilot
from flightsim.autopilot.environment_parameters import follow_parameters
from flightsim.autopilot.events import Severity
from flightsim.frames import LocalFrame
from flightsim.mavlink.client import PX4_HABITS, BytePipe
from flightsim.mavlink.links import InProcessLink, Link, network_links
from flightsim.mavlink.personalities import PERSONALITIES
from flightsim.mavlink.server import MavlinkServer
from flightsim.mavlink.vehicle_type import vehicle_parameters
from flightsim.payload import VIDEO_PORT, Payload, PayloadCfg, VideoError
from flightsim.plant import Plant
from flightsim.testbench.cfg import TestbenchCfg, TestbenchError
from flightsim.vehicles.builder import vehicle_name


class OwnStack:
    """Our stack, which builds its parts and owns those that must be closed.

    Attributes:
        autopilot: Autopilot that flies the plant.
        payload: Gimbal and camera.
        server: MAVLink server for all links.
        habits: Peculiarities that a client must know.
    """

    habits = PX4_HABITS

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
        """Build the parts and open the links.

        Args:
            plant: Vehicle to fly.
            frame: Local frame of the scene.
            cfg: Settings, with the instance of this vehicle.
            has_network: True opens the ports for clients outside this process.
            links: MAVLink links besides those.
            captures: Folder for photographs and films; None keeps none.
            has_video: True streams the camera's picture to a port.

        Raises:
            PortInUseError: If a MAVLink port is taken.
            TestbenchError: If the folder cannot be made, or there is no encoder for the video.
        """
        personality = PERSONALITIES[cfg.personality]
        self.autopilot = Autopilot(
            plant,
            frame,
            airframe=plant.world.airframe,
            initial_parameters={
                # The settings come last, and win over those of the vehicle.
                **vehicle_parameters(plant.world.airframe),
                **cfg.initial_parameters,
            },
            parameter_ranges=personality.parameter_ranges,
            pilot_speeds_limit_all=personality.pilot_speeds_limit_all,
            terrain=plant.world.scene.relief,
        )
        # From now on a client that sets a wind parameter changes the plant's wind.
        follow_parameters(self.autopilot.parameters, plant)
        video_port = VIDEO_PORT + cfg.instance if has_video else None
        if captures is not None and plant.other_plants:
            # Several vehicles would number their pictures in one folder.
            captures /= vehicle_name(plant.world.number)
        payload_cfg = PayloadCfg(captures=captures, video_port=video_port)
        try:
            self.payload = Payload(plant, self.autopilot, frame, payload_cfg)
        except VideoError as error:
            raise TestbenchError(str(error)) from error
        except OSError as error:
            raise TestbenchError(f"captures {str(captures)!r} cannot be made: {error}") from error
        self._pilot_link = InProcessLink()
        network = _network_links(cfg, plant.world.number) if has_network else ()
        self.server = MavlinkServer(
            self.autopilot,
            plant,
            frame,
            # The link in this process is served first, then those of the caller, then the
            # network's.
            [self._pilot_link, *links, *network],
            system_id=1 + cfg.instance,
            personality=personality,
            has_lockstep=cfg.lockstep,
            ticks_per_burst=cfg.ticks_per_burst,
            signing=cfg.signing,
            payload=self.payload,
        )
        # Renderers open here, before time passes.
        self.payload.prepare()

    @property
    def fault(self) -> str:
        """Words that say why time will pass no more; empty while it passes."""
        lockstep = self.server.lockstep
        is_over = lockstep is not None and lockstep.is_over
        return "the client that kept the time" if is_over else ""

    @property
    def reports(self) -> Autopilot:
        """Source of the mode and the arming that are shown and recorded."""
        return self.autopilot

    def pipe(self) -> BytePipe:
        """Return a lockstep MAVLink connection for a companion inside this process."""
        return self._pilot_link.client

    def listen(self, listener: Callable[[Severity, str], None]) -> None:
        """Call a function with the severity and the text of each message to clients."""
        self.server.statustext.listeners.append(listener)

    def close(self) -> None:
        """Close every link, and end what the payload still does."""
        self.server.close()
        self.payload.close()


def _network_links(cfg: TestbenchCfg, number: int) -> list[Link]:
    """Return the links for clients outside this process, for the vehicle of a number."""
    return network_links(
        cfg.instance,
        cfg.bind,
        # All vehicles of a world speak to one port of a ground station, the first one's.
        first_instance=cfg.instance - number,
        serial_line=cfg.serial_line,
        outs=cfg.out_addresses,
        is_lockstep=cfg.lockstep,
        signing=cfg.signing,
    )
