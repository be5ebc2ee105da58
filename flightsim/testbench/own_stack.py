"""Our flight stack around a plant: autopilot, payload and MAVLink."""

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
    """Builds the parts of our stack, and owns what must be closed.

    Attributes:
        autopilot: Flies the plant.
        payload: Gimbal and camera.
        server: Serves all links.
        habits: What a client must know of it.
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
        """Build the parts and open the links; see `Testbench`.

        Raises:
            PortInUseError: If a MAVLink port is taken.
            TestbenchError: If the folder cannot be made, or there is nothing to encode video with.
        """
        personality = PERSONALITIES[cfg.personality]
        self.autopilot = Autopilot(
            plant,
            frame,
            airframe=plant.world.airframe,
            initial_parameters={
                **vehicle_parameters(plant.world.airframe),
                **cfg.initial_parameters,
            },
            parameter_ranges=personality.parameter_ranges,
            pilot_speeds_limit_all=personality.pilot_speeds_limit_all,
            terrain=plant.world.scene.relief,
        )
        follow_parameters(self.autopilot.parameters, plant)
        video_port = VIDEO_PORT + cfg.instance if has_video else None
        if captures is not None and plant.mates:
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
            [self._pilot_link, *links, *network],
            system_id=1 + cfg.instance,
            personality=personality,
            has_lockstep=cfg.lockstep,
            ticks_per_burst=cfg.ticks_per_burst,
            signing=cfg.signing,
            payload=self.payload,
        )
        self.payload.prepare()

    @property
    def fault(self) -> str:
        """What keeps time from passing for good, in words; empty while it passes."""
        lockstep = self.server.lockstep
        is_over = lockstep is not None and lockstep.is_over
        return "the client that kept the time" if is_over else ""

    @property
    def reports(self) -> Autopilot:
        """Whose mode and arming are shown and recorded."""
        return self.autopilot

    def pipe(self) -> BytePipe:
        """Lockstep MAVLink for a companion inside this process."""
        return self._pilot_link.client

    def listen(self, listener: Callable[[Severity, str], None]) -> None:
        """Call a function with severity and text of each message to clients."""
        self.server.statustext.listeners.append(listener)

    def close(self) -> None:
        """Close every link, and end what the payload still does."""
        self.server.close()
        self.payload.close()


def _network_links(cfg: TestbenchCfg, number: int) -> list[Link]:
    """Links that clients outside this process connect to, for the vehicle of a number."""
    return network_links(
        cfg.instance,
        cfg.bind,
        first_instance=cfg.instance - number,
        serial_line=cfg.serial_line,
        outs=cfg.out_addresses,
        is_lockstep=cfg.lockstep,
        signing=cfg.signing,
    )
