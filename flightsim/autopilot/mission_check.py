"""Checks that refuse missions that cannot be flown, before they are stored.

A refusal at upload names the item and the valid values while a person still looks at the plan. An
item without effect would otherwise only be noticed in flight.
"""

from __future__ import annotations

import math

from flightsim.autopilot.mission_item import (
    FRAME_LOCAL_ENU,
    FRAME_LOCAL_NED,
    GEODETIC_FRAMES,
    PAYLOAD_COMMANDS,
    PLACE_COMMANDS,
    UNAVAILABLE_COMMANDS,
    Cmd,
    MissionError,
    MissionFault,
    MissionItem,
)

MAX_MISSION_ITEMS = 2000  # bounds the memory and the time that a client can use

_COMMANDS = (
    PLACE_COMMANDS
    | {Cmd.RETURN, Cmd.DELAY, Cmd.CONDITION_DELAY, Cmd.CONDITION_DISTANCE, Cmd.CONDITION_YAW}
    | {Cmd.JUMP, Cmd.CHANGE_SPEED, Cmd.SET_HOME, Cmd.LAND_START, Cmd.FENCE_ENABLE}
    | PAYLOAD_COMMANDS
)
_PLACE_FRAMES = GEODETIC_FRAMES | {FRAME_LOCAL_NED, FRAME_LOCAL_ENU}


def check_mission(items: tuple[MissionItem, ...]) -> None:
    """Refuse a mission that cannot be flown.

    Args:
        items: All items in their order.

    Raises:
        MissionError: Names the item, the parameter and the valid values.
    """
    if len(items) > MAX_MISSION_ITEMS:
        text = f"{len(items)} mission items; at most {MAX_MISSION_ITEMS} fit"
        raise MissionError(MissionFault.NO_SPACE, text, index=None)
    for index, item in enumerate(items):
        if item.command not in _COMMANDS:
            raise unsupported_command(index, item)
        # param1 = 1 sets home to the vehicle's own place; the item's is not read then.
        if item.command in PLACE_COMMANDS or (item.command == Cmd.SET_HOME and item.param1 != 1.0):
            _check_place(index, item)
        _check_parameters(index, item, len(items))


def unsupported_command(index: int, item: MissionItem, valid: str = "") -> MissionError:
    """Return the refusal of an item whose command changes nothing here.

    Args:
        index: Index of the item.
        item: The item.
        valid: Commands that are valid in its list, if these are few.
    """
    reason = UNAVAILABLE_COMMANDS.get(item.command, "is not supported")
    link = " " if reason.startswith("is ") else ", "
    text = f"item {index}: command {item.command}{link}{reason}" + (
        valid and f"; valid are {valid}"
    )
    return MissionError(MissionFault.UNSUPPORTED_COMMAND, text, index=index)


def check_horizontal_place(index: int, item: MissionItem) -> None:
    """Refuse an item whose x or y is not a valid coordinate.

    Args:
        index: Index of the item, for the message.
        item: The item; its frame decides between degrees and metres.

    Raises:
        MissionError: If a coordinate is NaN, infinite or off the globe.
    """
    # 100 km: the local frame is a tangent plane and means little beyond.
    limits = (90.0, 180.0) if item.is_geodetic else (1e5, 1e5)
    for param, name, value, limit in zip((5, 6), "xy", (item.x, item.y), limits, strict=True):
        # Negated, so that NaN is refused too.
        if not abs(value) <= limit:
            raise _invalid(index, param, f"{name} = {value}", f"{-limit:g} to {limit:g}")


def _check_place(index: int, item: MissionItem) -> None:
    if item.frame not in _PLACE_FRAMES:
        raise MissionError(
            MissionFault.UNSUPPORTED_FRAME,
            f"item {index}: frame {item.frame} is not supported for command {item.command}; "
            f"valid are global (0, 3, 5, 6, 10, 11) and local (1, 4)",
            index=index,
        )
    if item.command in {Cmd.WAYPOINT, Cmd.SET_HOME} or not item.is_here:
        check_horizontal_place(index, item)
    # A landing needs no altitude: it descends until the ground carries the vehicle.
    if math.isnan(item.z) and item.command == Cmd.LAND:
        return
    if not abs(item.z) <= 1e5:
        raise _invalid(index, 7, f"z = {item.z}", "-100000 to 100000")


def _check_parameters(index: int, item: MissionItem, n_items: int) -> None:
    # NaN means "not given" and is valid in most parameters, infinity in none.
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
        case Cmd.FENCE_ENABLE if item.param1 not in {0.0, 1.0}:
            raise _invalid(index, 1, f"fence = {item.param1:g}", "0 (off) and 1 (on)")


def _invalid(index: int, param: int, what: str, valid: str) -> MissionError:
    text = f"item {index}: {what} is invalid; valid are {valid}"
    return MissionError(MissionFault.INVALID_PARAM, text, index=index, param=param)
