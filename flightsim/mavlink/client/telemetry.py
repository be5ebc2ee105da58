"""Latest vehicle state that a companion received over MAVLink, in ENU and FLU."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from autonomy.types import NAN3, Quaternion, Vector3, yaw_of
from flightsim.frames import (
    Geodetic,
    LocalFrame,
    swap_enu_ned,
    swap_flu_frd,
    swap_quat_enu_flu_ned_frd,
)
from flightsim.mavlink.client.habits import PX4_HABITS, Habits
from flightsim.mavlink.dialect import dialect as mavlink

_NAVIGATING_BITS = (
    mavlink.ESTIMATOR_ATTITUDE
    | mavlink.ESTIMATOR_VELOCITY_HORIZ
    | mavlink.ESTIMATOR_VELOCITY_VERT
    | mavlink.ESTIMATOR_POS_HORIZ_ABS
    | mavlink.ESTIMATOR_POS_VERT_ABS
)
LANDED_ON_GROUND = mavlink.MAV_LANDED_STATE_ON_GROUND
_AUTOPILOT_COMPONENT = 1
_MAX_TEXTS = 200


@dataclass(kw_only=True, slots=True)
class Telemetry:
    """Last reported state of the vehicle; NaN or 0 for values that were not received."""

    system_id: int = 0
    """System id of the autopilot, 0 before its first heartbeat."""
    is_armed: bool = False
    custom_mode: int = 0
    is_armable: bool = False
    is_navigating: bool = False
    """True if the estimator reports valid attitude, velocity and absolute position."""
    is_dead_reckoning: bool = False
    """True if the estimator reports that nothing external measures its position."""
    has_fix: bool = False
    """True if the receiver reports a position in three dimensions."""
    horizontal_sigma_m: float = math.nan
    """Standard deviation that the estimator reports for the horizontal position."""
    landed_state: int = 0
    """Value of MAV_LANDED_STATE."""
    local_origin_enu_m: Vector3 | None = None
    """Origin of MAVLink's local frame in the scene's, None until it is known."""
    position_time_ms: int = 0
    position_enu_m: Vector3 = NAN3
    """Position in the scene's frame."""
    velocity_enu_mps: Vector3 = NAN3
    quat_wxyz: Quaternion = (math.nan, math.nan, math.nan, math.nan)
    angular_rate_flu_radps: Vector3 = NAN3
    range_m: float = math.nan
    wind_mps: float = math.nan
    """Horizontal speed of the wind that the autopilot estimates."""
    home: Geodetic | None = None
    battery_remaining: float = math.nan
    texts: list[tuple[int, str]] = field(default_factory=list)
    """Severity and text of each STATUSTEXT, the latest last."""

    @property
    def yaw_rad(self) -> float:
        """Heading of the body's x axis, rad counter-clockwise from east."""
        return yaw_of(self.quat_wxyz)

    @property
    def has_state(self) -> bool:
        """True if position and attitude are known."""
        return not (math.isnan(self.position_enu_m[0]) or math.isnan(self.quat_wxyz[0]))


