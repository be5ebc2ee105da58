"""Perception of the pilot: its place in the map, movers, and changes of a growing map.

The autopilot's estimate and the map have frames that differ by metres with a poor receiver.
Telemetry is converted from the frame of the estimate to that of the map, set points the other way,
so that the rest of the pilot knows only the map's frame. A depth image is rendered once and shared
by all its users.
"""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float

from aeroscene.neighbourhood import GAP_M, neighbours_of
from autonomy.perception import DepthImage
from autonomy.planning import NOTHING_MOVES, MovingObstacles
from autonomy.rotation import quat_from_rotation_vector, quat_multiply
from autonomy.types import FlatReference, Quaternion, Vector3
from flightsim.mavlink.client.telemetry import Telemetry
from scenarios.mission.surroundings import Surroundings
from scenarios.pilot.depth_frames import Frames, NoDepthError, camera_mount, may_show, posed_image
from scenarios.pilot.trust import Trust

if TYPE_CHECKING:
    from autonomy.perception.anchor_fix import AnchorFix
    from autonomy.perception.map_anchor import MapAnchor
    from autonomy.perception.mover_tracker import MoverTracker

AHEAD = ("forward", "down")
"""Cameras that look ahead of the vehicle and below it."""
OVERHEAD = ("up_left", "up_right", "up_rear")
"""Cameras that look to the sides and behind, a little upwards."""
WATCHING = (*AHEAD, *OVERHEAD)
"""Cameras that look out for movers."""
OVERHEAD_EVERY = 2
"""One full look in this many uses the cameras overhead too. The vehicle flies away from the region
that they see, so that a mover there closes in at its own speed alone, and half as many looks
suffice."""
LOOK_PERIOD_US = 200_000
"""Time between two looks ahead for movers and new parts of the map."""
ADRIFT_PERIOD_US = 100_000
"""Time between two fixes while nothing else measures the position."""
LOOK_AGAIN_US = 100_000
"""Time between two looks at a detection that is still unconfirmed."""
MOVER_REACH_M = 1.0
"""Distance from the middle of a mover up to which parts of it may be in view."""
FIRST_ASPECT = 4.0 / 3.0
"""Aspect ratio that is assumed until the first image has come."""
FIX_PERIOD_US = 500_000
"""Time between two fixes in the map while the autopilot is unsure of its position."""
UNSURE_M = 0.1
"""Reported horizontal accuracy above which the position is also fixed on the way."""
SURE_M = 0.2
"""Standard deviation of the position in the map above which a mismatch may be due to the position,
so that nothing is taken for a mover."""
LEAST_HEIGHT_M = 0.8
"""Height above the start below which a growing map does not know the ground around it yet."""
HITS_WHILE_GROWING = 8
"""Images that must show a mover in a growing map: more than the map needs to learn a static object.
"""
LEAST_FIX_SIGMA_M, MOST_FIX_SIGMA_M = 0.1, 0.25
"""Bounds of the standard deviation of a place that is sent to the autopilot. Images that follow
each other have similar errors, hence the lower one. An image above the upper one leaves a direction
open and would only return the autopilot's own belief."""
MOST_AGE_S = 0.1
"""Longest time by which telemetry is extrapolated to an image."""
PLACED_SIGMA_M = 0.1
"""Standard deviation of the vehicle's placement at its start, in a given map."""
BEGIN_SIGMA_M = 0.01
"""The same in a map that begins where the vehicle stands: any further error is the map's as well.
"""


@dataclasses.dataclass(frozen=True, kw_only=True, slots=True)
class PlaceFix:
    """Horizontal position of the vehicle in the given map, by one image."""

    position_enu_m: Vector3
    """Its height is the estimate's."""
    yaw_rad: float
    """The estimate's heading."""
    sigma_m: float
    """Standard deviation of each horizontal axis."""


