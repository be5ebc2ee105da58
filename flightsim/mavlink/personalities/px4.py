"""PX4's identity, from its px4_custom_mode.h and its answers on the wire (v1.15)."""

from __future__ import annotations

import hashlib

from flightsim.autopilot.modes import Mode
from flightsim.mavlink.dialect import dialect as mav
from flightsim.mavlink.personalities.personality import ModeEntry, Personality

# custom_mode = sub << 24 | main << 16
_MANUAL, _ALTCTL, _POSCTL, _AUTO, _ACRO, _OFFBOARD, _STABILIZED = (n << 16 for n in range(1, 8))
_TAKEOFF, _LOITER, _MISSION, _RTL, _LAND = (_AUTO | n << 24 for n in range(2, 7))
_FOLLOW, _PRECLAND = (_AUTO | n << 24 for n in (8, 9))
_POSCTL_ORBIT = _POSCTL | 1 << 24  # orbit is a sub-mode of position control

# pymavlink infers from these flags whether a custom mode is one of sticks or automatic.
_GUIDED = mav.MAV_MODE_FLAG_GUIDED_ENABLED
_STICKS = mav.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED | mav.MAV_MODE_FLAG_MANUAL_INPUT_ENABLED
_ASSISTED = _STICKS | mav.MAV_MODE_FLAG_STABILIZE_ENABLED
_AUTOMATIC = (
    mav.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED
    | mav.MAV_MODE_FLAG_AUTO_ENABLED
    | mav.MAV_MODE_FLAG_STABILIZE_ENABLED
    | _GUIDED
)


def _mode(
    mode: Mode,
    custom_mode: int,
    base_mode: int,
    standard: int = 0,
    *,
    also: Mode | None = None,
    is_selectable: bool = True,
) -> ModeEntry:
    return ModeEntry(
        mode=mode,
        custom_mode=custom_mode,
        base_mode=base_mode,
        standard_mode=standard,
        is_selectable=is_selectable,
        also=frozenset() if also is None else frozenset({also}),
    )


# Modes that clients cannot select are reported as the nearest one that every client knows.
PX4 = Personality(
    name="px4",
    autopilot=mav.MAV_AUTOPILOT_PX4,
    modes=(
        _mode(Mode.MANUAL, _MANUAL, _STICKS),
        _mode(Mode.STABILIZED, _STABILIZED, _ASSISTED),
        _mode(Mode.ACRO, _ACRO, _STICKS),
        _mode(Mode.ALTITUDE, _ALTCTL, _ASSISTED, mav.MAV_STANDARD_MODE_ALTITUDE_HOLD),
        _mode(Mode.POSITION, _POSCTL, _ASSISTED | _GUIDED, mav.MAV_STANDARD_MODE_POSITION_HOLD),
        _mode(Mode.HOLD, _LOITER, _AUTOMATIC),
        _mode(Mode.MISSION, _MISSION, _AUTOMATIC, mav.MAV_STANDARD_MODE_MISSION),
        _mode(Mode.RETURN, _RTL, _AUTOMATIC, mav.MAV_STANDARD_MODE_SAFE_RECOVERY),
        _mode(Mode.LAND, _LAND, _AUTOMATIC, mav.MAV_STANDARD_MODE_LAND, also=Mode.PRECISION_LAND),
        _mode(Mode.TAKEOFF, _TAKEOFF, _AUTOMATIC, mav.MAV_STANDARD_MODE_TAKEOFF),
        _mode(Mode.OFFBOARD, _OFFBOARD, _AUTOMATIC),
        _mode(Mode.FOLLOW, _FOLLOW, _AUTOMATIC),
        _mode(Mode.PRECISION_LAND, _PRECLAND, _AUTOMATIC),
        _mode(
            Mode.ORBIT,
            _POSCTL_ORBIT,
            _ASSISTED | _GUIDED,
            mav.MAV_STANDARD_MODE_ORBIT,
            is_selectable=False,
        ),
        _mode(Mode.DESCEND, _LAND, _AUTOMATIC, is_selectable=False),
        _mode(Mode.TERMINATION, _MANUAL, _STICKS, is_selectable=False),
    ),
    mode_shift={"main": 16, "sub": 24},
    flight_sw_version=1 << 24 | 15 << 16 | 4 << 8 | 255,  # 1.15.4, official release
    flight_custom_version=hashlib.sha256(b"AeroScene").digest()[:8],
    capabilities=(
        mav.MAV_PROTOCOL_CAPABILITY_MISSION_FLOAT
        | mav.MAV_PROTOCOL_CAPABILITY_MISSION_INT
        | mav.MAV_PROTOCOL_CAPABILITY_COMMAND_INT
        | mav.MAV_PROTOCOL_CAPABILITY_FTP
        | mav.MAV_PROTOCOL_CAPABILITY_PARAM_ENCODE_BYTEWISE
        | mav.MAV_PROTOCOL_CAPABILITY_SET_ATTITUDE_TARGET
        | mav.MAV_PROTOCOL_CAPABILITY_SET_POSITION_TARGET_LOCAL_NED
        | mav.MAV_PROTOCOL_CAPABILITY_SET_POSITION_TARGET_GLOBAL_INT
        | mav.MAV_PROTOCOL_CAPABILITY_FLIGHT_TERMINATION
        | mav.MAV_PROTOCOL_CAPABILITY_MAVLINK2
        | mav.MAV_PROTOCOL_CAPABILITY_MISSION_FENCE
        | mav.MAV_PROTOCOL_CAPABILITY_MISSION_RALLY
    ),
)
