"""Poses of cameras: free ones at heights and pitches that a drone has, or along flights.

Each frame has two poses, a short time apart, between which optical flow leads.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from scipy.spatial.transform import Rotation

from flightsim.environment.paths import SplinePath, smooth_path
from flightsim.vehicles.catalogue import airframe_by_name
from scenarios.images.place import Place
from scenarios.images.request import ImagesError
from scenarios.tasks.reach import NoTaskError, Reach

_PITCHES = ((0.45, 0.0, 35.0), (0.30, 35.0, 75.0), (0.20, 75.0, 90.0), (0.05, -10.0, 0.0))
"""Share of frames, and range of the pitch below the horizon in degrees: ahead, aslant, down, up."""
_ROLL_DEG = 3.0
"""Standard deviation of the roll: a drone's tilt that no gimbal takes out."""
_MOST_ROLL_DEG = 10.0
_MOST_SPEED_MPS = 8.0
_RATE_RADPS = 0.25
"""Standard deviation of the camera's turn rate about each axis."""
_SPEEDS_MPS = (1.0, 6.0)
_VEHICLE = "iris"
_ATTEMPTS = 20
_LEAST_FLIGHT_M = 4.0
_AHEAD_M = 0.5
"""Distance over which a flight's heading is taken."""


@dataclass(frozen=True, kw_only=True, eq=False)
class CameraPose:
    """Pose of a camera; its optical frame is x right, y down, z forward."""

    position_enu_m: Float[np.ndarray, " 3"]
    rotation_enu_from_optical: Float[np.ndarray, "3 3"]

    @property
    def quat_wxyz(self) -> list[float]:
        """Attitude from the optical frame to ENU."""
        turn = Rotation.from_matrix(self.rotation_enu_from_optical)
        return turn.as_quat(scalar_first=True, canonical=True).tolist()


@dataclass(frozen=True, kw_only=True, eq=False)
class PosePair:
    """Poses of a frame and of its second image."""

    now: CameraPose
    next: CameraPose


def draw_free(place: Place, after_s: float, rng: np.random.Generator) -> PosePair:
    """Draw a pose in free space, and one a short time later.

    The camera's heading leads to a random object, because there is little to label elsewhere.

    Args:
        place: Scene.
        after_s: Time between the poses.
        rng: Generator of this frame.

    Raises:
        ImagesError: If the scene has no free point.
    """
    eye = place.draw(rng)
    scene = place.scene
    middle = np.add(scene.extent_min_enu_m, scene.extent_max_enu_m) / 2
    targets = [obj.bbox.p for obj in scene.objects] or [middle]
    aim = targets[int(rng.integers(len(targets)))]
    yaw_rad = math.atan2(aim[1] - eye[1], aim[0] - eye[0])
    kind = int(rng.choice(len(_PITCHES), p=[share for share, _, _ in _PITCHES]))
    pitch_rad = math.radians(rng.uniform(*_PITCHES[kind][1:]))
    turn = rotation_of(yaw_rad, pitch_rad, _roll_rad(rng))
    # A drone flies mostly where it looks, and climbs less than it advances.
    heading = yaw_rad + rng.normal(0.0, 0.6)
    speed_mps = rng.uniform(0.0, _MOST_SPEED_MPS)
    velocity = speed_mps * np.array([math.cos(heading), math.sin(heading), rng.normal(0.0, 0.2)])
    step = velocity * after_s
    later = turn @ Rotation.from_rotvec(rng.normal(0.0, _RATE_RADPS, 3) * after_s).as_matrix()
    # Slower, until the second camera has room too; at rest it has the first one's.
    while not place.is_free(eye[None] + step)[0]:
        step = 0.5 * step if np.linalg.norm(step) > 0.01 else np.zeros(3)
    return PosePair(
        now=CameraPose(position_enu_m=eye, rotation_enu_from_optical=turn),
        next=CameraPose(position_enu_m=eye + step, rotation_enu_from_optical=later),
    )


