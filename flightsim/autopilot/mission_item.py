"""Mission items as ground stations write them, and the error for bad ones.

Commands and frames have the numbers of the common MAVLink mission protocol, the language
in which missions are written; nothing else of MAVLink is used here.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum, IntEnum, unique


class Cmd(IntEnum):
    """Mission commands that act by the autopilot; the values are those of MAV_CMD."""

    WAYPOINT = 16
    LOITER_UNLIMITED = 17
    LOITER_TURNS = 18
    LOITER_TIME = 19
    RETURN = 20
    LAND = 21
    TAKEOFF = 22
    LOITER_TO_ALTITUDE = 31
    DELAY = 93
    CONDITION_DELAY = 112
    CONDITION_DISTANCE = 114
    CONDITION_YAW = 115
    JUMP = 177
    CHANGE_SPEED = 178
    SET_HOME = 179
    LAND_START = 189
    """Start of a landing sequence: the command DO_LAND_START continues the mission there."""
    FENCE_ENABLE = 207
    FENCE_POLYGON_INCLUSION = 5001
    FENCE_POLYGON_EXCLUSION = 5002
    FENCE_CIRCLE_INCLUSION = 5003
    FENCE_CIRCLE_EXCLUSION = 5004
    RALLY_POINT = 5100


PLACE_COMMANDS = frozenset(
    {
        Cmd.WAYPOINT,
        Cmd.LOITER_UNLIMITED,
        Cmd.LOITER_TURNS,
        Cmd.LOITER_TIME,
        Cmd.LOITER_TO_ALTITUDE,
        Cmd.LAND,
        Cmd.TAKEOFF,
    }
)
"""Items that fly to a place, or do something at one."""

PAYLOAD_COMMANDS = frozenset(
    # regions of interest, camera, mount, trigger; gimbal, photographs, films
    {195, 196, 197, 201, 203, 204, 205, 206, 214, 530, 1000, 1001, 2000, 2001, 2003, 2500, 2501}
)
"""Items for the gimbal and its camera. The mission queues a `PayloadOrder`, on which these act."""

UNAVAILABLE_COMMANDS = {
    181: "DO_SET_RELAY: there is no relay",
    182: "DO_REPEAT_RELAY: there is no relay",
    183: "DO_SET_SERVO: there is no servo",
    184: "DO_REPEAT_SERVO: there is no servo",
    202: "DO_DIGICAM_CONFIGURE: the camera sets itself",
    208: "DO_PARACHUTE: there is no parachute",
    211: "DO_GRIPPER: there is no gripper",
    212: "DO_AUTOTUNE_ENABLE: there is nothing to tune",
    215: "DO_SET_RESUME_REPEAT_DIST: missions continue where they stopped",
    216: "DO_SPRAYER: there is no sprayer",
    222: "DO_GUIDED_LIMITS: guided flight in missions is not known",
    531: "SET_CAMERA_ZOOM: the zoom is fixed",
    532: "SET_CAMERA_FOCUS: the focus is fixed",
    5000: "NAV_FENCE_RETURN_POINT: a breach leads home or to a rally point",
}
"""Commands of public missions that would change nothing here, with the reason."""

FRAME_GLOBAL = frozenset({0, 5})
"""Frames with altitude above mean sea level."""
FRAME_RELATIVE = frozenset({3, 6})
"""Frames with altitude above home."""
FRAME_TERRAIN = frozenset({10, 11})
"""Frames with altitude above terrain: the scene's relief, or the height of home without one."""
FRAME_LOCAL_NED = 1
FRAME_LOCAL_ENU = 4
GEODETIC_FRAMES = FRAME_GLOBAL | FRAME_RELATIVE | FRAME_TERRAIN


@unique
class MissionFault(Enum):
    """Category of an error in an item, which MAVLink maps to a MAV_MISSION_RESULT."""

    UNSUPPORTED_COMMAND = "unsupported command"
    UNSUPPORTED_FRAME = "unsupported frame"
    INVALID_PARAM = "invalid parameter"
    NO_SPACE = "too many items"
    INVALID_SEQUENCE = "invalid sequence"


class MissionError(ValueError):
    """Uploaded items are refused; the stored ones remain.

    Attributes:
        fault: Category of the error.
        index: Index of the first bad item, or None if the whole list is bad.
        param: 1 to 7, the bad parameter of that item (5, 6, 7 are x, y, z), or None.
    """

    def __init__(
        self, fault: MissionFault, message: str, *, index: int | None, param: int | None = None
    ) -> None:
        super().__init__(message)
        self.fault = fault
        self.index = index
        self.param = param


@dataclass(frozen=True, kw_only=True, slots=True)
class MissionItem:
    """One item of a mission, fence or rally list, as transferred.

    `x`, `y` are latitude and longitude in degrees in global frames, else metres of the local
    frame that `frame` names. NaN in a parameter means "not given".
    """

    frame: int
    command: int
    param1: float = math.nan
    param2: float = math.nan
    param3: float = math.nan
    param4: float = math.nan
    x: float = 0.0
    y: float = 0.0
    z: float = 0.0
    is_autocontinue: bool = True

    @property
    def is_geodetic(self) -> bool:
        """True if `x` and `y` are degrees."""
        return self.frame in GEODETIC_FRAMES

    @property
    def is_here(self) -> bool:
        """True if the item names no horizontal place and so means the vehicle's.

        In global frames (0, 0) counts as none, because clients without NaN send it.
        """
        return (
            math.isnan(self.x)
            or math.isnan(self.y)
            or (self.is_geodetic and self.x == 0.0 and self.y == 0.0)
        )
