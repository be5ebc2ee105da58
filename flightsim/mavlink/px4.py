"""PX4's identity, from its px4_custom_mode.h and its answers on the wire (v1.15)."""

from __future__ import annotations

import hashlib

from flightsim.autopilot.modes import Mode
from flightsim.mavlink.personality import ModeEntry, Personality

# custom_mode = sub << 24 | main << 16
_MANUAL, _ALTCTL, _POSCTL, _AUTO, _ACRO, _OFFBOARD, _STABILIZED = (n << 16 for n in range(1, 8))
_TAKEOFF, _LOITER, _MISSION, _RTL, _LAND = (_AUTO | n << 24 for n in range(2, 7))
_POSCTL_ORBIT = _POSCTL | 1 << 24

# MAV_MODE_FLAG: custom 1, auto 4, guided 8, stabilize 16, manual input 64. pymavlink infers from
# them whether a custom mode is one of sticks or automatic.
_STICKS = 1 | 64
_ASSISTED = 1 | 16 | 64
_AUTOMATIC = 1 | 4 | 8 | 16


def _mode(
    mode: Mode, custom_mode: int, base_mode: int, standard: int = 0, *, is_selectable: bool = True
) -> ModeEntry:
    return ModeEntry(
        mode=mode,
        custom_mode=custom_mode,
        base_mode=base_mode,
        standard_mode=standard,
        is_selectable=is_selectable,
    )


# Modes that clients cannot select are reported as the nearest one that every client knows.
PX4 = Personality(
    name="px4",
    autopilot=12,
    modes=(
        _mode(Mode.MANUAL, _MANUAL, _STICKS),
        _mode(Mode.STABILIZED, _STABILIZED, _ASSISTED),
        _mode(Mode.ACRO, _ACRO, _STICKS),
        _mode(Mode.ALTITUDE, _ALTCTL, _ASSISTED, 3),
        _mode(Mode.POSITION, _POSCTL, _ASSISTED | 8, 1),
        _mode(Mode.HOLD, _LOITER, _AUTOMATIC),
        _mode(Mode.MISSION, _MISSION, _AUTOMATIC, 6),
        _mode(Mode.RETURN, _RTL, _AUTOMATIC, 5),
        _mode(Mode.LAND, _LAND, _AUTOMATIC, 7),
        _mode(Mode.TAKEOFF, _TAKEOFF, _AUTOMATIC, 8),
        _mode(Mode.OFFBOARD, _OFFBOARD, _AUTOMATIC),
        _mode(Mode.ORBIT, _POSCTL_ORBIT, _ASSISTED | 8, 2, is_selectable=False),
        _mode(Mode.DESCEND, _LAND, _AUTOMATIC, is_selectable=False),
        _mode(Mode.TERMINATION, _MANUAL, _STICKS, is_selectable=False),
    ),
    mode_shift={"main": 16, "sub": 24},
    flight_sw_version=1 << 24 | 15 << 16 | 4 << 8 | 255,
    flight_custom_version=hashlib.sha256(b"AeroScene").digest()[:8],
    # MISSION_FLOAT, MISSION_INT, COMMAND_INT, PARAM_ENCODE_BYTEWISE, SET_ATTITUDE_TARGET,
    # SET_POSITION_TARGET_LOCAL_NED, _GLOBAL_INT, FLIGHT_TERMINATION, MAVLINK2, FENCE, RALLY
    capabilities=1 | 4 | 8 | 16 | 64 | 128 | 256 | 2048 | 8192 | 16384 | 32768,
)
