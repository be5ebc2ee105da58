"""Modes and states of the autopilot, independent of any protocol's numbers."""

from __future__ import annotations

from enum import Enum, IntEnum, unique


@unique
class Mode(Enum):
    """Flight modes; the value is the text shown to people."""

    MANUAL = "Manual"
    STABILIZED = "Stabilized"
    ACRO = "Acro"
    ALTITUDE = "Altitude"
    POSITION = "Position"
    HOLD = "Hold"
    TAKEOFF = "Takeoff"
    MISSION = "Mission"
    RETURN = "Return"
    LAND = "Land"
    PRECISION_LAND = "Precision land"
    OFFBOARD = "Offboard"
    ORBIT = "Orbit"
    FOLLOW = "Follow"
    DESCEND = "Descend"
    """Blind descent of a failsafe without a position; clients cannot choose it."""
    TERMINATION = "Termination"
    """Rotors stopped for the rest of the flight; only disarming leaves this mode."""


STICK_MODES = frozenset({Mode.MANUAL, Mode.STABILIZED, Mode.ACRO, Mode.ALTITUDE, Mode.POSITION})
"""Modes steered by a pilot's sticks."""

THRUST_MODES = frozenset({Mode.MANUAL, Mode.STABILIZED, Mode.ACRO})
"""Modes in which the throttle is thrust. Without sticks nobody would hold the height."""

POSITION_MODES = frozenset(
    {
        *(Mode.POSITION, Mode.HOLD, Mode.TAKEOFF, Mode.MISSION, Mode.RETURN, Mode.LAND),
        *(Mode.ORBIT, Mode.FOLLOW, Mode.PRECISION_LAND),
    }
)
"""Modes that need a valid position estimate."""


@unique
class LandedState(Enum):
    """Phase of the vehicle between ground and air."""

    ON_GROUND = "on ground"
    TAKEOFF = "takeoff"
    IN_AIR = "in air"
    LANDING = "landing"


@unique
class SystemState(Enum):
    """State of the vehicle, as a heartbeat reports it."""

    STANDBY = "standby"
    ACTIVE = "active"
    CRITICAL = "critical"
    EMERGENCY = "emergency"


@unique
class FailsafeReason(Enum):
    """Reason for a failsafe; the value is the text shown to people."""

    OFFBOARD_LOST = "offboard setpoints lost"
    DATALINK_LOST = "ground station lost"
    MANUAL_CONTROL_LOST = "manual control lost"
    POSITION_LOST = "position estimate lost"
    GEOFENCE = "geofence breached"
    CRASHED = "vehicle toppled"
    IMU_LOST = "inertial sensor lost"
    MOTOR_LOST = "motor lost"
    WIND = "wind too strong"
    BATTERY_LOW = "battery low"
    BATTERY_CRITICAL = "battery critical"
    BATTERY_EMERGENCY = "battery at emergency level"


@unique
class BatteryWarning(IntEnum):
    """Severity of the battery's state; a greater number is worse."""

    NONE = 0
    LOW = 1
    CRITICAL = 2
    EMERGENCY = 3