class Senses:
    """Cameras and the processing of their images.

    It decides which camera looks when, because each image costs time, and passes each image to the
    place in the map, the movers and the growing map.

    Attributes:
        telemetry: Latest telemetry, in the map's frame.
        looks_ahead: True if it looks ahead for movers or for new parts of the map.
    """

    def __init__(self, world: Surroundings, frames: Frames, *, expects_traffic: bool) -> None:
        """Start perception.

        Args:
            world: Map of the place; a growing one receives every image.
            frames: Renders the present frame of a named camera.
            expects_traffic: True to look out for movers.
        """
        self._world, self._frames = world, frames
        # Asked once: the answer is kept by the scene, whose hash takes milliseconds.
        self._has_neighbours = expects_traffic and bool(neighbours_of(world.scene))
        self._anchor = _anchor(world)
        self._tracker = _tracker(world) if expects_traffic else None
        self.looks_ahead = expects_traffic or not world.is_known
        self._estimate = self.telemetry = Telemetry()
        self._time_us = 0
        self._due_us = 0
        self._all_due_us = 0
        self._n_looks = 0
        self._aspect = FIRST_ASPECT
        self._fix_camera = "forward"
        self._trust = Trust()
        self._place: PlaceFix | None = None
        self._tells_place = False

    def locate(self, time_us: int, estimate: Telemetry) -> None:
        """Convert telemetry to the map's frame.

        Call it once a tick, before anything else uses `telemetry`.
        """
        self._time_us, self._estimate = time_us, estimate
        anchor = self._anchor
        if not estimate.has_state:
            self.telemetry = estimate
            return
        self._trust.update(time_us, estimate.horizontal_sigma_m)
        # As soon as the autopilot has satellites again, it needs no places from here.
        self._tells_place = self._tells_place and not estimate.has_fix
        anchor.claim(estimate.horizontal_sigma_m, is_adrift=self.is_adrift)
        # With a given map the images alone correct the offset, as long as the autopilot has a
        # source of its own.
        if not self._world.is_known or self._tells_place:
            at_s = estimate.position_time_ms * 1e-3
            anchor.follow(at_s, estimate.position_enu_m, estimate.velocity_enu_mps)
        anchor.advance(time_us * 1e-6)
        position_enu_m, _ = anchor.to_map(estimate.position_enu_m, estimate.yaw_rad)
        self.telemetry = dataclasses.replace(
            estimate,
            position_enu_m=position_enu_m,
            velocity_enu_mps=anchor.vector_to_map(estimate.velocity_enu_mps),
            quat_wxyz=anchor.attitude_to_map(estimate.quat_wxyz),
        )

    def stand_at(self, position_enu_m: Vector3) -> None:
        """Use a known resting place to measure the error of the estimate."""
        here = self._estimate.position_enu_m
        sigma_m = PLACED_SIGMA_M if self._world.is_known else BEGIN_SIGMA_M
        self._anchor.stand_at(self._time_us * 1e-6, here, position_enu_m, sigma_m)
        self.locate(self._time_us, self._estimate)
        if not self._world.is_known:
            # The first image, from a known place, is the one that later images are matched to.
            self._glance("forward")

    def _static_distance_m(self, points_enu_m: Float[np.ndarray, "k 3"]) -> Float[np.ndarray, " k"]:
        """Distance from points to obstacles that are known to stand, m.

        The map knows nothing of the houses and trees around the site. Movers stay within it, so
        everything well beyond its sides counts as standing.
        """
        distance_m = self._world.map.static_distance_m(points_enu_m)
        if not self._has_neighbours:
            return distance_m
        scene, place = self._world.scene, points_enu_m[:, :2]
        low, high = (np.array(end[:2]) for end in (scene.extent_min_enu_m, scene.extent_max_enu_m))
        is_beyond = ((place < low - GAP_M / 2) | (place > high + GAP_M / 2)).any(axis=1)
        return np.where(is_beyond, 0.0, distance_m)

    def to_estimate(self, reference: FlatReference) -> FlatReference:
        """Convert a set point to the frame that the autopilot steers by."""
        return self._anchor.to_estimate(reference)

    def look_about(self) -> bool:
        """Look with the cameras that are due; return whether anything new may be known."""
        if self._time_us < self._due_us:
            return False
        if self.looks_ahead:
            cameras = self._cameras_due()
            for camera in cameras:
                self._glance(camera)
            is_sure = not len(self.in_question())
            self._due_us = self._all_due_us if is_sure else self._time_us + LOOK_AGAIN_US
            return bool(cameras)
        if self._is_unsure:
            period_us = ADRIFT_PERIOD_US if self.is_adrift else FIX_PERIOD_US
            self._due_us = self._time_us + period_us
            self._glance(self._fix_camera)
            # By turns: the floor gives the height, walls ahead give the horizontal position.
            self._fix_camera = "down" if self._fix_camera == "forward" else "forward"
        return False

    def take(self, camera: str) -> DepthImage:
        """Take a depth image in the map's frame.

        The image also updates the place in the map, the movers and a growing map. Each call renders
        an image, so call it once for a camera and a tick and pass the result on.

        Raises:
            NoDepthError: If nothing was measured.
        """
        mount = camera_mount(self._world.airframe, camera)
        frame, time_s = self._frames(camera), self._time_us * 1e-6
        image = posed_image(frame, mount, self._now())
        height, width = frame.depth_m.shape
        self._aspect = width / height
        if self._world.is_known or self._is_unsure:
            fix = self._anchor.update(time_s, image)
            if self.is_adrift:
                self._find_place(fix)
        else:
            self._anchor.rely(time_s, image)
        image = self._anchor.image_to_map(image)
        if self._tracker is not None and self._can_tell_movers:
            self._tracker.update(time_s, image, self._static_distance_m)
        is_ahead = camera == "forward"
        self._world.observe(image, self.telemetry.position_enu_m, is_ahead=is_ahead)
        return image

    def take_place(self) -> PlaceFix | None:
        """Return the place that the autopilot should be sent, and forget it.

        While the vehicle is adrift (`is_adrift`), each image that determines the place by itself,
        to 0.25 m or better, leaves one here.

        Returns:
            The newest place since the last call; None if no image gave one.
        """
        place, self._place = self._place, None
        return place

    def _find_place(self, fix: AnchorFix) -> None:
        """Keep the place that an image gives by itself, for an autopilot without another source."""
        if fix.level is None or fix.level.sigma_m > MOST_FIX_SIGMA_M:
            return
        now = self._now()
        (x, y, z), (east_m, north_m) = now.position_enu_m, fix.level.offset_enu_m
        self._tells_place = True
        self._place = PlaceFix(
            position_enu_m=(x + east_m, y + north_m, z),
            yaw_rad=now.yaw_rad,
            sigma_m=max(fix.level.sigma_m, LEAST_FIX_SIGMA_M),
        )

    def moving(self, time_us: int) -> MovingObstacles:
        """Movers, predicted from a given time on; none without a tracker."""
        return NOTHING_MOVES if self._tracker is None else self._tracker.moving(time_us * 1e-6)

    @property
    def is_adrift(self) -> bool:
        """True if neither satellites nor odometry seem to measure the position.

        Either the autopilot says so itself, or the course of its claimed deviation shows it. Once
        an image has given a place for the autopilot (`take_place`), the state lasts until the
        receiver has a fix. The places themselves may end the autopilot's complaint, but they come
        from this pilot, which must therefore go on sending them.
        """
        return self._tells_place or self._estimate.is_dead_reckoning or self._trust.is_adrift

    @property
    def place_sigma_m(self) -> float:
        """Standard deviation of the position in the map, in the worst horizontal direction."""
        return self._anchor.sigma_m

    @property
    def _is_unsure(self) -> bool:
        """True if the autopilot is unsure of its position."""
        return self._estimate.horizontal_sigma_m > UNSURE_M

    @property
    def _can_tell_movers(self) -> bool:
        """True if points off the map may belong to a mover."""
        foot_m = self._world.scene.start_position_enu_m[2]
        # Near the ground the camera ahead has not yet seen the ground around the start.
        is_low = self.telemetry.position_enu_m[2] - foot_m < LEAST_HEIGHT_M
        return self._anchor.sigma_m < SURE_M and (self._world.is_known or not is_low)

    def _now(self) -> Telemetry:
        """Estimate extrapolated to now, because a turning vehicle looks elsewhere by then."""
        estimate = self._estimate
        age_s = self._time_us * 1e-6 - estimate.position_time_ms * 1e-3
        if not (0.0 < age_s <= MOST_AGE_S and estimate.has_state):
            return estimate
        (x, y, z), (u, v, w) = estimate.position_enu_m, estimate.velocity_enu_mps
        turn = np.multiply(estimate.angular_rate_flu_radps, age_s)
        qw, qx, qy, qz = _turned(estimate.quat_wxyz, turn)
        return dataclasses.replace(
            estimate,
            position_enu_m=(x + u * age_s, y + v * age_s, z + w * age_s),
            quat_wxyz=(qw, qx, qy, qz),
        )

    def in_question(self) -> Float[np.ndarray, "n 3"]:
        """Positions (ENU) of possible movers that are still unconfirmed."""
        return np.zeros((0, 3)) if self._tracker is None else self._tracker.in_question()

    def _cameras_due(self) -> list[str]:
        """Cameras to look with now: all at every full look, else those that show a doubtful mover.

        A second look serves to confirm a mover, and only the cameras that see its place can do
        that.
        """
        if self._time_us >= self._all_due_us:
            self._all_due_us = self._time_us + LOOK_PERIOD_US
            if self._tracker is None:
                return ["forward"]
            self._n_looks += 1
            return [*AHEAD, *(OVERHEAD if self._n_looks % OVERHEAD_EVERY == 1 else ())]
        doubtful = self.in_question()
        mounts = [camera_mount(self._world.airframe, camera) for camera in WATCHING]
        views = [(mount, self._aspect, self.telemetry) for mount in mounts]
        return [view[0].name for view in views if may_show(*view, doubtful, MOVER_REACH_M)]

    def _glance(self, camera: str) -> None:
        """Take an image, ignoring one of bare sky."""
        try:
            self.take(camera)
        except NoDepthError:
            return