class Flight:
    """A flight through a scene, with a camera that is fixed to the vehicle.

    The path is the shortest one in which the vehicle's sphere fits, between two places of the
    start, the landing areas and the open air, smoothed and flown at an even speed.
    """

    def __init__(self, place: Place, rng: np.random.Generator) -> None:
        """Draw the ends, and find the path.

        Args:
            place: Scene.
            rng: Generator of the flight.

        Raises:
            ImagesError: If no path is found.
        """
        self._place = place
        self._path = _draw_path(place, rng)
        self._speed_mps = rng.uniform(*_SPEEDS_MPS)
        is_down = rng.random() < 0.3
        self._pitch_rad = math.radians(90.0 if is_down else rng.uniform(0.0, 50.0))

    def draw(self, after_s: float, rng: np.random.Generator) -> PosePair:
        """Draw a moment of the flight.

        Args:
            after_s: Time between the poses.
            rng: Generator of this frame.
        """
        step_m = self._speed_mps * after_s
        most_m = max(self._path.length_m - step_m, 0.0)
        roll_rad = _roll_rad(rng)
        # Smoothing may cut a corner: a moment without room there is drawn again.
        for _ in range(_ATTEMPTS):
            at_m = rng.uniform(0.0, most_m)
            now, later = (self._pose(distance, roll_rad) for distance in (at_m, at_m + step_m))
            points = np.array([now.position_enu_m, later.position_enu_m])
            if self._place.is_free(points).all():
                break
        else:
            # Without any room, for example in a narrow door, the frame is a free one.
            return draw_free(self._place, after_s, rng)
        return PosePair(now=now, next=later)

    def _pose(self, distance_m: float, roll_rad: float) -> CameraPose:
        ahead_m = np.array([distance_m, min(distance_m + _AHEAD_M, self._path.length_m)])
        points = self._path.sample(ahead_m)
        heading = points[1] - points[0]
        # On a climb straight up, the path as a whole has a heading.
        if np.linalg.norm(heading[:2]) < 0.05:
            ends = self._path.sample(np.array([0.0, self._path.length_m]))
            heading = ends[1] - ends[0]
        yaw_rad = math.atan2(heading[1], heading[0])
        return CameraPose(
            position_enu_m=points[0],
            rotation_enu_from_optical=rotation_of(yaw_rad, self._pitch_rad, roll_rad),
        )


def rotation_of(yaw_rad: float, pitch_down_rad: float, roll_rad: float) -> np.ndarray:
    """Return the attitude (3, 3) of a camera, from its optical frame to ENU.

    Args:
        yaw_rad: Heading of its axis, counter-clockwise from east.
        pitch_down_rad: Angle of its axis below the horizon.
        roll_rad: Turn about its axis, clockwise as the camera sees it.
    """
    c, s = math.cos(yaw_rad), math.sin(yaw_rad)
    level, deep = math.cos(pitch_down_rad), math.sin(pitch_down_rad)
    forward = np.array([c * level, s * level, -deep])
    right = np.array([s, -c, 0.0])
    upright = np.column_stack([right, np.cross(forward, right), forward])
    return upright @ Rotation.from_euler("z", roll_rad).as_matrix()


def _roll_rad(rng: np.random.Generator) -> float:
    roll_deg = float(np.clip(rng.normal(0.0, _ROLL_DEG), -_MOST_ROLL_DEG, _MOST_ROLL_DEG))
    return math.radians(roll_deg)


def _draw_path(place: Place, rng: np.random.Generator) -> SplinePath:
    scene = place.scene
    try:
        reach = Reach.from_scene(scene, airframe_by_name(_VEHICLE))
    except NoTaskError as error:
        raise ImagesError(f"{error}; or --poses free") from None
    surfaces = [scene.start_position_enu_m, *(area.centroid for area in scene.landing_areas)]
    for _ in range(_ATTEMPTS):
        ends = []
        for _end in range(2):
            # A third of the ends are in open air, so that a scene with one area has flights too.
            if rng.random() < 1 / 3:
                x, y, z = place.draw(rng).tolist()
                ends.append((x, y, z))
            else:
                above = reach.place_above(surfaces[int(rng.integers(len(surfaces)))])
                ends += [] if above is None else [above]
        if len(ends) < 2 or math.dist(*ends) < _LEAST_FLIGHT_M:
            continue
        corners = reach.shortest_path(*ends)
        if corners is not None:
            return smooth_path([tuple(corner) for corner in corners.tolist()], is_loop=False)
    raise ImagesError(
        f"scene {scene.scene_id!r} has no path of {_LEAST_FLIGHT_M:g} m for a vehicle "
        f"{_VEHICLE!r}; valid: --poses free"
    )
