"""Depth frames of the vehicle's cameras, posed by where the vehicle believes it is."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np

from autonomy.perception import DepthImage, camera_pose
from flightsim.mavlink.client.telemetry import Telemetry
from flightsim.vehicles.airframe import Airframe, CameraMount


class NoDepthError(ValueError):
    """A depth image in which nothing was measured."""


class DepthFrame(Protocol):
    """What is needed of a camera frame; where it was really taken is none of our business."""

    @property
    def depth_m(self) -> np.ndarray:
        """Along the optical axis, float32 (height, width)."""
        ...

    @property
    def fx(self) -> float:
        """Focal length, px."""
        ...

    @property
    def fy(self) -> float:
        """Focal length, px."""
        ...

    @property
    def cx(self) -> float:
        """Principal point, px."""
        ...

    @property
    def cy(self) -> float:
        """Principal point, px."""
        ...


Frames = Callable[[str], DepthFrame]
"""Renders the named camera now."""


def camera_mount(airframe: Airframe, camera: str) -> CameraMount:
    """The mount of a camera that the vehicle has."""
    return next(mount for mount in airframe.cameras if mount.name == camera)


def posed_image(frame: DepthFrame, mount: CameraMount, telemetry: Telemetry) -> DepthImage:
    """A frame as an image taken from where telemetry has the vehicle.

    Raises:
        NoDepthError: If not one pixel was measured.
    """
    depth_m = frame.depth_m
    # A comparison with NaN is false, so this counts what was measured.
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
