"""What the autopilot can be doing, free of any protocol's numbers."""

from __future__ import annotations

from enum import Enum, IntEnum, unique


@unique
class Mode(Enum):
    """Flight modes, named as pilots know them; the value is the text shown to people."""

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
    OFFBOARD = "Offboard"
    ORBIT = "Orbit"
    DESCEND = "Descend"
    """Blind descent of a failsafe, when no position is known; never chosen by a client."""
    TERMINATION = "Termination"
    """Rotors stopped for good; left only by disarming."""


STICK_MODES = frozenset(
    {Mode.MANUAL, Mode.STABILIZED, Mode.ACRO, Mode.ALTITUDE, Mode.POSITION},
)
"""Modes in which a pilot's sticks steer."""

THRUST_MODES = frozenset({Mode.MANUAL, Mode.STABILIZED, Mode.ACRO})
"""Modes in which the throttle is thrust, so that they cannot do without sticks."""

POSITION_MODES = frozenset(
    {
        Mode.POSITION,
        Mode.HOLD,
        Mode.TAKEOFF,
        Mode.MISSION,
        Mode.RETURN,
        Mode.LAND,
        Mode.ORBIT,
    },
)
"""Modes that need a valid position estimate."""


@unique
class LandedState(Enum):
    """Where the vehicle is between ground and air."""

    ON_GROUND = "on ground"
    TAKEOFF = "takeoff"
    IN_AIR = "in air"
    LANDING = "landing"


@unique
class SystemState(Enum):
    """How the vehicle is, as a heartbeat reports it."""

    STANDBY = "standby"
    ACTIVE = "active"
    CRITICAL = "critical"
    EMERGENCY = "emergency"


@unique
class FailsafeReason(Enum):
    """Why the autopilot took over; the value is the text shown to people."""

    OFFBOARD_LOST = "offboard setpoints lost"
    DATALINK_LOST = "ground station lost"
    MANUAL_CONTROL_LOST = "manual control lost"
    POSITION_LOST = "position estimate lost"
    GEOFENCE = "geofence breached"
    CRASHED = "vehicle toppled"
    BATTERY_LOW = "battery low"
    BATTERY_CRITICAL = "battery critical"
    BATTERY_EMERGENCY = "battery at emergency level"


@unique
class BatteryWarning(IntEnum):
    """How worrying the battery is; ordered."""

    NONE = 0
    LOW = 1
    CRITICAL = 2
    EMERGENCY = 3
