"""Calls about cameras: images, poses and lenses."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

import numpy as np

from scenarios.airsim import pictures
from scenarios.airsim.cameras import Camera, Lens, Renderers, find_camera
from scenarios.airsim.control_calls import Find
from scenarios.airsim.craft import Craft
from scenarios.airsim.frames import floats, stamp
from scenarios.airsim.messages import (
    CameraInfo,
    ImageRequest,
    ImageResponse,
    Pose,
    ProjectionMatrix,
)
from scenarios.airsim.methods import RpcError
from scenarios.airsim.objects import Objects
from scenarios.airsim.pictures import ImageType
from scenarios.airsim.rangers import quaternion_ned
from scenarios.airsim.weather import Weather

_MOST_REQUESTS = 64
_NARROWEST_DEG, _WIDEST_DEG = 1.0, 170.0
_NEAR_M = 0.01
_NO_FLOATS = floats(np.zeros(1))


class ImageCalls:
    """Methods by their names in AirSim, each for the vehicle that it names."""

    def __init__(
        self,
        find: Find,
        cameras: Mapping[str, Mapping[str, Camera]],
        renderers: Renderers,
        objects: Objects,
        weather: Weather,
    ) -> None:
        """Look through cameras.

        Args:
            find: Knows vehicles by their names.
            cameras: Cameras of each vehicle by its name and theirs.
            renderers: Renders.
            objects: Numbers of objects for segmentation.
            weather: Fog and dust.
        """
        self._find, self._cameras, self._renderers = find, cameras, renderers
        self._objects, self._weather = objects, weather

    @property
    def functions(self) -> Mapping[str, Callable[..., object]]:
        """All methods."""
        return {
            "simGetImages": self.images,
            "simGetImage": self.image,
            "simGetCameraInfo": self.info,
            "simSetCameraPose": self.set_pose,
            "simSetCameraFov": self.set_fov,
            "simGetCurrentFieldOfView": self.field_of_view,
        }

    def images(
        self, requests: list[ImageRequest], vehicle_name: str = "", external: bool = False
    ) -> list[ImageResponse]:
        """Take pictures, all of this moment."""
        _require_vehicle(external)
        if len(requests) > _MOST_REQUESTS:
            raise RpcError(f"{len(requests)} images are asked for; valid: up to {_MOST_REQUESTS}")
        craft = self._find(vehicle_name)
        return [self._take(craft, request) for request in requests]

    def image(
        self,
        camera_name: str,
        image_type: int,
        vehicle_name: str = "",
        annotation_name: str = "",
    ) -> bytes:
        """Take one picture as PNG."""
        request = ImageRequest(camera_name, image_type, False, True, annotation_name)
        return self._take(self._find(vehicle_name), request).image_data_uint8

    def info(self, camera_name: str, vehicle_name: str = "", external: bool = False) -> CameraInfo:
        """Pose in the vehicle's local frame, field of view and projection."""
        _require_vehicle(external)
        craft = self._find(vehicle_name)
        camera = self._camera(craft, camera_name)
        lens = camera.lens_of(ImageType.SCENE)
        return CameraInfo(_pose_now(craft, camera, lens), lens.fov_deg, _projection(lens))

    def set_pose(
        self, camera_name: str, pose: Pose, vehicle_name: str = "", external: bool = False
    ) -> None:
        """Move a camera on the vehicle."""
        _require_vehicle(external)
        camera = self._camera(self._find(vehicle_name), camera_name)
        if not pose.position.is_finite:
            raise RpcError("pose has a position that is not finite; valid: metres")
        quat = pose.orientation
        norm = math.hypot(quat.w_val, quat.x_val, quat.y_val, quat.z_val)
        if not 1e-6 < norm < math.inf:
            raise RpcError("pose has no attitude; valid: a quaternion that is not zero")
        camera.pose = pose

    def set_fov(
        self,
        camera_name: str,
        fov_degrees: float,
        vehicle_name: str = "",
        external: bool = False,
    ) -> None:
        """Zoom a camera."""
        _require_vehicle(external)
        camera = self._camera(self._find(vehicle_name), camera_name)
        if not _NARROWEST_DEG <= fov_degrees <= _WIDEST_DEG:
            raise RpcError(
                f"fov_degrees {fov_degrees} is not valid; valid: {_NARROWEST_DEG:g} to "
                f"{_WIDEST_DEG:g}"
            )
        for lens in (camera.lens, *camera.lenses.values()):
            lens.fov_deg = fov_degrees

    def field_of_view(
        self, camera_name: str, vehicle_name: str = "", external: bool = False
    ) -> str:
        """Horizontal field of view in degrees; AirSim answers with a text."""
        _require_vehicle(external)
        camera = self._camera(self._find(vehicle_name), camera_name)
        return f"{camera.lens_of(ImageType.SCENE).fov_deg:g}"

    def _camera(self, craft: Craft, name: str) -> Camera:
        return find_camera(self._cameras[craft.name], name)

    def _take(self, craft: Craft, request: ImageRequest) -> ImageResponse:
        camera = self._camera(craft, request.camera_name)
        try:
            kind = ImageType(request.image_type)
        except ValueError:
            valid = ", ".join(str(int(each)) for each in ImageType)
            raise RpcError(
                f"image type {request.image_type} is not offered; valid: {valid}"
            ) from None
        lens = camera.lens_of(kind)
        is_float = request.pixels_as_float
        if is_float and kind not in pictures.DEPTHS:
            raise RpcError(f"pixels_as_float is not offered for image type {kind.value}")
        data = b"\0"
        numbers = _NO_FLOATS
        if is_float:
            frame = self._renderers.frame(craft.vehicle.plant, camera, lens)
            numbers = floats(pictures.depth_values(frame, kind))
        else:
            rgb = self._pixels(craft, camera, lens, kind)
            # AirSim's bytes are blue, green, red, as OpenCV writes them.
            data = _png(rgb) if request.compress else rgb[:, :, ::-1].tobytes()
        pose = _pose_now(craft, camera, lens)
        return ImageResponse(
            image_data_uint8=data,
            image_data_float=numbers,
            camera_position=pose.position,
            camera_name=request.camera_name,
            camera_orientation=pose.orientation,
            time_stamp=stamp(craft.vehicle.plant.time_us),
            pixels_as_float=is_float,
            compress=request.compress,
            width=lens.width_px,
            height=lens.height_px,
            image_type=kind.value,
            annotation_name=request.annotation_name,
        )

    def _pixels(self, craft: Craft, camera: Camera, lens: Lens, kind: ImageType) -> np.ndarray:
        plant = craft.vehicle.plant
        if kind is ImageType.SEGMENTATION:
            ids = self._renderers.ids(plant, camera, lens)
            return pictures.segment_pixels(ids, self._objects.segment_ids)
        frame = self._renderers.frame(plant, camera, lens)
        if kind is ImageType.SURFACE_NORMALS:
            return pictures.normal_pixels(frame)
        if kind in pictures.DEPTHS:
            return pictures.depth_pixels(frame, kind)
        return self._weather.seen(frame)


