"""Position and rotation of a camera, from the vehicle's pose and the camera's mount."""

from __future__ import annotations

import math

import numpy as np
from jaxtyping import Float

from autonomy.rotation import matrix_from_quat
from autonomy.types import Quaternion, Vector3


def camera_pose(
    position_enu_m: Vector3,
    quat_wxyz: Quaternion,
    mount_position_flu_m: Vector3,
    mount_pitch_down_rad: float,
    mount_yaw_rad: float = 0.0,
) -> tuple[Vector3, Float[np.ndarray, "3 3"]]:
    """Position of a camera in ENU and the rotation from its optical axes to ENU.

    Optical axes: x right, y down, z forward.

    Args:
        position_enu_m: Estimated position of the vehicle.
        quat_wxyz: Estimated attitude of the vehicle, FLU to ENU, unit.
        mount_position_flu_m: Position of the camera in the body.
        mount_pitch_down_rad: Pitch of the camera: 0 looks along body x, pi/2 straight down with the
            image's top towards body x.
        mount_yaw_rad: Turn of the pitched camera about body z, positive to the left.

    Returns:
        Position in m, and a matrix whose columns are the optical axes.
    """
    rotation_enu_from_flu = np.empty((3, 3))
    matrix_from_quat(np.array(quat_wxyz, dtype=float), rotation_enu_from_flu)
    s, c = math.sin(mount_pitch_down_rad), math.cos(mount_pitch_down_rad)
    rotation_flu_from_optical = np.array([[0.0, -s, c], [-1.0, 0.0, 0.0], [0.0, -c, -s]])
    if mount_yaw_rad != 0.0:
        s, c = math.sin(mount_yaw_rad), math.cos(mount_yaw_rad)
        turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        rotation_flu_from_optical = turn @ rotation_flu_from_optical
    x, y, z = np.array(position_enu_m) + rotation_enu_from_flu @ mount_position_flu_m
    return (float(x), float(y), float(z)), rotation_enu_from_flu @ rotation_flu_from_optical
