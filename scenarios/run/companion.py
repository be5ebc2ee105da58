"""Interface of a user's own pilot: its equipment, and the members that it must have.

A real companion computer has a MAVLink link, cameras and perhaps a map. `Aboard` holds exactly
these, so that a pilot written for it has no way to the true state.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy as np

from aeroscene.scene import InteractionArea, Scene
from flightsim.lidars import LidarScan
from flightsim.mavlink.client import BytePipe, MavlinkClient
from flightsim.plant import Plant
from flightsim.vehicles import Airframe
from scenarios.pilot.depth_frames import DepthFrame
from scenarios.trials.verdict import Word
from scenarios.words.goal import Description

if TYPE_CHECKING:
    from scenarios.pilot import Pilot


@dataclass(frozen=True, kw_only=True, eq=False)
class Insight:
    """Knowledge that no vehicle has, for baselines that stand for perfect perception."""

    scene: Scene
    """The scene with all its objects and areas, whatever the pilot is given of the map."""
    description: Description
    """Meaning of the text."""


class CameraImage(DepthFrame, Protocol):
    """Frame of an on-board camera, without the true pose, which a vehicle cannot know."""

    @property
    def rgb(self) -> np.ndarray:
        """Colours, uint8 (height, width, 3)."""
        ...


@dataclass(frozen=True, kw_only=True, eq=False)
class Aboard:
    """Equipment of a companion computer: MAVLink, cameras and a map, but never the true state."""

    client: MavlinkClient
    """Commands, set points and telemetry in the scene's frame; call its `update` every tick."""
    link: BytePipe
    """Byte pipe beneath the client, for a MAVLink library of your own."""
    render: Callable[[str], CameraImage]
    """Function that renders the present frame of the named camera."""
    scene: Scene
    """The map. In a flight to a goal in words whose map is not given, it has neither objects nor
    areas."""
    airframe: Airframe
    area: InteractionArea | None = None
    """Assigned area; None leaves the choice to the companion."""
    text: str = ""
    """Goal in words, such as `Land on the blue container.`; empty if the goal is an area."""
    insight: Insight | None = None
    """None, except in a flight to a goal in words for a maker of pilots with a true attribute
    `has_insight`."""
    # By default a vehicle without a lidar.
    scan: Callable[[], LidarScan | None] = lambda: None
    """Function that returns the lidar's last complete scan; None without a lidar."""
    our_pilot: Callable[[MavlinkClient], Pilot] | None = None
    """Function that plans the flight and returns our own pilot for it, which steers by a client of
    yours; for pilots that take over a part of its flight. It raises `TestbenchError` if there is no
    plan."""
    plant: Plant | None = None
    """None, except for a maker of pilots with a true attribute `sees_plant`: a policy observes what
    its environment showed to it, which may be the true state."""


class Companion(Protocol):
    """Interface of a pilot that `Sitl` runs: our own or another class.

    Optional members: `touchdown_enu_m`, the point (scene, ENU) that the pilot chose to land on, or
    None; `planned_enu_m`, the path that it plans to fly; `replans`, the plans that it made anew.
    """

    @property
    def is_done(self) -> bool:
        """True if the flight is over, well or badly."""
        ...

    @property
    def verdict(self) -> Word:
        """The companion's own statement on the flight; read when the run is over."""
        ...

    @property
    def area(self) -> InteractionArea | None:
        """Area that the companion wants to land on; None if it wants none."""
        ...

    def update(self, time_us: int) -> None:
        """Read telemetry, decide, send; called after every 20 ms of simulated time."""
        ...
