"""A pilot of one's own: what it is given, and what it has to say."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from aeroscene.scene import InteractionArea, Scene
from flightsim.mavlink.client import BytePipe, MavlinkClient
from flightsim.vehicles import Airframe
from scenarios.pilot import PilotVerdict
from scenarios.pilot.eyes import DepthFrame
from scenarios.run.trial import Verdict


class CameraImage(DepthFrame, Protocol):
    """A frame of an on-board camera; where it was really taken, a vehicle cannot know."""

    @property
    def rgb(self) -> np.ndarray:
        """uint8 (height, width, 3)."""
        ...


@dataclass(frozen=True, kw_only=True, eq=False)
class Aboard:
    """What a companion computer has: MAVLink, cameras and a map, but never the true state."""

    client: MavlinkClient
    """Commands, setpoints and telemetry in the scene's frame; call its `update` every tick."""
    link: BytePipe
    """The bytes beneath it, for a MAVLink client of one's own."""
    render: Callable[[str], CameraImage]
    """What the named camera sees now."""
    scene: Scene
    """The map."""
    airframe: Airframe


class Companion(Protocol):
    """What `Sitl` lets fly, our pilot or a class of one's own."""

    @property
    def is_done(self) -> bool:
        """Whether the flight is over, well or badly."""
        ...

    @property
    def verdict(self) -> Verdict | PilotVerdict:
        """How it ended, as far as the companion can know; read when the run is over."""
        ...

    @property
    def area(self) -> InteractionArea | None:
        """Where it wants to come to rest; None if the flight is no landing on an area."""
        ...

    def update(self, time_us: int) -> None:
        """Read telemetry, decide, send; called after every 20 ms of simulated time."""
        ...
