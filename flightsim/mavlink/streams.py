"""Stream rates of each partner: the messages that it gets unrequested, and how often."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Literal

import numpy as np

from flightsim.mavlink.dialect import LAYOUTS
from flightsim.mavlink.dialect import dialect as mav
from flightsim.mavlink.streaming import PARTNER_DTYPE, TICK_US

Profile = Literal["normal", "onboard"]
"""Default stream rates: for a ground station or for a companion computer."""

LONGEST_US = 0x7FFFFFFF
"""Longest interval of a stream, 36 minutes: the greatest value that MESSAGE_INTERVAL holds."""

_NEVER = -1

# Rates in Hz of PX4's modes of the same names (mavlink_main.cpp, v1.15), capped at the tick; ground
# stations get the local position more often, because scripts on 14550 steer by it.
_RATES_HZ: Mapping[str, tuple[float, float]] = {
    "HEARTBEAT": (1, 1),
    "SYS_STATUS": (1, 5),
    "EXTENDED_SYS_STATE": (1, 5),
    "CURRENT_MODE": (0.5, 0.5),
    "CURRENT_EVENT_SEQUENCE": (0.2, 0.2),
    "HOME_POSITION": (0.5, 0.5),
    "BATTERY_STATUS": (0.5, 0.5),
    "SYSTEM_TIME": (1, 1),
    "MISSION_CURRENT": (1, 1),
    "ESTIMATOR_STATUS": (0.5, 1),
    "EKF_STATUS_REPORT": (1, 1),
    "VIBRATION": (0.1, 0.5),
    "GPS_RAW_INT": (1, 5),
    "ATTITUDE": (15, 50),
    "ATTITUDE_QUATERNION": (5, 50),
    "ATTITUDE_TARGET": (2, 10),
    "LOCAL_POSITION_NED": (10, 30),
    "GLOBAL_POSITION_INT": (5, 50),
    "POSITION_TARGET_LOCAL_NED": (1.5, 10),
    "POSITION_TARGET_GLOBAL_INT": (1, 10),
    "VFR_HUD": (4, 10),
    "ALTITUDE": (1, 10),
    "HIGHRES_IMU": (2, 50),
    "ODOMETRY": (0, 30),
    "SERVO_OUTPUT_RAW": (1, 10),
    "DISTANCE_SENSOR": (0.5, 10),
    "OPTICAL_FLOW_RAD": (1, 10),
    "NAV_CONTROLLER_OUTPUT": (1, 10),
    "SCALED_PRESSURE": (1, 1),
    "RANGEFINDER": (1, 1),
    "RAW_IMU": (2, 2),
    "RC_CHANNELS": (2, 2),
    "ESC_STATUS": (1, 1),
    "ESC_INFO": (0.5, 0.5),
    "WIND_COV": (0.5, 0.5),
    "ADSB_VEHICLE": (2, 2),
    "MOUNT_STATUS": (2, 2),
    "GIMBAL_MANAGER_STATUS": (1, 1),
    "GIMBAL_DEVICE_ATTITUDE_STATUS": (10, 10),
}

# The groups of REQUEST_DATA_STREAM as ground stations use them.
_GROUPS: Mapping[int, Sequence[str]] = {
    mav.MAV_DATA_STREAM_RAW_SENSORS: ("HIGHRES_IMU", "RAW_IMU", "SCALED_PRESSURE"),
    mav.MAV_DATA_STREAM_EXTENDED_STATUS: (
        "SYS_STATUS",
        "GPS_RAW_INT",
        "MISSION_CURRENT",
        "NAV_CONTROLLER_OUTPUT",
    ),
    mav.MAV_DATA_STREAM_RC_CHANNELS: ("SERVO_OUTPUT_RAW", "RC_CHANNELS"),
    mav.MAV_DATA_STREAM_POSITION: ("GLOBAL_POSITION_INT", "LOCAL_POSITION_NED"),
    mav.MAV_DATA_STREAM_EXTRA1: ("ATTITUDE",),
    mav.MAV_DATA_STREAM_EXTRA2: ("VFR_HUD",),
    mav.MAV_DATA_STREAM_EXTRA3: (
        *("BATTERY_STATUS", "SYSTEM_TIME", "DISTANCE_SENSOR"),
        *("EKF_STATUS_REPORT", "RANGEFINDER", "MOUNT_STATUS"),
    ),
}


class StreamTable:
    """Streams of one partner, in arrays that the kernel of `flightsim.mavlink.streaming` reads.

    Attributes:
        ids: Ids of the messages, in order.
        partner: `PARTNER_DTYPE` (1,), whose calendar this is.
        is_due: For each message, 1 if it is due in this tick (n,), bytes.
    """

    def __init__(self, profile: Profile, supported: Sequence[int], now_us: int = 0) -> None:
        """Start with default rates.

        Args:
            profile: Ground station or companion.
            supported: Ids of the messages that can be streamed.
            now_us: Simulated time.
        """
        column = 0 if profile == "normal" else 1
        self.ids = tuple(supported)
        self._index = {message_id: index for index, message_id in enumerate(supported)}
        self._defaults_us = {
            message_id: round(1e6 / rates[column]) if rates[column] else _NEVER
            for name, rates in _RATES_HZ.items()
            if (message_id := LAYOUTS[name].message_id) in self._index
        }
        self._interval_us = np.full(len(supported), _NEVER, np.int64)
        self._next_us = np.zeros(len(supported), np.int64)
        self.is_due = np.zeros(len(supported), np.uint8)
        self.partner = np.zeros(1, PARTNER_DTYPE)
        self.partner["now_us"] = now_us
        # The kernel reads these arrays by address: they live as long as this table.
        self.partner["next_address"] = self._next_us.ctypes.data
        self.partner["interval_address"] = self._interval_us.ctypes.data
        self.partner["due_address"] = self.is_due.ctypes.data
        for message_id, interval_us in self._defaults_us.items():
            self.set_interval(message_id, interval_us)

    def interval_us(self, message_id: int) -> int:
        """Return the present interval in us; -1 if the message is not streamed."""
        index = self._index.get(message_id)
        return _NEVER if index is None else int(self._interval_us[index])

    def set_interval(self, message_id: int, interval_us: float) -> bool:
        """Set an interval of a stream.

        An interval beyond `TICK_US` and `LONGEST_US` becomes the nearer of the two.

        Args:
            message_id: The message.
            interval_us: The interval; 0 is the default rate, -1 stops the stream.

        Returns:
            False if this message is never streamed.
        """
        index = self._index.get(message_id)
        if index is None:
            return False
        if interval_us == 0:
            interval_us = self._defaults_us.get(message_id, _NEVER)
        is_on = interval_us >= 0
        self._interval_us[index] = (
            round(max(TICK_US, min(LONGEST_US, interval_us))) if is_on else _NEVER
        )
        # Due at the next tick, so that a client sees at once that its request acts.
        self._next_us[index] = self.partner["now_us"][0] + TICK_US
        self.is_due[index] = 0
        return True

    def set_group(self, group: int, rate_hz: float, *, is_on: bool) -> bool:
        """Handle REQUEST_DATA_STREAM: one rate for a group of messages, except heartbeats.

        Args:
            group: MAV_DATA_STREAM.
            rate_hz: Rate of each message of the group.
            is_on: False stops them.

        Returns:
            False if there is no such group.
        """
        if group == mav.MAV_DATA_STREAM_ALL:
            names: Sequence[str] = [name for group in _GROUPS.values() for name in group]
        elif group in _GROUPS:
            names = _GROUPS[group]
        else:
            return False
        interval_us = 1e6 / rate_hz if is_on and rate_hz > 0 else _NEVER
        for name in names:
            self.set_interval(LAYOUTS[name].message_id, interval_us)
        return True
