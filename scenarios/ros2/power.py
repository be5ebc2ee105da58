"""Message of the battery's state."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from scenarios.ros2.messages import RosMessages

_DISCHARGING = 2
"""POWER_SUPPLY_STATUS_DISCHARGING of sensor_msgs/BatteryState."""


def battery(
    ros: RosMessages, header: Any, voltage_v: float, current_a: float, remaining: float
) -> Any:
    """Return a sensor_msgs/BatteryState.

    Args:
        ros: Maker of messages.
        header: Time and body frame.
        voltage_v: Voltage.
        current_a: Current that flows out, positive; the message has it negative.
        remaining: Charge that is left, 0 to 1.
    """
    nothing = np.zeros(0, dtype=np.float32)
    # The message's definition asks for NaN for figures that are not measured.
    unknown = dict.fromkeys(("temperature", "charge", "capacity", "design_capacity"), math.nan)
    return ros.new(
        "sensor_msgs/BatteryState",
        header=header,
        voltage=voltage_v,
        current=-current_a,  # negative while it discharges
        percentage=remaining,
        **unknown,
        power_supply_status=_DISCHARGING,
        power_supply_health=0,
        power_supply_technology=0,
        present=True,
        cell_voltage=nothing,
        cell_temperature=nothing,
        location="",
        serial_number="",
    )
