"""Messages of cameras: images, lenses, and depth images as point clouds."""

from __future__ import annotations

from typing import Any

import numpy as np

from scenarios.ros2.clouds import cloud
from scenarios.ros2.messages import RosMessages

Lens = tuple[float, float, float, float]
"""Focal lengths and centre in pixels: fx, fy, cx, cy."""


def image(ros: RosMessages, header: Any, pixels: np.ndarray, encoding: str) -> Any:
    """Return a sensor_msgs/Image.

    Args:
        ros: Maker of messages.
        header: Time and optical frame.
        pixels: Pixels of shape (height, width) or (height, width, channels).
        encoding: Encoding that fits them, such as "rgb8" or "16UC1".
    """
    pixels = np.ascontiguousarray(pixels)
    height, width = pixels.shape[:2]
    return ros.new(
        "sensor_msgs/Image",
        header=header,
        height=height,
        width=width,
        encoding=encoding,
        is_bigendian=0,
        step=pixels.strides[0],
        data=pixels.reshape(-1).view(np.uint8),
    )


def camera_info(ros: RosMessages, header: Any, size_px: tuple[int, int], lens: Lens) -> Any:
    """Return a sensor_msgs/CameraInfo of a pinhole camera without distortion.

    Args:
        ros: Maker of messages.
        header: Time and optical frame.
        size_px: Width and height.
        lens: Focal lengths and centre.
    """
    width, height = size_px
    fx, fy, cx, cy = lens
    no_region = ros.new(
        "sensor_msgs/RegionOfInterest", x_offset=0, y_offset=0, height=0, width=0, do_rectify=False
    )
    return ros.new(
        "sensor_msgs/CameraInfo",
        header=header,
        height=height,
        width=width,
        # Five zeros of ROS's usual model stand for a lens without distortion.
        distortion_model="plumb_bob",
        d=np.zeros(5),
        k=np.array([fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0]),
        r=np.eye(3).ravel(),
        p=np.array([fx, 0.0, cx, 0.0, 0.0, fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0]),
        binning_x=0,
        binning_y=0,
        roi=no_region,
    )


def depth_cloud(ros: RosMessages, header: Any, depth_m: np.ndarray, lens: Lens) -> Any:
    """Return a depth image as a point cloud in the optical frame, row by row.

    Args:
        ros: Maker of messages.
        header: Time and optical frame.
        depth_m: Depth along the optical axis; pixels that are not finite become NaN.
        lens: Focal lengths and centre.
    """
    fx, fy, cx, cy = lens
    height, width = depth_m.shape
    # The inverse of the pinhole: x = (column - cx) / fx * z, and y alike.
    z = np.where(np.isfinite(depth_m), depth_m, np.nan).astype(np.float32)
    x = ((np.arange(width) - cx) / fx).astype(np.float32) * z
    y = ((np.arange(height) - cy) / fy).astype(np.float32)[:, None] * z
    return cloud(ros, header, np.dstack([x, y, z]), is_dense=False)
