"""Lens of the gimbal's camera, whose pictures are rendered only when somebody wants one.

It is a camera of its own at the place of the airframe's first one. The airframe's cameras are
fixed, because a pilot steers by them. No renderer is open before the first picture, so a flight
without pictures pays nothing.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from autonomy.types import ZERO3, Quaternion, Vector3, yaw_of
from flightsim.cameras import CameraRenderer, RgbdFrame, Viewpoint, open_camera_renderer
from flightsim.payload.gimbal import Gimbal
from flightsim.plant import Plant

Size = Literal["photo", "video"]
SIZES_PX: dict[Size, tuple[int, int]] = {"photo": (1280, 960), "video": (640, 480)}
"""Width and height of the pictures."""
VERTICAL_FOV_RAD = math.radians(60.0)
# Pixels are square, and pictures are 4 to 3.
HORIZONTAL_FOV_RAD = 2.0 * math.atan(4.0 / 3.0 * math.tan(0.5 * VERTICAL_FOV_RAD))
SENSOR_MM = (6.17, 4.63)
"""Width and height of the sensor, one of 1/2.3 inch, for clients that reckon with millimetres."""
FOCAL_LENGTH_MM = 0.5 * SENSOR_MM[1] / math.tan(0.5 * VERTICAL_FOV_RAD)

# Optical axes are x to the right, y down and z forward.
_FLU_FROM_OPTICAL = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])


@dataclass(frozen=True, kw_only=True, slots=True)
class Aim:
    """Place of a camera and the direction in which it looks."""

    position_enu_m: Vector3
    quat_wxyz: Quaternion
    """Attitude of its axes forward, left and up in ENU."""


class Lens:
    """Camera on a gimbal; a renderer for each size opens with the first picture of it."""

    def __init__(self, plant: Plant, gimbal: Gimbal) -> None:
        """Put a camera on a gimbal.

        Args:
            plant: Vehicle that carries it.
            gimbal: Gimbal, whose present angles are read for each picture.
        """
        self._plant = plant
        self._gimbal = gimbal
        cameras = plant.world.airframe.cameras
        self._mount_flu_m = np.array(cameras[0].position_flu_m if cameras else ZERO3)
        self._renderers: dict[Size, CameraRenderer] = {}
        self._latest: dict[Size, RgbdFrame] = {}

    @property
    def is_open(self) -> bool:
        """True if any renderer is open."""
        return bool(self._renderers)

    def aim_est(self) -> Aim:
        """Return the place and direction of the camera by the vehicle's own estimate."""
        state = self._plant.estimate
        return self._aim(state.position_enu_m, state.quat_wxyz)

    def aim_true(self) -> Aim:
        """Return the true place and direction of the camera."""
        state = self._plant.truth
        return self._aim(state.position_enu_m, state.quat_wxyz)

    def render(self, size: Size) -> RgbdFrame:
        """Return the present picture; repeated requests at one time render it once.

        Args:
            size: Name of the size, a key of `SIZES_PX`.
        """
        latest = self._latest.get(size)
        if latest is not None and latest.time_us == self._plant.time_us:
            return latest
        self.open(size)
        plant = self._plant
        frame = self._renderers[size].render_from(plant.data, self._viewpoint(), plant.time_us)
        self._latest[size] = frame
        return frame

    def open(self, size: Size) -> None:
        """Open the renderer for a size now, which takes as long as a hundred pictures.

        Without it the first picture opens the renderer, in the middle of the flight.
        """
        if size not in self._renderers:
            self._renderers[size] = open_camera_renderer(self._plant.world, *SIZES_PX[size])

    def close(self) -> None:
        """Release the renderers."""
        for renderer in self._renderers.values():
            renderer.close()
        self._renderers.clear()

    def _aim(self, position_enu_m: Vector3, quat_wxyz: Quaternion) -> Aim:
        offset_m = _rotation(quat_wxyz) @ self._mount_flu_m
        x, y, z = (np.array(position_enu_m) + offset_m).tolist()
        # Only the heading of the vehicle counts: the gimbal takes out its roll and pitch.
        half_yaw = 0.5 * (yaw_of(quat_wxyz) + self._gimbal.yaw_rad)
        half_pitch = 0.5 * self._gimbal.pitch_down_rad
        cy, sy, cp, sp = (f(a) for a in (half_yaw, half_pitch) for f in (math.cos, math.sin))
        # First about the left axis, by which the nose goes down, then about the vertical.
        attitude = (cy * cp, -sy * sp, cy * sp, sy * cp)
        return Aim(position_enu_m=(x, y, z), quat_wxyz=attitude)

    def _viewpoint(self) -> Viewpoint:
        aim = self.aim_true()
        return Viewpoint(
            name="gimbal",
            position_enu_m=np.array(aim.position_enu_m),
            rotation_enu_from_optical=_rotation(aim.quat_wxyz) @ _FLU_FROM_OPTICAL,
            vertical_fov_rad=VERTICAL_FOV_RAD,
        )


def _rotation(quat_wxyz: Quaternion) -> np.ndarray:
    """Return the rotation matrix (3, 3) of an attitude."""
    w, x, y, z = quat_wxyz
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
