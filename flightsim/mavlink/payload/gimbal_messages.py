"""Messages of the gimbal: control, capabilities, and direction."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from flightsim.mavlink.dialect import dialect as mav
from flightsim.mavlink.dialect import layout
from flightsim.mavlink.view import VehicleView
from flightsim.payload.gimbal import Gimbal

_MANAGER_INFORMATION = layout("GIMBAL_MANAGER_INFORMATION")
_MANAGER_STATUS = layout("GIMBAL_MANAGER_STATUS")
_DEVICE_INFORMATION = layout("GIMBAL_DEVICE_INFORMATION")
_ATTITUDE_STATUS = layout("GIMBAL_DEVICE_ATTITUDE_STATUS")

DEVICE_ID = 1
"""Number of a gimbal that shares its component with its manager."""
_CAPABILITIES = (
    mav.GIMBAL_MANAGER_CAP_FLAGS_HAS_NEUTRAL
    | mav.GIMBAL_MANAGER_CAP_FLAGS_HAS_ROLL_LOCK
    | mav.GIMBAL_MANAGER_CAP_FLAGS_HAS_PITCH_AXIS
    | mav.GIMBAL_MANAGER_CAP_FLAGS_HAS_PITCH_LOCK
    | mav.GIMBAL_MANAGER_CAP_FLAGS_HAS_YAW_AXIS
    | mav.GIMBAL_MANAGER_CAP_FLAGS_HAS_YAW_FOLLOW
    | mav.GIMBAL_MANAGER_CAP_FLAGS_HAS_YAW_LOCK
    | mav.GIMBAL_MANAGER_CAP_FLAGS_SUPPORTS_INFINITE_YAW
    | mav.GIMBAL_MANAGER_CAP_FLAGS_SUPPORTS_YAW_IN_EARTH_FRAME
    | mav.GIMBAL_MANAGER_CAP_FLAGS_CAN_POINT_LOCATION_GLOBAL
)
_DEVICE_CAPABILITIES = _CAPABILITIES & 0xFFFF  # the device's flags are the manager's lowest 16
_LEVEL_FLAGS = mav.GIMBAL_DEVICE_FLAGS_ROLL_LOCK | mav.GIMBAL_DEVICE_FLAGS_PITCH_LOCK
_LOCKED_FLAGS = mav.GIMBAL_DEVICE_FLAGS_YAW_LOCK | mav.GIMBAL_DEVICE_FLAGS_YAW_IN_EARTH_FRAME

Address = tuple[int, int]
"""System and component id; zeros for nobody."""
NOBODY: Address = (0, 0)


@dataclass(slots=True)
class Control:
    """The clients that control the gimbal."""

    primary: Address = NOBODY
    secondary: Address = NOBODY

    def allows(self, sender: Address) -> bool:
        """Return true if a sender may turn the gimbal: anybody while nobody is in control."""
        return self.primary == NOBODY or sender in {self.primary, self.secondary}


class GimbalMessages:
    """Packs the gimbal's messages."""

    def __init__(self, view: VehicleView, gimbal: Gimbal, control: Control) -> None:
        self._view = view
        self._gimbal = gimbal
        self._control = control
        self.producers: Mapping[str, Callable[[], bytes | None]] = {
            "GIMBAL_MANAGER_INFORMATION": self._manager_information,
            "GIMBAL_MANAGER_STATUS": self.status,
            "GIMBAL_DEVICE_INFORMATION": self._device_information,
            "GIMBAL_DEVICE_ATTITUDE_STATUS": self._attitude,
        }

    def status(self) -> bytes:
        """Return GIMBAL_MANAGER_STATUS with the clients in control."""
        control = self._control
        return _MANAGER_STATUS.encode(
            time_boot_ms=self._view.time_boot_ms,
            flags=self._flags,
            gimbal_device_id=DEVICE_ID,
            primary_control_sysid=control.primary[0],
            primary_control_compid=control.primary[1],
            secondary_control_sysid=control.secondary[0],
            secondary_control_compid=control.secondary[1],
        )

    @property
    def _flags(self) -> int:
        if self._gimbal.is_yaw_locked:
            return _LEVEL_FLAGS | _LOCKED_FLAGS
        return _LEVEL_FLAGS | mav.GIMBAL_DEVICE_FLAGS_YAW_IN_VEHICLE_FRAME

    @property
    def _limits(self) -> Mapping[str, float]:
        cfg = self._gimbal.cfg
        return {
            "pitch_min": -cfg.lowest_pitch_down_rad,
            "pitch_max": -cfg.highest_pitch_down_rad,
            "yaw_min": -math.pi,
            "yaw_max": math.pi,
        }

    def _manager_information(self) -> bytes:
        return _MANAGER_INFORMATION.encode(
            time_boot_ms=self._view.time_boot_ms,
            cap_flags=_CAPABILITIES,
            gimbal_device_id=DEVICE_ID,
            **self._limits,
        )

    def _device_information(self) -> bytes:
        return _DEVICE_INFORMATION.encode(
            time_boot_ms=self._view.time_boot_ms,
            vendor_name=b"AeroScene",
            model_name=b"Two axes",
            firmware_version=1,
            hardware_version=1,
            cap_flags=_DEVICE_CAPABILITIES,
            gimbal_device_id=DEVICE_ID,
            **self._limits,
        )

    def _attitude(self) -> bytes:
        gimbal, heading_rad = self._gimbal, self._view.rpy_rad[2]
        # Pitch counts up and yaw clockwise here, from the nose or, where locked, from north.
        from_zero_rad = -gimbal.yaw_rad + (heading_rad if gimbal.is_yaw_locked else 0.0)
        half_yaw, half_pitch = 0.5 * from_zero_rad, -0.5 * gimbal.pitch_down_rad
        cy, sy = math.cos(half_yaw), math.sin(half_yaw)
        cp, sp = math.cos(half_pitch), math.sin(half_pitch)
        return _ATTITUDE_STATUS.encode(
            time_boot_ms=self._view.time_boot_ms,
            flags=self._flags,
            # Quaternion of a turn about z (yaw) and then about y (pitch).
            q=(cy * cp, -sy * sp, cy * sp, sy * cp),
            angular_velocity_x=0.0,
            angular_velocity_y=-gimbal.pitch_down_rate_radps,
            angular_velocity_z=-gimbal.yaw_rate_radps,
            delta_yaw=heading_rad,
            delta_yaw_velocity=self._view.rates_frd_radps[2],
            gimbal_device_id=DEVICE_ID,
        )