def _turned(quat_wxyz: Quaternion, turn_flu_rad: Float[np.ndarray, " 3"]) -> list[float]:
    """Attitude after a small rotation about the body's axes."""
    turn, turned = np.empty(4), np.empty(4)
    x, y, z = turn_flu_rad.tolist()
    quat_from_rotation_vector(x, y, z, turn)
    quat_multiply(np.array(quat_wxyz), turn, turned)
    return turned.tolist()


def _anchor(world: Surroundings) -> MapAnchor:
    # Imported here: each kind of map needs only a part of this compiled code.
    from autonomy.perception.map_anchor import MapAnchor

    if world.is_known:
        from autonomy.perception.map_match import MapMatcher

        return MapAnchor(MapMatcher(world.obstacles))
    from autonomy.perception.map_anchor_cfg import SEEN_SO_FAR
    from autonomy.perception.surface_match import SurfaceMatcher

    scene = world.scene
    # A growing map has no obstacles to match with, only surfaces that were seen.
    matcher = SurfaceMatcher(scene.extent_min_enu_m, scene.extent_max_enu_m)
    return MapAnchor(matcher, SEEN_SO_FAR)


def _tracker(world: Surroundings) -> MoverTracker:
    from autonomy.perception.mover_tracker import MoverTracker, MoverTrackerCfg

    # Distances change with each image of a growing map, so they are kept for one period only.
    growing = MoverTrackerCfg(remember_s=0.2, hits_to_confirm=HITS_WHILE_GROWING)
    return MoverTracker(MoverTrackerCfg() if world.is_known else growing)
