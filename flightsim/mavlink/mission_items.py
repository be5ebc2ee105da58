"""Conversion of mission items between MAVLink messages and the autopilot's stores."""

from __future__ import annotations

import math
from collections.abc import Iterable

from flightsim.autopilot.mission_item import (
    GEODETIC_FRAMES,
    MissionError,
    MissionFault,
    MissionItem,
)
from flightsim.mavlink.dialect import LAYOUTS
from flightsim.mavlink.dialect import dialect as mav
from flightsim.mavlink.parsing import Message

# By name, so that local frames that the dialect gains are recognised.
_LOCAL_FRAMES = frozenset(
    number
    for number, entry in mav.enums["MAV_FRAME"].items()
    if "_LOCAL_" in entry.name or "_BODY_" in entry.name
)
_NOT_GIVEN = 0x7FFFFFFF
_INT32_MIN = -0x80000000

_RESULT_OF_FAULT = {
    MissionFault.UNSUPPORTED_COMMAND: mav.MAV_MISSION_UNSUPPORTED,
    MissionFault.UNSUPPORTED_FRAME: mav.MAV_MISSION_UNSUPPORTED_FRAME,
    MissionFault.NO_SPACE: mav.MAV_MISSION_NO_SPACE,
    MissionFault.INVALID_SEQUENCE: mav.MAV_MISSION_INVALID_SEQUENCE,
}


def result_of(error: MissionError) -> int:
    """Return the MAV_MISSION_RESULT for an error of the autopilot.

    Args:
        error: Error, whose parameter, if it has one, decides on the result.
    """
    if error.fault is MissionFault.INVALID_PARAM:
        if error.param is None:
            return mav.MAV_MISSION_INVALID
        return mav.MAV_MISSION_INVALID_PARAM1 + error.param - 1
    return _RESULT_OF_FAULT[error.fault]


def scale_of(frame: int) -> float:
    """Return the factor from degrees or metres to the integers of a message.

    Args:
        frame: MAV_FRAME of the item.

    Returns:
        1e7 for degrees, 1e4 for metres of a local frame, 1 for numbers without a place.
    """
    if frame in GEODETIC_FRAMES:
        return 1e7
    return 1e4 if frame in _LOCAL_FRAMES else 1.0


def coordinate_from_int(value: int, frame: int) -> float:
    """Return degrees or metres of an x or y in an integer message; NaN for "not given".

    Args:
        value: The integer.
        frame: Its MAV_FRAME.
    """
    return math.nan if value == _NOT_GIVEN else value / scale_of(frame)


def _int_from_coordinate(value: float, frame: int) -> int:
    if not math.isfinite(value):
        return _NOT_GIVEN
    return max(_INT32_MIN, min(_NOT_GIVEN, round(value * scale_of(frame))))


def check_frames(items: Iterable[MissionItem]) -> None:
    """Refuse items in local frames, as PX4 does: stored missions outlive a local origin.

    Args:
        items: All items.

    Raises:
        MissionError: Names the first such item.
    """
    for index, item in enumerate(items):
        if item.frame in _LOCAL_FRAMES:
            text = f"item {index}: frame {item.frame} is local; valid are global frames and 2"
            raise MissionError(MissionFault.UNSUPPORTED_FRAME, text, index=index)


def item_from_message(message: Message) -> MissionItem:
    """Return the item that a message carries.

    Args:
        message: A MISSION_ITEM_INT, or the older MISSION_ITEM, whose coordinates are floats.
    """
    is_int = message.get_type() == "MISSION_ITEM_INT"
    frame = message.frame
    return MissionItem(
        frame=frame,
        command=message.command,
        param1=message.param1,
        param2=message.param2,
        param3=message.param3,
        param4=message.param4,
        x=coordinate_from_int(message.x, frame) if is_int else message.x,
        y=coordinate_from_int(message.y, frame) if is_int else message.y,
        z=message.z,
        is_autocontinue=bool(message.autocontinue),
    )


def payload_of_item(
    item: MissionItem,
    sequence: int,
    *,
    is_int: bool,
    is_current: bool,
    target: tuple[int, int],
    mission_type: int,
) -> bytes:
    """Return the payload of MISSION_ITEM_INT or MISSION_ITEM for an item.

    Args:
        item: The item.
        sequence: Its number on the wire.
        is_int: True for MISSION_ITEM_INT, which keeps degrees to a centimetre.
        is_current: True if the mission is at this item.
        target: System and component id of the receiver.
        mission_type: MAV_MISSION_TYPE of its list.
    """
    message = LAYOUTS["MISSION_ITEM_INT" if is_int else "MISSION_ITEM"]
    return message.encode(
        target_system=target[0],
        target_component=target[1],
        seq=sequence,
        frame=item.frame,
        command=item.command,
        current=int(is_current),
        autocontinue=int(item.is_autocontinue),
        param1=item.param1,
        param2=item.param2,
        param3=item.param3,
        param4=item.param4,
        x=_int_from_coordinate(item.x, item.frame) if is_int else item.x,
        y=_int_from_coordinate(item.y, item.frame) if is_int else item.y,
        z=item.z,
        mission_type=mission_type,
    )
