"""The pilot's view of the ground: downward depth images become a map, the map a touchdown point."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import shapely
from scipy.spatial.transform import Rotation

from aeroscene.scene import InteractionArea
from autonomy.model.quadrotor import Vector3
from autonomy.perception.elevation import DepthImage, ElevationMap
from autonomy.perception.landing import LandingMap, LandingNeeds, LandingSite, assess, choose_site
from autonomy.types import Quaternion
from flightsim.sensors.camera import RgbdFrame
from flightsim.vehicles.airframe import Airframe, CameraMount

CAMERA = "down"
TOUCHDOWN_SCATTER_M = 0.08
"""Room left around feet and rotors for an estimate and a descent that are not exact."""
MAP_MARGIN_M = 0.8
"""How far the map reaches beyond the landing area."""
MAX_HALF_EXTENT_M = 3.0


@dataclass(frozen=True, eq=False)
class View:
    """What was made of the frames so far."""

    landing: LandingMap
    site: LandingSite | None
    """The best place inside the landing area."""


class LandingEye:
    """Fuses what the downward camera sees of one landing area."""

    def __init__(self, area: InteractionArea, airframe: Airframe) -> None:
        self._area = area
        self._mount = next(mount for mount in airframe.cameras if mount.name == CAMERA)
        self._needs = LandingNeeds(
            footprint_radius_m=airframe.leg_spread_m + TOUCHDOWN_SCATTER_M,
            body_radius_m=airframe.collision_radius_m + TOUCHDOWN_SCATTER_M,
        )
        self.forget()

    def forget(self) -> None:
        """Begin a new map."""
        reach_m = max(math.dist(v[:2], self._area.centroid[:2]) for v in self._area.polygon)
        self._elevation = ElevationMap(
            self._area.centroid, half_extent_m=min(reach_m + MAP_MARGIN_M, MAX_HALF_EXTENT_M)
        )
        east, north = self._elevation.cell_centres()
        polygon = shapely.Polygon([vertex[:2] for vertex in self._area.polygon])
        self._is_allowed = shapely.contains_xy(polygon, *np.meshgrid(east, north))
        self.n_frames = 0

    def look(self, frame: RgbdFrame, position_enu_m: Vector3, quat_wxyz: Quaternion) -> None:
        """Add a frame that was taken where the vehicle believes it is; the true pose stays unused.

        Args:
            frame: From the downward camera.
            position_enu_m: Estimated position of the vehicle.
            quat_wxyz: Its estimated attitude, FLU to ENU.
        """
        eye_enu_m, rotation = camera_pose(position_enu_m, quat_wxyz, self._mount)
        self._elevation.add(
            DepthImage(
                depth_m=frame.depth_m,
                fx=frame.fx,
                fy=frame.fy,
                cx=frame.cx,
                cy=frame.cy,
                position_enu_m=eye_enu_m,
                rotation_enu_from_optical=rotation,
            )
        )
        self.n_frames += 1

    def judge(self, preferred_enu_m: Vector3) -> View:
        """Assess the map and choose the best place near a preferred one."""
        landing = assess(self._elevation, self._needs, self._is_allowed)
        return View(landing, choose_site(landing, self._elevation, self._needs, preferred_enu_m))

    def is_safe(self, landing: LandingMap, place_enu_m: Vector3) -> bool:
        """Whether the map still holds a place to be safe."""
        row, column = self._elevation.cell(place_enu_m[0], place_enu_m[1])
        return bool(landing.is_safe[row, column])


def camera_pose(
    position_enu_m: Vector3, quat_wxyz: Quaternion, mount: CameraMount
) -> tuple[Vector3, np.ndarray]:
    """Where a camera of a vehicle is and looks: position, rotation from optical axes to ENU (3, 3).

    The optical axes are x right, y down, z forward.
    """
    rotation_enu_from_flu = Rotation.from_quat(quat_wxyz, scalar_first=True).as_matrix()
    dip = mount.pitch_down_rad
    forward = np.array([math.cos(dip), 0.0, -math.sin(dip)])
    right = np.array([0.0, -1.0, 0.0])
    rotation_flu_from_optical = np.column_stack([right, np.cross(forward, right), forward])
    x, y, z = np.array(position_enu_m) + rotation_enu_from_flu @ mount.position_flu_m
    return (float(x), float(y), float(z)), rotation_enu_from_flu @ rotation_flu_from_optical
