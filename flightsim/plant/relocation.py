"""Puts a vehicle elsewhere in its world within no time, and takes its estimator along.

The estimator's errors stay as they are: what it believes moves and turns exactly as the vehicle
does. Otherwise every aid would contradict it after the jump, and it would have to start anew.
"""

from __future__ import annotations

import math
from typing import Any

import mujoco
import numpy as np

from autonomy.rotation import yaw_from_quat
from autonomy.types import Quaternion, Vector3
from flightsim.plant.memory import PlantMemory
from flightsim.sensors.gnss import GNSS
from flightsim.sensors.imu import IMU
from flightsim.sensors.mocap import MOCAP
from flightsim.sensors.vio import VIO

_DEEPEST_M = 0.1
"""Penetration that contacts resolve without throwing the vehicle away."""
FARTHEST_M = 1e4
"""Greatest coordinate of a place."""


class PlaceTakenError(ValueError):
    """A vehicle cannot be put where it would be inside of a solid, or beyond all bounds.

    Attributes:
        geom: The geom that is in the way; -1 if the place is beyond all bounds.
    """

    def __init__(self, line: str, geom: int) -> None:
        super().__init__(line)
        self.geom = geom


def relocate(memory: PlantMemory, position_enu_m: Vector3, quat_wxyz: Quaternion) -> None:
    """Put a vehicle at rest at a pose; its rotors keep their speeds.

    Args:
        memory: Memory of the vehicle.
        position_enu_m: New position of its centre of mass.
        quat_wxyz: New attitude, body to world, a unit quaternion.

    Raises:
        PlaceTakenError: If it would be deep inside of a solid; it then stays where it is.
    """
    if not all(abs(coordinate) <= FARTHEST_M for coordinate in position_enu_m):
        raise PlaceTakenError(
            f"position {position_enu_m} is beyond all bounds; valid: up to {FARTHEST_M:g} m", -1
        )
    data, model, body = memory.data, memory.world.model, memory.world.vehicle_body_id
    before = memory.qpos.copy()
    memory.qpos[:] = (*position_enu_m, *quat_wxyz)
    geom = _obstacle(model, data, body)
    if geom is not None:
        memory.qpos[:] = before
        _update_poses(model, data)
        raise PlaceTakenError(f"position {position_enu_m} is inside of a solid", geom)
    change_mps = -memory.qvel[:3]
    _take_along(memory, before, change_mps)
    memory.qvel[:] = 0.0
    dof = model.jnt_dofadr[model.body_jntadr[body]]
    data.qacc_warmstart[dof : dof + 6] = 0.0


def _update_poses(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    mujoco.mj_kinematics(model, data)
    mujoco.mj_camlight(model, data)


def _obstacle(model: mujoco.MjModel, data: mujoco.MjData, body: int) -> int | None:
    """Geom that a vehicle is too deep inside of; None if there is none."""
    _update_poses(model, data)
    mujoco.mj_collision(model, data)
    for contact in data.contact[: data.ncon] if data.ncon else ():
        bodies = model.geom_bodyid[contact.geom].tolist()
        if contact.dist < -_DEEPEST_M and body in bodies:
            return int(contact.geom[1 - bodies.index(body)])
    return None


def _take_along(memory: PlantMemory, before: np.ndarray, change_mps: np.ndarray) -> None:
    """Move everything that remembers where the vehicle was or is."""
    moved_m = memory.qpos[:3] - before[:3]
    turned_rad = yaw_from_quat(memory.qpos[3:]) - yaw_from_quat(before[3:])
    record: Any = memory.plant
    f, gnss, vio, mocap = (record[name] for name in ("filter", GNSS.name, VIO.name, MOCAP.name))
    f["position_enu_m"] += moved_m
    f["velocity_enu_mps"] += change_mps
    # The error of the attitude is a rotation in the world, from the truth to the estimate.
    error = _product(f["quat_wxyz"], _inverse(before[3:]))
    f["quat_wxyz"] = _product(error, memory.qpos[3:])
    f["angular_rate_flu_radps"] -= memory.qvel[3:]
    f["past_position_enu_m"] += moved_m
    f["past_velocity_enu_mps"] += change_mps
    f["past_yaw_rad"] += turned_rad
    f["start_enu_m"] += moved_m
    f["terrain_height_m"] = math.nan
    # The IMU measures the change since its last sample, and there has been none to measure.
    record[IMU.name]["last_velocity_enu_mps"] += change_mps
    record[IMU.name]["last_quat_wxyz"] = memory.qpos[3:]
    gnss["past_position_enu_m"] += moved_m
    gnss["past_velocity_enu_mps"] += change_mps
    mocap["position_enu_m"] += moved_m
    mocap["yaw_rad"] += turned_rad
    # Odometry measures in a frame of its own, and has a sample under way.
    c, s = math.cos(vio["frame_yaw_rad"]), math.sin(vio["frame_yaw_rad"])
    x, y, z = moved_m
    moved_vio_m = np.array([c * x + s * y, c * y - s * x, z])
    vio["odometer_m"] += moved_vio_m
    vio["position_vio_m"] += moved_vio_m
    vio["last_position_enu_m"] += moved_m
    vio["yaw_vio_rad"] += turned_rad


def _inverse(quat_wxyz: np.ndarray) -> np.ndarray:
    return quat_wxyz * (1.0, -1.0, -1.0, -1.0)


def _product(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    out = np.empty(4)
    mujoco.mju_mulQuat(out, np.ascontiguousarray(a), np.ascontiguousarray(b))
    return out
