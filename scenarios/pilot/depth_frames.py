"""Depth frames of the vehicle's cameras, posed by the vehicle's own estimate.

A real companion computer does not know the true pose of its cameras. Frames therefore come without
one, and the pose follows from telemetry and the mount.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Protocol

import numpy as np
from jaxtyping import Float

from autonomy.perception import DepthImage, camera_pose
from flightsim.mavlink.client.telemetry import Telemetry
from flightsim.vehicles.airframe import Airframe, CameraMount


class NoDepthError(ValueError):
    """A depth image has no measured pixel, for example one of bare sky."""


class DepthFrame(Protocol):
    """Camera frame without its true pose, which the pilot must not know."""

    @property
    def depth_m(self) -> np.ndarray:
        """Depth along the optical axis, float32 (height, width)."""
        ...

    @property
    def fx(self) -> float:
        """Horizontal focal length, px."""
        ...

    @property
    def fy(self) -> float:
        """Vertical focal length, px."""
        ...

    @property
    def cx(self) -> float:
        """Horizontal principal point, px."""
        ...

    @property
    def cy(self) -> float:
        """Vertical principal point, px."""
        ...


Frames = Callable[[str], DepthFrame]
"""Function that renders the present frame of the named camera."""


def camera_mount(airframe: Airframe, camera: str) -> CameraMount:
    """Return the mount of a camera that the vehicle has."""
    return next(mount for mount in airframe.cameras if mount.name == camera)


def posed_image(frame: DepthFrame, mount: CameraMount, telemetry: Telemetry) -> DepthImage:
    """Return the depth image of a frame, taken from the pose in the telemetry.

    Raises:
        NoDepthError: If no pixel was measured.
    """
    depth_m = frame.depth_m
    # Comparisons with NaN are false, so this counts measured pixels only.
    if not np.any((depth_m > 0) & (depth_m < np.inf)):
        height, width = depth_m.shape
        raise NoDepthError(
            f"camera {mount.name} measured none of {width} x {height} pixels; valid: a surface "
            "within its range, lens and light as it needs them"
        )
    position_enu_m, rotation = camera_pose(
        telemetry.position_enu_m,
        telemetry.quat_wxyz,
        mount.position_flu_m,
        mount.pitch_down_rad,
        mount.yaw_rad,
    )
    return DepthImage(
        depth_m=depth_m,
        fx=frame.fx,
        fy=frame.fy,
        cx=frame.cx,
        cy=frame.cy,
        position_enu_m=position_enu_m,
        rotation_enu_from_optical=rotation,
    )


def may_show(
    mount: CameraMount,
    aspect: float,
    telemetry: Telemetry,
    points_enu_m: Float[np.ndarray, "n 3"],
    reach_m: float,
) -> bool:
    """Return whether a camera may show something that extends about one of several points.

    Args:
        mount: The camera.
        aspect: Width of its images over their height.
        telemetry: State of the vehicle.
        points_enu_m: The points.
        reach_m: Radius of the object about each point.
    """
    eye_enu_m, rotation = camera_pose(
        telemetry.position_enu_m,
        telemetry.quat_wxyz,
        mount.position_flu_m,
        mount.pitch_down_rad,
        mount.yaw_rad,
    )
    x, y, z = ((points_enu_m - eye_enu_m) @ rotation).T
    up = math.tan(mount.vertical_fov_rad / 2)
    aside = up * aspect
    # Distances from the planes through the eye and the borders of the image.
    beyond_m = np.maximum(
        (np.abs(x) - aside * z) / math.hypot(1.0, aside), (np.abs(y) - up * z) / math.hypot(1.0, up)
    )
    # Behind the camera only by the radius: a large object may begin beside the lens.
    return bool(np.any((beyond_m < reach_m) & (z > -reach_m)))
