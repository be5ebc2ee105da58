"""Cameras as AirSim's clients know them: by name, with a pose on the vehicle and a lens."""

from __future__ import annotations

import math
from collections import OrderedDict
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Self

import numpy as np
from jaxtyping import Float

from flightsim.cameras import CameraRenderer, RgbdFrame, Viewpoint, open_camera_renderer
from flightsim.plant import Plant
from flightsim.vehicles import Airframe
from scenarios.airsim.messages import Pose, Quaternionr, Vector3r
from scenarios.airsim.methods import RpcError

WIDTH_PX, HEIGHT_PX = 256, 144
"""Size of AirSim's images, unless its settings say another."""
FOV_DEG = 90.0
MOST_PX = 4320
_KEPT_RENDERERS = 4

_CAMERA_FROM_OPTICAL = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
"""Optical axes (right, down, forward) in the camera's own (forward, right, down)."""
FRD_FROM_FLU = np.diag([1.0, -1.0, -1.0])
"""Forward-right-down from forward-left-up, and back."""


@dataclass(kw_only=True)
class Lens:
    """Size of the images of one kind."""

    width_px: int = WIDTH_PX
    height_px: int = HEIGHT_PX
    fov_deg: float = FOV_DEG
    """Horizontal field of view."""

    @property
    def vertical_fov_rad(self) -> float:
        """Vertical field of view of square pixels."""
        half = math.tan(0.5 * math.radians(self.fov_deg)) * self.height_px / self.width_px
        return 2.0 * math.atan(half)


@dataclass(kw_only=True)
class Camera:
    """A camera: where it is on the vehicle, forward-right-down, and its lenses by image type."""

    name: str
    pose: Pose
    lens: Lens = field(default_factory=Lens)
    lenses: dict[int, Lens] = field(default_factory=dict)

    def lens_of(self, image_type: int) -> Lens:
        """Lens of an image type."""
        return self.lenses.get(image_type, self.lens)

    def viewpoint(self, plant: Plant, lens: Lens) -> Viewpoint:
        """Viewpoint of the camera now, by the true pose of the vehicle."""
        truth, position = plant.truth, self.pose.position
        enu_from_flu = rotation(truth.quat_wxyz)
        offset = np.array([position.x_val, -position.y_val, -position.z_val])
        quat = self.pose.orientation
        own = rotation((quat.w_val, quat.x_val, quat.y_val, quat.z_val))
        return Viewpoint(
            name=f"AirSim {self.name}",
            position_enu_m=np.array(truth.position_enu_m) + enu_from_flu @ offset,
            rotation_enu_from_optical=enu_from_flu @ FRD_FROM_FLU @ own @ _CAMERA_FROM_OPTICAL,
            vertical_fov_rad=lens.vertical_fov_rad,
        )


def rotation(wxyz: tuple[float, float, float, float]) -> Float[np.ndarray, "3 3"]:
    """Rotation matrix of a quaternion."""
    w, x, y, z = (c / math.hypot(*wxyz) for c in wxyz)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def quat_frd(roll_rad: float, pitch_rad: float, yaw_rad: float) -> Quaternionr:
    """Attitude of a part on the vehicle by its angles, forward-right-down."""
    cr, sr = math.cos(0.5 * roll_rad), math.sin(0.5 * roll_rad)
    cp, sp = math.cos(0.5 * pitch_rad), math.sin(0.5 * pitch_rad)
    cy, sy = math.cos(0.5 * yaw_rad), math.sin(0.5 * yaw_rad)
    return Quaternionr(
        cr * cp * cy + sr * sp * sy,
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
    )


_NUMBERED = ("front_center", "front_right", "front_left", "bottom_center", "back_center")
"""AirSim's own cameras, in the order of the numbers that scripts give them."""


