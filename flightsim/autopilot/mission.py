"""Mission items as ground stations upload them, validated, with the place of progress.

The numbers of commands and frames are those of the common MAVLink mission protocol, which is the
language that missions are written in; nothing else of MAVLink is here.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from enum import Enum, IntEnum, unique

MAX_MISSION_ITEMS = 2000


class Cmd(IntEnum):
    """Mission commands that act, and those that are accepted and have nothing to act on."""

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
    FENCE_RETURN_POINT = 5000
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
    },
)
"""Items that fly somewhere."""

IGNORED_COMMANDS = frozenset(
    # servo, relay, region of interest, camera, gimbal, gripper, parachute off, video, trigger
    {181, 182, 183, 184, 195, 196, 197, 201, 202, 203, 204, 205, 206, 207, 211, 214, 530, 531, 532}
    | {1000, 1001, 2000, 2001, 2003, 2500, 2501},
)
"""Items for payloads that this vehicle does not carry: taken, and skipped in flight."""

_MISSION_COMMANDS = (
    PLACE_COMMANDS
    | {Cmd.RETURN, Cmd.DELAY, Cmd.CONDITION_DELAY, Cmd.CONDITION_DISTANCE, Cmd.CONDITION_YAW}
    | {Cmd.JUMP, Cmd.CHANGE_SPEED, Cmd.SET_HOME, Cmd.LAND_START}
    | IGNORED_COMMANDS
)

FRAME_GLOBAL = frozenset({0, 5})
"""Altitude above mean sea level."""
FRAME_RELATIVE = frozenset({3, 6})
"""Altitude above home."""
FRAME_TERRAIN = frozenset({10, 11})
"""Altitude above terrain, which is taken as that of home."""
FRAME_LOCAL_NED = 1
FRAME_MISSION = 2
FRAME_LOCAL_ENU = 4
_GEODETIC_FRAMES = FRAME_GLOBAL | FRAME_RELATIVE | FRAME_TERRAIN
_FRAMES = _GEODETIC_FRAMES | {FRAME_LOCAL_NED, FRAME_MISSION, FRAME_LOCAL_ENU}


@unique
class MissionFault(Enum):
    """What kind of thing is wrong with an item."""

    UNSUPPORTED_COMMAND = "unsupported command"
    UNSUPPORTED_FRAME = "unsupported frame"
    INVALID_PARAM = "invalid parameter"
    NO_SPACE = "too many items"
    INVALID_SEQUENCE = "invalid sequence"


class MissionError(ValueError):
    """Items were refused; the ones stored before remain.

    Attributes:
        fault: What kind of thing is wrong.
        index: Index of the first bad item, or None if it is the whole list.
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
    """One item of a mission, fence or rally list, as it travels.

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
        """Whether `x` and `y` are degrees."""
        return self.frame in _GEODETIC_FRAMES

    @property
    def is_here(self) -> bool:
        """Whether the item names no horizontal place and means wherever the vehicle is."""
        return (
            math.isnan(self.x)
            or math.isnan(self.y)
            or (self.is_geodetic and self.x == 0.0 and self.y == 0.0)
        )


class MissionStore:
    """The uploaded mission and where the vehicle is in it."""

    def __init__(self) -> None:
        self.items: tuple[MissionItem, ...] = ()
        self.current_index = 0
        self.last_reached_index: int | None = None
        self.is_finished = False
        self.revision = 0
        """Grows with every change of the items."""
        self.n_selections = 0
        """Grows with every choice of an item by a client."""

    def __len__(self) -> int:
        return len(self.items)

    def replace(self, items: Iterable[MissionItem]) -> None:
        """Store a new mission.

        Raises:
            MissionError: If an item cannot be flown; the old mission remains.
        """
        candidate = tuple(items)
        validate_mission(candidate)
        self.items = candidate
        self.revision += 1
        self.rewind()

    def clear(self) -> None:
        """Forget the mission."""
        self.replace(())

    def rewind(self) -> None:
        """Start over at the first item."""
        self.select(0)
        self.last_reached_index = None

    def select(self, index: int) -> None:
        """Go to an item because somebody wants it; a mission in flight follows."""
        self.current_index = index
        self.is_finished = False
        self.n_selections += 1


def validate_mission(items: tuple[MissionItem, ...]) -> None:
    """Refuse a mission that cannot be flown.

    Raises:
        MissionError: Names the item, the parameter and what is valid.
    """
    if len(items) > MAX_MISSION_ITEMS:
        raise MissionError(
            MissionFault.NO_SPACE,
            f"{len(items)} mission items; at most {MAX_MISSION_ITEMS} fit",
            index=None,
        )
    for index, item in enumerate(items):
        if item.command not in _MISSION_COMMANDS:
            raise MissionError(
                MissionFault.UNSUPPORTED_COMMAND,
                f"item {index}: command {item.command} is not supported",
                index=index,
            )
        _check_frame(index, item)
        if item.command in PLACE_COMMANDS or item.command == Cmd.SET_HOME:
            _check_place(index, item)
        _check_parameters(index, item, len(items))


def check_horizontal_place(index: int, item: MissionItem) -> None:
    """Refuse an item whose x or y is no place.

    Raises:
        MissionError: If a coordinate is NaN, infinite or off the globe.
    """
    limits = (90.0, 180.0) if item.is_geodetic else (1e5, 1e5)
    for param, name, value, limit in zip((5, 6), "xy", (item.x, item.y), limits, strict=True):
        if not abs(value) <= limit:
            raise _invalid(index, param, f"{name} = {value}", f"{-limit:g} to {limit:g}")


def _check_frame(index: int, item: MissionItem) -> None:
    needs_place = item.command in PLACE_COMMANDS
    if item.frame not in _FRAMES or (needs_place and item.frame == FRAME_MISSION):
        raise MissionError(
            MissionFault.UNSUPPORTED_FRAME,
            f"item {index}: frame {item.frame} is not supported for command {item.command}; "
            f"valid are global (0, 3, 5, 6, 10, 11) and local (1, 4)",
            index=index,
        )


def _check_place(index: int, item: MissionItem) -> None:
    if item.command == Cmd.WAYPOINT or not item.is_here:
        check_horizontal_place(index, item)
    may_omit_altitude = item.command in {Cmd.LAND, Cmd.SET_HOME}
    if math.isnan(item.z) and may_omit_altitude:
        return
    if not abs(item.z) <= 1e5:
        raise _invalid(index, 7, f"z = {item.z}", "-100000 to 100000")


def _check_parameters(index: int, item: MissionItem, n_items: int) -> None:
    for param, value in enumerate((item.param1, item.param2, item.param3, item.param4), start=1):
        if math.isinf(value):
            raise _invalid(index, param, f"param{param} = {value}", "finite numbers and NaN")
    match item.command:
        case Cmd.JUMP if not (0 <= item.param1 < n_items and item.param1 == int(item.param1)):
            raise _invalid(index, 1, f"jump to {item.param1}", f"items 0 to {n_items - 1}")
        case Cmd.CHANGE_SPEED if math.isnan(item.param2):
            raise _invalid(index, 2, "speed = nan", "speeds in m/s, negative for the default")
        case Cmd.DELAY | Cmd.CONDITION_DELAY | Cmd.LOITER_TIME if not item.param1 <= 86400.0:
            raise _invalid(index, 1, f"time = {item.param1}", "0 to 86400 s")
        case Cmd.LOITER_TURNS if not 0.0 <= item.param1 <= 1000.0:
            raise _invalid(index, 1, f"turns = {item.param1}", "0 to 1000")
        case Cmd.CONDITION_YAW if math.isnan(item.param1):
            raise _invalid(index, 1, "yaw = nan", "degrees clockwise from north")


def _invalid(index: int, param: int, what: str, valid: str) -> MissionError:
    return MissionError(
        MissionFault.INVALID_PARAM,
        f"item {index}: {what} is invalid; valid are {valid}",
        index=index,
        param=param,
    )