class TelemetryReader:
    """Updates a `Telemetry` from messages."""

    def __init__(self, frame: LocalFrame, habits: Habits = PX4_HABITS) -> None:
        """Start with an empty state.

        Args:
            frame: Local frame of the scene, in which positions are reported.
            habits: Numbers and customs of the flight stack.
        """
        self._frame, self._habits = frame, habits
        self.telemetry = Telemetry()
        self._text_id = 0
        self._readers: dict[str, Callable[[Any], None]] = {
            "HEARTBEAT": self._heartbeat,
            "SYS_STATUS": self._sys_status,
            "ESTIMATOR_STATUS": self._estimator_status,
            "EXTENDED_SYS_STATE": self._extended_sys_state,
            "GPS_RAW_INT": self._receiver,
            "GPS_GLOBAL_ORIGIN": self._origin,
            "LOCAL_POSITION_NED": self._local_position,
            "ATTITUDE_QUATERNION": self._attitude,
            "DISTANCE_SENSOR": self._distance,
            "HOME_POSITION": self._home,
            "WIND_COV": self._wind,
            "STATUSTEXT": self._text,
        }

    def is_of_vehicle(self, message: Any) -> bool:
        """Return true if the autopilot sent a message, and not another client by way of it."""
        known = self.telemetry.system_id
        return message.get_srcComponent() == _AUTOPILOT_COMPONENT and (
            not known or known == message.get_srcSystem()
        )

    def read(self, message: Any) -> None:
        """Process a message of the vehicle; unknown types are ignored."""
        reader = self._readers.get(message.get_type())
        if reader is not None:
            reader(message)

    def _heartbeat(self, m: Any) -> None:
        self.telemetry.system_id = m.get_srcSystem()
        self.telemetry.is_armed = bool(m.base_mode & mavlink.MAV_MODE_FLAG_SAFETY_ARMED)
        self.telemetry.custom_mode = m.custom_mode

    def _sys_status(self, m: Any) -> None:
        self.telemetry.is_armable = bool(
            m.onboard_control_sensors_health & mavlink.MAV_SYS_STATUS_PREARM_CHECK
        )
        # -1 means unknown.
        if m.battery_remaining >= 0:
            self.telemetry.battery_remaining = m.battery_remaining / 100.0

    def _estimator_status(self, m: Any) -> None:
        self.telemetry.is_navigating = m.flags & _NAVIGATING_BITS == _NAVIGATING_BITS
        self.telemetry.is_dead_reckoning = bool(m.flags & mavlink.ESTIMATOR_CONST_POS_MODE)
        self.telemetry.horizontal_sigma_m = m.pos_horiz_accuracy

    def _receiver(self, m: Any) -> None:
        self.telemetry.has_fix = m.fix_type >= mavlink.GPS_FIX_TYPE_3D_FIX
        if not self._habits.has_estimator_status:
            self.telemetry.horizontal_sigma_m = m.h_acc * 1e-3

    def _extended_sys_state(self, m: Any) -> None:
        self.telemetry.landed_state = m.landed_state

    def _origin(self, m: Any) -> None:
        place = Geodetic(m.latitude * 1e-7, m.longitude * 1e-7, m.altitude * 1e-3)
        self.telemetry.local_origin_enu_m = self._frame.enu_from_geodetic(place)

    def _local_position(self, m: Any) -> None:
        self.telemetry.position_time_ms = m.time_boot_ms
        # Without the origin the position cannot be placed in the scene.
        origin = self.telemetry.local_origin_enu_m
        if origin is None:
            return
        east, north, up = swap_enu_ned((m.x, m.y, m.z))
        self.telemetry.position_enu_m = (east + origin[0], north + origin[1], up + origin[2])
        self.telemetry.velocity_enu_mps = swap_enu_ned((m.vx, m.vy, m.vz))
        # A stack without ESTIMATOR_STATUS sends its position only while it knows it.
        if not self._habits.has_estimator_status:
            self.telemetry.is_navigating = True

    def _attitude(self, m: Any) -> None:
        self.telemetry.quat_wxyz = swap_quat_enu_flu_ned_frd((m.q1, m.q2, m.q3, m.q4))
        rates = (m.rollspeed, m.pitchspeed, m.yawspeed)
        self.telemetry.angular_rate_flu_radps = swap_flu_frd(rates)

    def _distance(self, m: Any) -> None:
        # A distance outside the sensor's range means that it has met nothing.
        is_measured = m.min_distance <= m.current_distance <= m.max_distance
        self.telemetry.range_m = m.current_distance / 100.0 if is_measured else math.inf

    def _wind(self, m: Any) -> None:
        self.telemetry.wind_mps = math.hypot(m.wind_x, m.wind_y)

    def _home(self, m: Any) -> None:
        self.telemetry.home = Geodetic(m.latitude * 1e-7, m.longitude * 1e-7, m.altitude * 1e-3)

    def _text(self, m: Any) -> None:
        texts, text = self.telemetry.texts, m.text.rstrip("\0")
        is_continued = bool(m.id) and m.chunk_seq > 0 and m.id == self._text_id and bool(texts)
        self._text_id = m.id
        if is_continued:  # a text of more than 50 bytes comes in pieces
            _, before = texts.pop()
            text = before + text
        texts.append((m.severity, text))
        del texts[:-_MAX_TEXTS]
