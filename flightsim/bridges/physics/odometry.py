"""Poses of visual-inertial odometry for an external flight stack, each when it arrives.

Odometry counts from the start, where PX4's local frame has its origin as well, by its first fix or
because it is told. So it is told positions from there, by north and east, in which they drift: when
PX4 gives up its receiver it goes on with them as they are. Tilt does not drift, since gravity shows
it; our sensor has no error of it.
"""

from __future__ import annotations

import math
from collections import deque
from typing import NamedTuple

from autonomy.types import Quaternion, Vector3, yaw_of
from flightsim.plant import Plant


class OdometryPose(NamedTuple):
    """Pose of the vehicle as odometry has it."""

    time_us: int
    """When it was true."""
    from_start_enu_m: Vector3
    """Way from the start, east, north and up."""
    quat_wxyz: Quaternion
    """FLU to ENU."""


class OdometryPoses:
    """Poses of a plant's odometry, level and north-up; call `arrived` at every control tick."""

    def __init__(self) -> None:
        self._start_yaw_rad: float | None = None
        """Heading at which odometry began."""
        self._seen_us = 0
        self._under_way: deque[tuple[int, OdometryPose]] = deque()
        """Times of arrival, and what arrives then."""

    def arrived(self, plant: Plant) -> OdometryPose | None:
        """The pose that arrives at this tick; None between two, and without odometry."""
        truth = plant.truth
        if self._start_yaw_rad is None:
            self._start_yaw_rad = yaw_of(truth.quat_wxyz)
        reading = plant.sensors.vio
        if reading.time_us != self._seen_us:
            self._seen_us = reading.time_us
            yaw0_rad = self._start_yaw_rad
            (x, y, z), c, s = reading.position_vio_m, math.cos(yaw0_rad), math.sin(yaw0_rad)
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
    """An attitude after a turn about the vertical."""
    (w, x, y, z), c, s = quat_wxyz, math.cos(0.5 * angle_rad), math.sin(0.5 * angle_rad)
    return (c * w - s * z, c * x - s * y, c * y + s * x, c * z + s * w)
