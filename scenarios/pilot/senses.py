"""What the pilot knows by looking: where it is in the map, what moves, what the map lacks.

Telemetry comes in by the frame of the estimate and leaves as the map has it; setpoints go the other
way. A depth image is taken once and shown to all that want it.
"""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float

from autonomy.model.quadrotor import Vector3
from autonomy.perception import DepthImage
from autonomy.planning import NOTHING_MOVES, MovingObstacles
from autonomy.types import FlatReference
from scenarios.mavlink_telemetry import Telemetry
from scenarios.pilot.eyes import Frames, NoDepthError, camera_mount, posed_image
from scenarios.surroundings import GivenMap, Surroundings

if TYPE_CHECKING:
    from autonomy.perception.map_anchor import MapAnchor
    from autonomy.perception.mover_tracker import MoverTracker

LOOK_PERIOD_US = 200_000
"""Between two looks ahead, where something may be seen that the map has not."""
FIX_PERIOD_US = 500_000
"""Between two looks at the map, where the autopilot is not sure where it is."""
UNSURE_M = 0.3
"""Reported horizontal accuracy beyond which the map is looked at on the way."""
PLACED_SIGMA_M = 0.1
"""How exactly a vehicle is put down at its start."""


class Senses:
    """Cameras, and what is made of their images.

    Attributes:
        telemetry: The vehicle as last reported, in the map's frame.
        n_blind: Images in a row of the camera that looks down without one measured pixel.
    """

    def __init__(self, world: Surroundings, frames: Frames, *, expects_traffic: bool) -> None:
        """Open the eyes.

        Args:
            world: The map; one that grows is shown every image.
            frames: Renders the named camera now.
            expects_traffic: Whether to look out for what moves.
        """
        self._world, self._frames = world, frames
        self._anchor = _anchor(world) if world.is_known else None
        self._tracker = _tracker(world) if expects_traffic else None
        self._looks_ahead = expects_traffic or not world.is_known
        self._estimate = self.telemetry = Telemetry()
        self._time_us = 0
        self._due_us = 0
        self._fix_camera = "forward"
        self.n_blind = 0

    def locate(self, time_us: int, estimate: Telemetry) -> None:
        """Take telemetry over into the map's frame."""
        self._time_us, self._estimate = time_us, estimate
        anchor = self._anchor
        if anchor is None or not estimate.has_state:
            self.telemetry = estimate
            return
        anchor.claim(estimate.horizontal_sigma_m)
        anchor.advance(time_us * 1e-6)
        position_enu_m, _ = anchor.to_map(estimate.position_enu_m, estimate.yaw_rad)
        self.telemetry = dataclasses.replace(
            estimate,
            position_enu_m=position_enu_m,
            velocity_enu_mps=anchor.vector_to_map(estimate.velocity_enu_mps),
            quat_wxyz=anchor.attitude_to_map(estimate.quat_wxyz),
        )

    def stand_at(self, position_enu_m: Vector3) -> None:
        """It stands at a place that is known: what the estimate is off by shows."""
        if self._anchor is not None:
            here = self._estimate.position_enu_m
            self._anchor.stand_at(self._time_us * 1e-6, here, position_enu_m, PLACED_SIGMA_M)
            self.locate(self._time_us, self._estimate)

    def to_estimate(self, reference: FlatReference) -> FlatReference:
        """A setpoint in the frame that the autopilot steers by."""
        return reference if self._anchor is None else self._anchor.to_estimate(reference)

    def look_about(self) -> bool:
        """Look where it is worth it and time to; True if something new may be known."""
        if self._time_us < self._due_us:
            return False
        if self._looks_ahead:
            self._due_us = self._time_us + LOOK_PERIOD_US
            self._glance("forward")
            return True
        if self._anchor is not None and self._estimate.horizontal_sigma_m > UNSURE_M:
            self._due_us = self._time_us + FIX_PERIOD_US
            self._glance(self._fix_camera)
            self._fix_camera = "down" if self._fix_camera == "forward" else "forward"
        return False

    def take(self, camera: str) -> DepthImage:
        """A depth image in the map's frame.

        Raises:
            NoDepthError: If nothing was measured.
        """
        mount = camera_mount(self._world.airframe, camera)
        frame, time_s = self._frames(camera), self._time_us * 1e-6
        is_down = camera == "down"
        try:
            image = posed_image(frame, mount, self._estimate)
        except NoDepthError:
            self.n_blind += is_down
            raise
        if is_down:
            self.n_blind = 0
        if self._anchor is not None:
            self._anchor.update(time_s, image)
            image = self._anchor.image_to_map(image)
        if self._tracker is not None:
            self._tracker.update(time_s, image, self._static_distance)
        self._world.observe(image)
        return image

    def moving(self, time_us: int) -> MovingObstacles:
        """What moves, predicted from a time on."""
        return NOTHING_MOVES if self._tracker is None else self._tracker.moving(time_us * 1e-6)

    def _glance(self, camera: str) -> None:
        """Look, and make nothing of it if there is only sky."""
        try:
            self.take(camera)
        except NoDepthError:
            return

    def _static_distance(self, points_enu_m: Float[np.ndarray, "n 3"]) -> Float[np.ndarray, " n"]:
        """Distance to what is known to stand; 0 where a map that grows knows nothing yet."""
        known = self._world.map
        distance_m = self._world.obstacles.signed_distance(points_enu_m)[0]
        if isinstance(known, GivenMap):
            return distance_m
        is_new = (distance_m <= 0.0) & (known.distance_to_seen_m(points_enu_m) > 0.0)
        return np.where(is_new, 0.0, known.distance_to_standing_m(points_enu_m))


def _anchor(world: Surroundings) -> MapAnchor:
    # Compiled code that only a flight with a given map needs.
    from autonomy.perception.map_anchor import MapAnchor  # noqa: PLC0415

    return MapAnchor(world.obstacles)


def _tracker(world: Surroundings) -> MoverTracker:
    from autonomy.perception.mover_tracker import MoverTracker, MoverTrackerCfg  # noqa: PLC0415

    return MoverTracker(MoverTrackerCfg() if world.is_known else MoverTrackerCfg(remember_s=0.5))
