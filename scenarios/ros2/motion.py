"""Messages of a vehicle's motion: odometry, transforms and inertial measurements."""

from __future__ import annotations

from typing import Any

import numpy as np

from scenarios.ros2.messages import RosMessages

_NONE_36 = np.zeros(36)
_NONE_9 = np.zeros(9)
_UNKNOWN_9 = np.array([-1.0, *np.zeros(8)])
"""Covariance of a quantity that a message lacks: ROS marks it by -1 in the first element."""


def odometry(
    ros: RosMessages,
    header: Any,
    child: str,
    position: Any,
    wxyz: Any,
    velocity_enu_mps: Any,
    rate_flu_radps: Any,
) -> Any:
    """Return a nav_msgs/Odometry without covariances, which are all zero.

    Args:
        ros: Maker of messages.
        header: Time, and a world frame in ENU.
        child: Body frame in FLU.
        position: Position in the world frame, m.
        wxyz: Attitude, body to world.
        velocity_enu_mps: Velocity in the world frame; the message has it in the body frame.
        rate_flu_radps: Angular rate in the body frame.
    """
    twist = ros.new(
        "geometry_msgs/Twist",
        linear=ros.vector(in_body(velocity_enu_mps, wxyz)),
        angular=ros.vector(rate_flu_radps),
    )
    return ros.new(
        "nav_msgs/Odometry",
        header=header,
        child_frame_id=child,
        pose=ros.new(
            "geometry_msgs/PoseWithCovariance", pose=ros.pose(position, wxyz), covariance=_NONE_36
        ),
        twist=ros.new("geometry_msgs/TwistWithCovariance", twist=twist, covariance=_NONE_36),
    )


def imu(ros: RosMessages, header: Any, accel_flu_mps2: Any, gyro_flu_radps: Any) -> Any:
    """Return a sensor_msgs/Imu of specific force and angular rate, without an orientation.

    Args:
        ros: Maker of messages.
        header: Time and body frame.
        accel_flu_mps2: Specific force, which is (0, 0, 9.81) at rest.
        gyro_flu_radps: Angular rate.
    """
    return ros.new(
        "sensor_msgs/Imu",
        header=header,
        orientation=ros.quaternion((1.0, 0.0, 0.0, 0.0)),
        orientation_covariance=_UNKNOWN_9,
        angular_velocity=ros.vector(gyro_flu_radps),
        angular_velocity_covariance=_NONE_9,
        linear_acceleration=ros.vector(accel_flu_mps2),
        linear_acceleration_covariance=_NONE_9,
    )


def in_body(vector_enu: Any, quat_wxyz: Any) -> tuple[float, float, float]:
    """Return a vector of the world in the body's frame.

    Args:
        vector_enu: Vector in the world frame.
        quat_wxyz: Attitude, body to world.
    """
    vx, vy, vz = vector_enu
    w, x, y, z = quat_wxyz
    # The inverse rotation: v + 2 w (v x q) + 2 q x (q x v), with q the vector part.
    tx, ty, tz = 2.0 * (y * vz - z * vy), 2.0 * (z * vx - x * vz), 2.0 * (x * vy - y * vx)
    return (
        float(vx - w * tx + (y * tz - z * ty)),
        float(vy - w * ty + (z * tx - x * tz)),
        float(vz - w * tz + (x * ty - y * tx)),
    )
