"""Messages of point clouds."""

from __future__ import annotations

from typing import Any

import numpy as np

from scenarios.ros2.messages import RosMessages

_FLOAT32 = 7
"""Number of the type float32 in sensor_msgs/PointField."""
_POINT_BYTES = 12  # three times float32


def cloud(ros: RosMessages, header: Any, points_m: np.ndarray, *, is_dense: bool = True) -> Any:
    """Return a sensor_msgs/PointCloud2 with x, y and z in float32.

    Args:
        ros: Maker of messages.
        header: Time and frame of the points.
        points_m: Points of shape (n, 3), or (height, width, 3) in the order of an image.
        is_dense: True if all points are finite.
    """
    height, width = (1, len(points_m)) if points_m.ndim == 2 else points_m.shape[:2]
    fields = [
        ros.new("sensor_msgs/PointField", name=axis, offset=4 * k, datatype=_FLOAT32, count=1)
        for k, axis in enumerate("xyz")
    ]
    return ros.new(
        "sensor_msgs/PointCloud2",
        header=header,
        height=height,
        width=width,
        fields=fields,
        is_bigendian=False,
        point_step=_POINT_BYTES,
        row_step=_POINT_BYTES * width,
        data=np.ascontiguousarray(points_m, dtype="<f4").reshape(-1).view(np.uint8),
        is_dense=is_dense,
    )
