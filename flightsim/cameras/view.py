"""RGB-D frames and their viewpoints."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import mujoco
import numpy as np

from autonomy.types import Vector3

Quality = Literal["fast", "fine"]
NO_OBJECT_ID = -3
"""Object id of the sky in an image of ids; the others are those of `World.geom_object_id`."""


class CameraError(ValueError):
    """The camera, size or backend does not exist."""


@dataclass(frozen=True, kw_only=True, eq=False)
class PosedDepth:
    """One image of depth with the pose of its camera.

    Pixel (column u, row v) looks along ((u - cx) / fx, (v - cy) / fy, 1) in the optical frame
    (x right, y down, z forward); whole numbers are pixel centres.
    """

    time_us: int
    camera: str
    depth_m: np.ndarray
    """Distance along the optical axis in m, float32 (height, width); inf for the sky."""
    fx: float
    fy: float
    cx: float
    cy: float
    position_enu_m: Vector3
    rotation_enu_from_optical: np.ndarray
    """Rotation matrix (3, 3)."""


@dataclass(frozen=True, kw_only=True, eq=False)
class RgbdFrame(PosedDepth):
    """The same with colours and, if `Cameras` segments, with the object and class of each pixel."""

    rgb: np.ndarray
    """Colours, uint8 (height, width, 3)."""
    instance_ids: np.ndarray | None = None
    """Object of each pixel, int32 (height, width): ids of the scene's objects, -1 the vehicle, -2
    the bare ground, -3 the sky, -4 the surroundings of the site, movers from -10 down, other
    vehicles from -100 down; None unless `Cameras` segments."""
    class_ids: np.ndarray | None = None
    """Class of each pixel, uint8 (height, width): keys of `segmentation.CLASS_NAMES`; None
    likewise."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Viewpoint:
    """A pinhole camera in the world."""

    name: str
    position_enu_m: np.ndarray
    """Position (3,)."""
    rotation_enu_from_optical: np.ndarray
    """Rotation matrix (3, 3)."""
    vertical_fov_rad: float

    def focal_px(self, height: int) -> float:
        """Return the focal length in pixels for an image of this height."""
        return height / 2 / math.tan(self.vertical_fov_rad / 2)

    def rays_enu(self, width: int, height: int) -> np.ndarray:
        """Return the direction of each pixel in ENU, one metre deep.

        The distance along such a direction, in its lengths, is therefore the depth.

        Args:
            width: Width of the picture in pixels.
            height: Height of the picture in pixels.

        Returns:
            Directions (height, width, 3) float32, top row first.
        """
        columns, rows = np.arange(width), np.arange(height)[:, None]
        return self.rays_enu_at(rows, columns, width, height)

    def rays_enu_at(
        self, rows: np.ndarray, columns: np.ndarray, width: int, height: int
    ) -> np.ndarray:
        """Return the direction of some pixels of an image, (..., 3) float32, one metre deep.

        Args:
            rows: Rows of the pixels.
            columns: Columns of the pixels, of a shape that broadcasts with `rows`.
            width: Width of the image.
            height: Height of the image.
        """
        focal = np.float32(self.focal_px(height))
        x = (columns - np.float32((width - 1) / 2)).astype(np.float32) / focal
        y = (rows - np.float32((height - 1) / 2)).astype(np.float32) / focal
        right, down, forward = self.rotation_enu_from_optical.T.astype(np.float32)
        return x[..., None] * right + (y[..., None] * down + forward)

    def frame(self, time_us: int, rgb: np.ndarray, depth_m: np.ndarray) -> RgbdFrame:
        """Return a frame taken from this viewpoint."""
        return RgbdFrame(rgb=rgb, **vars(self.depth_frame(time_us, depth_m)))

    def depth_frame(self, time_us: int, depth_m: np.ndarray) -> PosedDepth:
        """Return a frame without colours taken from this viewpoint."""
        height, width = depth_m.shape
        focal = self.focal_px(height)
        x, y, z = self.position_enu_m.tolist()
        return PosedDepth(
            time_us=time_us,
            camera=self.name,
            depth_m=depth_m,
            fx=focal,
            fy=focal,
            cx=(width - 1) / 2,
            cy=(height - 1) / 2,
            position_enu_m=(x, y, z),
            rotation_enu_from_optical=self.rotation_enu_from_optical,
        )


class PoseCopy:
    """Positions of all bodies at the state of another `MjData`, computed in a copy.

    After a step `MjData` holds positions from before the integration; recomputing them there
    could change the flight's last bits, so cameras do it in their own data.
    """

    def __init__(
        self, model: mujoco.MjModel, name_in_model: Callable[[str], str] = lambda camera: camera
    ) -> None:
        self._model = model
        self._name_in_model = name_in_model
        self.data = mujoco.MjData(model)
        mujoco.mj_forward(model, self.data)

    def update(self, data: mujoco.MjData) -> None:
        """Copy the state of `data`, of this model or of one with the same moving bodies."""
        self.data.qpos[:] = data.qpos
        if self._model.nmocap:
            self.data.mocap_pos[:] = data.mocap_pos
            self.data.mocap_quat[:] = data.mocap_quat
        # Kinematics alone: velocities and forces are not drawn.
        mujoco.mj_kinematics(self._model, self.data)
        mujoco.mj_camlight(self._model, self.data)

    def viewpoint(self, camera_name: str) -> Viewpoint:
        """Return the present viewpoint of a camera of the vehicle.

        Raises:
            CameraError: If the model has no such camera.
        """
        try:
            camera_id = self._model.camera(self._name_in_model(camera_name)).id
        except KeyError:
            valid = ", ".join(self._model.camera(i).name for i in range(self._model.ncam))
            raise CameraError(f"camera {camera_name!r} is unknown; valid: {valid}") from None
        # MuJoCo's cameras look along -z with y up: flip both for the optical frame.
        right_up_back = self.data.cam_xmat[camera_id].reshape(3, 3)
        return Viewpoint(
            name=camera_name,
            position_enu_m=self.data.cam_xpos[camera_id].copy(),
            rotation_enu_from_optical=right_up_back * np.array([1.0, -1.0, -1.0]),
            vertical_fov_rad=math.radians(float(self._model.cam_fovy[camera_id])),
        )


def look_at(eye_enu_m: Vector3, target_enu_m: Vector3, vertical_fov_rad: float) -> Viewpoint:
    """Return the viewpoint at an eye with a target in the centre of an upright image.

    Args:
        eye_enu_m: Position of the eye.
        target_enu_m: Point in the centre.
        vertical_fov_rad: Vertical field of view.

    Raises:
        CameraError: If eye and target coincide.
    """
    eye = np.array(eye_enu_m, dtype=float)
    forward = np.array(target_enu_m, dtype=float) - eye
    distance_m = float(np.linalg.norm(forward))
    if not distance_m > 0:
        raise CameraError(f"target_enu_m {target_enu_m} is the eye itself; valid: another point")
    forward /= distance_m
    right = np.array([forward[1], -forward[0], 0.0])
    sideways = float(np.linalg.norm(right))
    # Straight down or up: north is the top of the image.
    right = right / sideways if sideways > 1e-9 else np.array([1.0, 0.0, 0.0])
    down = np.cross(forward, right)
    return Viewpoint(
        name="view",
        position_enu_m=eye,
        rotation_enu_from_optical=np.column_stack([right, down, forward]),
        vertical_fov_rad=vertical_fov_rad,
    )