def _require_vehicle(external: bool) -> None:
    if external:
        raise RpcError("external cameras are not offered; valid: cameras of a vehicle")


def _pose_now(craft: Craft, camera: Camera, lens: Lens) -> Pose:
    """Pose of a camera in the vehicle's local frame."""
    view = camera.viewpoint(craft.vehicle.plant, lens)
    x, y, z = view.position_enu_m.tolist()
    right, down, forward = view.rotation_enu_from_optical.T
    turn = np.column_stack([forward, right, down])
    return Pose(craft.local((x, y, z)), quaternion_ned(turn))


def _projection(lens: Lens) -> ProjectionMatrix:
    """Projection with the far plane at infinity and reversed depth, as Unreal's."""
    focal = 1.0 / math.tan(0.5 * math.radians(lens.fov_deg))
    aspect = lens.width_px / lens.height_px
    rows = [
        [focal, 0.0, 0.0, 0.0],
        [0.0, focal * aspect, 0.0, 0.0],
        [0.0, 0.0, 0.0, _NEAR_M],
        [0.0, 0.0, 1.0, 0.0],
    ]
    return ProjectionMatrix(rows)


def _png(rgb: np.ndarray) -> bytes:
    import cv2

    is_done, data = cv2.imencode(".png", rgb[:, :, ::-1], [cv2.IMWRITE_PNG_COMPRESSION, 1])
    if not is_done:
        raise RpcError("the image cannot be written as PNG")
    return data.tobytes()
