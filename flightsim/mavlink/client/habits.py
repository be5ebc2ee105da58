"""Numbers and customs in which flight stacks differ, as a companion must know them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

from flightsim.mavlink.dialect import dialect as mavlink

# PX4's custom modes: sub << 24 | main << 16.
PX4_OFFBOARD = 6 << 16
PX4_LAND = 6 << 24 | 4 << 16
PX4_RETURN = 5 << 24 | 4 << 16
PX4_HOLD = 3 << 24 | 4 << 16
# ArduCopter numbers its modes from 0.
# ArduCopter's, which it counts.
_GUIDED, _LOITER, _RTL, _LAND = 4, 5, 6, 9

_STATE_HZ = {
    mavlink.MAVLINK_MSG_ID_LOCAL_POSITION_NED: 50,
    mavlink.MAVLINK_MSG_ID_ATTITUDE_QUATERNION: 50,
    mavlink.MAVLINK_MSG_ID_EXTENDED_SYS_STATE: 10,
    mavlink.MAVLINK_MSG_ID_HEARTBEAT: 5,
    mavlink.MAVLINK_MSG_ID_DISTANCE_SENSOR: 10,
}


@dataclass(frozen=True, kw_only=True, slots=True)
class Habits:
    """Numbers and customs of a flight stack."""

    offboard: int
    """Custom mode in which the vehicle follows a companion's setpoints."""
    return_home: int
    """Custom mode in which it returns by itself."""
    land_here: int
    """Custom mode in which it lands where it is."""
    hold: int
    """Custom mode in which it stays where it is."""
    streams_hz: Mapping[int, float]
    """Messages that a companion steers by, and how often it wants them."""
    unwanted: tuple[int, ...] = ()
    """Messages that it stops, because the stack sends them unasked."""
    unused: float = math.nan
    """Value of parameters of commands that are not used. MAVLink says NaN, at which the real
    ArduPilot stops in simulation."""
    mode_shifts: tuple[int, int] = (16, 24)
    """Bits by which DO_SET_MODE's two numbers are shifted into the custom mode."""
    has_estimator_status: bool = True
    """True if it sends ESTIMATOR_STATUS. Another stack sends its position only while it knows it,
    and the accuracy of its receiver stands for the accuracy of its estimate."""
    report_delay_s: float = 0.0
    """Longest time from the acknowledgement of a mode or of arming to the heartbeat that has it."""
    takes_off_by_itself: bool = False
    """True if it follows setpoints only once it has taken off by command."""
    land: int | None = None
    """Custom mode for the last stretch, if the stack detects the landing in this mode only; it
    disarms."""


PX4_HABITS = Habits(
    offboard=PX4_OFFBOARD,
    return_home=PX4_RETURN,
    land_here=PX4_LAND,
    hold=PX4_HOLD,
    streams_hz={
        **_STATE_HZ,
        mavlink.MAVLINK_MSG_ID_ESTIMATOR_STATUS: 5,
        mavlink.MAVLINK_MSG_ID_WIND_COV: 5,
    },
    unwanted=(
        mavlink.MAVLINK_MSG_ID_ATTITUDE,
        mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT,
        mavlink.MAVLINK_MSG_ID_HIGHRES_IMU,
        mavlink.MAVLINK_MSG_ID_ODOMETRY,
        mavlink.MAVLINK_MSG_ID_VFR_HUD,
        mavlink.MAVLINK_MSG_ID_ALTITUDE,
        mavlink.MAVLINK_MSG_ID_ATTITUDE_TARGET,
        mavlink.MAVLINK_MSG_ID_POSITION_TARGET_LOCAL_NED,
        mavlink.MAVLINK_MSG_ID_POSITION_TARGET_GLOBAL_INT,
        mavlink.MAVLINK_MSG_ID_SERVO_OUTPUT_RAW,
        mavlink.MAVLINK_MSG_ID_NAV_CONTROLLER_OUTPUT,
    ),
)
"""Habits of PX4, as our own autopilot has them."""

REAL_PX4_HABITS = replace(
    PX4_HABITS,
    streams_hz={
        **PX4_HABITS.streams_hz,
        mavlink.MAVLINK_MSG_ID_SYS_STATUS: 2,
        mavlink.MAVLINK_MSG_ID_HOME_POSITION: 1,
    },
    unwanted=(),
    report_delay_s=1.5,
    land=PX4_LAND,
)
"""Habits of the real PX4. Its heartbeats come once a second whatever is asked for, and its link for
us sends nothing else unasked."""

ARDUPILOT_HABITS = Habits(
    offboard=_GUIDED,
    return_home=_RTL,
    land_here=_LAND,
    hold=_LOITER,
    streams_hz={
        **_STATE_HZ,
        mavlink.MAVLINK_MSG_ID_SYS_STATUS: 2,
        mavlink.MAVLINK_MSG_ID_GPS_RAW_INT: 2,
    },
    unused=0.0,
    mode_shifts=(0, 8),
    has_estimator_status=False,
    report_delay_s=1.5,
    takes_off_by_itself=True,
    land=_LAND,
)
"""Habits of ArduCopter."""
