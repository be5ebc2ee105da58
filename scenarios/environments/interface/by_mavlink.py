"""Actions as MAVLink setpoints: the same numbers as `actions`, for an autopilot to follow."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from autonomy.types import Quaternion, vector3
from flightsim.mavlink.client import MavlinkClient
from scenarios.environments.cfg import ActionLevel, EnvironmentInputError


def check_offboard(level: ActionLevel) -> None:
    """Refuse actions that no setpoint of MAVLink carries.

    Raises:
        EnvironmentInputError: If the level is "motors".
    """
    if level == "motors":
        raise EnvironmentInputError(
            "action = 'motors': no autopilot takes rotor speeds as setpoints; rates, attitude, "
            "velocity, position are valid"
        )


def send_command(
    client: MavlinkClient, level: ActionLevel, commands: Mapping[str, np.ndarray], index: int = 0
) -> None:
    """Send one vehicle's command as a setpoint.

    Args:
        client: Companion of the vehicle, which has to be in offboard mode.
        level: Meaning of the command; not "motors".
        commands: Fields of set points of n vehicles, from `ActionScale.commands`.
        index: Number of the vehicle.
    """
    of: dict[str, Any] = {name: values[index] for name, values in commands.items()}
    if level == "velocity":
        client.send_velocity(vector3(of["velocity_enu_mps"]), float(of["yaw_rate_radps"]))
    elif level == "position":
        client.send_position(vector3(of["position_enu_m"]), float(of["yaw_rate_radps"]))
    elif level == "rates":
        client.send_attitude(None, vector3(of["angular_rate_flu_radps"]), float(of["thrust"]))
    else:
        quat: Quaternion = tuple(of["quat_wxyz"].tolist())
        client.send_attitude(quat, (0.0, 0.0, 0.0), float(of["thrust"]))
