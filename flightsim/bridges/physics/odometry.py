"""Poses of visual-inertial odometry for an external flight stack, each when it arrives.

Our sensor counts from the vehicle's first pose, with its axes along the first heading. PX4's local
frame has its origin at the same place, by its first fix or by the origin that we send, but its axes
point north and east. The poses are therefore turned by the first heading, and drift in that frame:
when PX4 gives up its receiver it goes on with them as they are. Tilt does not drift, since gravity
shows it; our sensor has no error of it, so it is the true one here.
"""

from __future__ import annotations

import math
from collections import deque
from typing import NamedTuple

from autonomy.types import Quaternion, Vector3, yaw_of
from flightsim.plant import Plant


class OdometryPose(NamedTuple):
    """Pose of the vehicle by odometry."""

    time_us: int
    """Time at which it was measured."""
    from_start_enu_m: Vector3
    """Displacement from the start along east, north and up, with the drift."""
    quat_wxyz: Quaternion
    """Attitude, FLU to ENU, with the drift of the heading."""


class OdometryPoses:
    """Poses of a plant's odometry, level and along north; call `arrived` at every control tick."""

    def __init__(self) -> None:
        self._start_yaw_rad: float | None = None
        """Heading at which odometry began, counter-clockwise from east; None before the first call.
        """
        self._seen_us = 0
        self._under_way: deque[tuple[int, OdometryPose]] = deque()
        """Poses on their way, each with its time of arrival."""

    def arrived(self, plant: Plant) -> OdometryPose | None:
        """Return the pose that arrives at this tick; None if none does, or without odometry.

        Args:
            plant: Vehicle, whose time and odometry are read.
        """
        truth = plant.truth
        if self._start_yaw_rad is None:
            self._start_yaw_rad = yaw_of(truth.quat_wxyz)
        reading = plant.sensors.vio
        if reading.time_us != self._seen_us:
            self._seen_us = reading.time_us
            yaw0_rad = self._start_yaw_rad
            (x, y, z), c, s = reading.position_vio_m, math.cos(yaw0_rad), math.sin(yaw0_rad)
            # Odometry's yaw counts from the first heading, so this is its error alone.
            yaw_error_rad = yaw0_rad + reading.yaw_vio_rad - yaw_of(truth.quat_wxyz)
            pose = OdometryPose(
                reading.time_us,
                (c * x - s * y, s * x + c * y, z),
                _turned(truth.quat_wxyz, yaw_error_rad),
            )
            self._under_way.append((reading.arrives_us, pose))
        if self._under_way and self._under_way[0][0] <= plant.time_us:
            return self._under_way.popleft()[1]
        return None


def _turned(quat_wxyz: Quaternion, angle_rad: float) -> Quaternion:
    """Return an attitude after a turn about the vertical, counter-clockwise seen from above."""
    (w, x, y, z), c, s = quat_wxyz, math.cos(0.5 * angle_rad), math.sin(0.5 * angle_rad)
    return (c * w - s * z, c * x - s * y, c * y + s * x, c * z + s * w)