def default_cameras(
    airframe: Airframe, lens: Lens, lenses: Mapping[int, Lens]
) -> dict[str, Camera]:
    """AirSim's five cameras on an airframe, and the airframe's own ones under their names.

    Args:
        airframe: The vehicle.
        lens: Lens of AirSim's cameras.
        lenses: The same by image type.
    """
    forward = max(0.1, *(mount.position_flu_m[0] for mount in airframe.cameras), 0.1)
    below = airframe.body_size_m[2] / 2 + 0.01
    aside = 0.06
    straight = Quaternionr()
    places = {
        "front_center": (Vector3r(forward, 0.0, 0.0), straight),
        "front_right": (Vector3r(forward, aside, 0.0), straight),
        "front_left": (Vector3r(forward, -aside, 0.0), straight),
        "bottom_center": (Vector3r(0.0, 0.0, below), quat_frd(0.0, -0.5 * math.pi, 0.0)),
        "back_center": (Vector3r(-forward, 0.0, 0.0), quat_frd(0.0, 0.0, math.pi)),
    }
    cameras = {
        name: Camera(
            name=name,
            pose=Pose(*place),
            lens=replace(lens),
            lenses={kind: replace(each) for kind, each in lenses.items()},
        )
        for name, place in places.items()
    }
    for mount in airframe.rgbd_cameras:
        x, y, z = mount.position_flu_m
        quat = quat_frd(0.0, -mount.pitch_down_rad, -mount.yaw_rad)
        height = math.tan(0.5 * mount.vertical_fov_rad)
        fov_deg = math.degrees(2.0 * math.atan(height * WIDTH_PX / HEIGHT_PX))
        cameras.setdefault(
            mount.name,
            Camera(
                name=mount.name,
                pose=Pose(Vector3r(x, -y, -z), quat),
                lens=Lens(fov_deg=fov_deg),
            ),
        )
    return cameras


def find_camera(cameras: Mapping[str, Camera], name: str) -> Camera:
    """Camera by its name or number.

    Raises:
        RpcError: If there is none.
    """
    if name in cameras:
        return cameras[name]
    if name in ("", "fpv"):
        name = "0"
    if name.isdecimal() and int(name) < len(_NUMBERED) and _NUMBERED[int(name)] in cameras:
        return cameras[_NUMBERED[int(name)]]
    raise RpcError(f"camera {name[:80]!r} is unknown; valid: {', '.join(cameras)}, or 0 to 4")


class Renderers:
    """Renders what cameras see; a renderer for each size is opened when first needed."""

    def __init__(self) -> None:
        self._renderers: OrderedDict[tuple[int, int, int], CameraRenderer] = OrderedDict()
        self._frames: dict[str, tuple[tuple[object, ...], RgbdFrame]] = {}

    def frame(self, plant: Plant, camera: Camera, lens: Lens) -> RgbdFrame:
        """Colours and exact depth of a camera now; kinds of one moment share a picture."""
        key = (plant.world.number, plant.time_us, camera.pose, lens.width_px, lens.height_px)
        key = (*key, lens.fov_deg)
        place = f"{plant.world.number}/{camera.name}"
        kept = self._frames.get(place)
        if kept is not None and kept[0] == key:
            return kept[1]
        renderer = self._renderer(plant, lens)
        frame = renderer.render_from(plant.data, camera.viewpoint(plant, lens), plant.time_us)
        self._frames[place] = (key, frame)
        return frame

    def ids(self, plant: Plant, camera: Camera, lens: Lens) -> np.ndarray:
        """Object id of each pixel, int32 (height, width)."""
        return self._renderer(plant, lens).render_ids_from(
            plant.data, camera.viewpoint(plant, lens)
        )

    def _renderer(self, plant: Plant, lens: Lens) -> CameraRenderer:
        key = (plant.world.number, lens.width_px, lens.height_px)
        renderer = self._renderers.pop(key, None)
        if renderer is None:
            renderer = open_camera_renderer(plant.world, lens.width_px, lens.height_px)
        self._renderers[key] = renderer
        if len(self._renderers) > _KEPT_RENDERERS:
            self._renderers.popitem(last=False)[1].close()
        return renderer

    def close(self) -> None:
        """Close every renderer."""
        while self._renderers:
            self._renderers.popitem()[1].close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()
