"""Hostile but legal traffic: single frames, commands, and conversations with a second act.

A fault may need two messages: one that leaves a value behind, and one that is answered with it, or
an answer that comes by itself later. So half of the traffic is conversations.
"""

from __future__ import annotations

import random
import struct
from collections.abc import Callable, Iterator, Sequence

from flightsim.mavlink.dialect import MESSAGE_NAMES
from flightsim.mavlink.dialect import dialect as mav
from fuzzing.values import FLOATS, TYPES, chance, frame, pick

COMMANDS = sorted({*mav.enums["MAV_CMD"], 0, 32000, 65535})
OBEYED_COMMANDS = frozenset(
    {
        mav.MAV_CMD_NAV_LOITER_UNLIM,
        mav.MAV_CMD_NAV_RETURN_TO_LAUNCH,
        mav.MAV_CMD_NAV_LAND,
        mav.MAV_CMD_NAV_TAKEOFF,
        mav.MAV_CMD_NAV_GUIDED_ENABLE,
        mav.MAV_CMD_CONDITION_YAW,
        mav.MAV_CMD_DO_ORBIT,
        mav.MAV_CMD_DO_SET_MODE,
        mav.MAV_CMD_DO_CHANGE_SPEED,
        mav.MAV_CMD_DO_FLIGHTTERMINATION,
        mav.MAV_CMD_DO_CHANGE_ALTITUDE,
        mav.MAV_CMD_DO_REPOSITION,
        mav.MAV_CMD_DO_PAUSE_CONTINUE,
        mav.MAV_CMD_DO_SET_STANDARD_MODE,
        mav.MAV_CMD_MISSION_START,
        mav.MAV_CMD_COMPONENT_ARM_DISARM,
    }
)
"""Commands that move a vehicle or end its flight."""
OBEYED_MESSAGES = frozenset(
    {
        "SET_MODE",
        "SET_POSITION_TARGET_LOCAL_NED",
        "SET_POSITION_TARGET_GLOBAL_INT",
        "SET_ATTITUDE_TARGET",
        "MANUAL_CONTROL",
        "RC_CHANNELS_OVERRIDE",
        "PARAM_SET",
    }
)
"""Messages that do so, or that change the parameters by which the vehicle flies."""
_ADDRESSED = sorted(
    name for name, kind in TYPES.items() if any(f.name.startswith("target") for f in kind.fields)
)
_MESSAGES = sorted(TYPES)
_IDS = sorted(MESSAGE_NAMES)
_PARAMETERS = (
    *(b"MPC_XY_CRUISE", b"SYS_AUTOSTART", b"MIS_TAKEOFF_ALT", b"SYS_FAILURE_EN"),
    *(b"RTL_ALT", b"FENCE_ACTION", b"SYSID_THISMAV", b"_HASH_CHECK", b"\xff" * 16),
)
_ITEMS = {0: (16, 20, 21, 22, 19, 93), 1: (5000, 5001, 5003), 2: (5100,), 255: (16,)}
"""Commands of the items of each type of mission: flight, fence, rally points, all."""
_ITEM_MESSAGES = ("MISSION_ITEM_INT", "MISSION_ITEM")
_ASKED_FIRST = 12
"""Number of items of a mission that are sent or asked for in one conversation."""

# 90 is the data of one message of a log, 239 of one message of the file protocol.
_OFFSETS = (0, 0, 90, 239, 100_000, 2**31, 2**32 - 1)
_PATHS = (b"/", b"/log", b"/log/0.ulg", b"log/3.ulg", b"/log/../../etc/passwd", b"\xff" * 40, b"")
_LINES = (
    *(b"help\n", b"ver all\n", b"param show *\n", b"commander status\n", b"\n", b"\xff" * 70),
    *(b"listener vehicle_attitude\n", b"listener", b"param show " + b"*?" * 29, b" " * 70),
    *(b"param set MPC_XY_CRUISE 1e30\n", b"commander land\n", b"commander mode orbit\n"),
)
# The last three of `_LINES` move a vehicle.
_N_HARMLESS = 10
_PAUSES, _PAUSE_FRAMES = 5e-6, 24_000
"""Share of draws at which everybody falls silent, and the frames that four clients send in 6 s."""

Act = Callable[[random.Random], Sequence[bytes]]


class Traffic:
    """Endless traffic of one seed, the same in every process.

    Args:
        seed: Seed.
        is_obeyed: True for traffic that may move the vehicle; without it nothing in it should.
    """

    def __init__(self, seed: int, *, is_obeyed: bool) -> None:
        self._rng = random.Random(seed)
        self._is_obeyed = is_obeyed
        self._acts: Sequence[Act] = (self._any_message, self._addressed, self._command)
        self._conversations: Sequence[Act] = (
            self._interval,
            self._request,
            self._streams,
            self._upload,
            self._download,
            self._parameters,
            self._home,
            self._fleeting,
            self._log,
            self._file,
            self._shell,
        )

    def frames(self) -> Iterator[bytes]:
        """Draw frames without end; an empty one is silence, in which what was begun times out."""
        rng = self._rng
        while True:
            if chance(rng, _PAUSES):
                yield from (b"",) * _PAUSE_FRAMES
            acts = self._acts if chance(rng, 0.7) else self._conversations
            yield from pick(rng, acts)(rng)

    def _message(self, rng: random.Random, names: Sequence[str]) -> Sequence[bytes]:
        name = pick(rng, names)
        if name in {"COMMAND_LONG", "COMMAND_INT"}:
            return self._command(rng)
        if name in OBEYED_MESSAGES and not self._is_obeyed:
            return ()
        if name in _ITEM_MESSAGES:
            return (frame(rng, name, current=self._current(rng)),)
        return (frame(rng, name),)

    def _current(self, rng: random.Random) -> int:
        """Draw an item's field `current`: from 2 on, ArduPilot's vehicles fly to it at once."""
        return rng.randrange(4 if self._is_obeyed else 2)

    def _any_message(self, rng: random.Random) -> Sequence[bytes]:
        return self._message(rng, _MESSAGES)

    def _addressed(self, rng: random.Random) -> Sequence[bytes]:
        return self._message(rng, _ADDRESSED)

    def _command(self, rng: random.Random) -> Sequence[bytes]:
        number = pick(rng, COMMANDS)
        if number in OBEYED_COMMANDS and not self._is_obeyed:
            return ()
        return (_command(rng, number),)

    def _interval(self, rng: random.Random) -> Sequence[bytes]:
        """Set the interval of a message, then ask for it."""
        message_id = float(pick(rng, _IDS))
        return (
            _command(rng, mav.MAV_CMD_SET_MESSAGE_INTERVAL, param1=message_id),
            _command(rng, mav.MAV_CMD_GET_MESSAGE_INTERVAL, param1=message_id),
        )

    def _request(self, rng: random.Random) -> Sequence[bytes]:
        message_id = float(pick(rng, _IDS))
        return (_command(rng, mav.MAV_CMD_REQUEST_MESSAGE, param1=message_id),)

    def _streams(self, rng: random.Random) -> Sequence[bytes]:
        group = pick(rng, (0, 1, 2, 3, 6, 10, 11, 12, 255))
        asked = frame(rng, "REQUEST_DATA_STREAM", req_stream_id=group, start_stop=rng.randrange(3))
        return (asked, *self._interval(rng))

    def _upload(self, rng: random.Random) -> Sequence[bytes]:
        """Begin a list, send some of its items, in order or not, and leave or read it."""
        kind = pick(rng, (0, 1, 2, 255))
        count = pick(rng, (0, 1, 2, 5, 65535))
        begin = frame(rng, "MISSION_COUNT", count=count, mission_type=kind)
        if chance(rng, 0.2):
            begin = frame(rng, "MISSION_WRITE_PARTIAL_LIST", start_index=0, mission_type=kind)
        item = pick(rng, _ITEM_MESSAGES)
        items = [
            frame(
                rng,
                item,
                seq=seq,
                mission_type=kind,
                command=_item_command(rng, kind),
                current=self._current(rng),
            )
            for seq in range(min(count, _ASKED_FIRST))
        ]
        return (begin, *items, *self._download(rng))

    def _download(self, rng: random.Random) -> Sequence[bytes]:
        kind = pick(rng, (0, 1, 2, 255))
        ask = pick(rng, ("MISSION_REQUEST_INT", "MISSION_REQUEST"))
        items = [frame(rng, ask, seq=seq, mission_type=kind) for seq in range(3)]
        return (frame(rng, "MISSION_REQUEST_LIST", mission_type=kind), *items)

    def _parameters(self, rng: random.Random) -> Sequence[bytes]:
        name, ask = pick(rng, _PARAMETERS), frame(rng, "PARAM_REQUEST_LIST")
        read = frame(rng, "PARAM_REQUEST_READ", param_id=name, param_index=-1)
        if not self._is_obeyed:
            return (read, ask) if chance(rng, 0.1) else (read,)
        return (frame(rng, "PARAM_SET", param_id=name), read)

    def _home(self, rng: random.Random) -> Sequence[bytes]:
        """Move the vehicle's home, then ask for it in both ways."""
        return (
            _command(rng, mav.MAV_CMD_DO_SET_HOME, param1=float(rng.randrange(2))),
            _command(rng, mav.MAV_CMD_GET_HOME_POSITION),
            # 242 is HOME_POSITION.
            _command(rng, mav.MAV_CMD_REQUEST_MESSAGE, param1=242.0),
        )

    def _fleeting(self, rng: random.Random) -> Sequence[bytes]:
        """Requests that are answered at once, with the values that they held."""
        name = pick(rng, ("PING", "TIMESYNC", "FILE_TRANSFER_PROTOCOL", "LOG_REQUEST_DATA"))
        return (frame(rng, name), frame(rng, "FILE_TRANSFER_PROTOCOL", target_network=0))

    def _log(self, rng: random.Random) -> Sequence[bytes]:
        """List logs, read one from anywhere, and perhaps erase them while they are read."""
        log_id = rng.randrange(3)
        read = frame(rng, "LOG_REQUEST_DATA", id=log_id, ofs=pick(rng, _OFFSETS))
        after = pick(rng, ("LOG_ERASE", "LOG_REQUEST_END", "LOG_REQUEST_LIST"))
        return (frame(rng, "LOG_REQUEST_LIST", start=0), read, frame(rng, after))

    def _file(self, rng: random.Random) -> Sequence[bytes]:
        """Open a file or a folder, and read it at once or in a burst, from anywhere."""
        path, offset = pick(rng, _PATHS), pick(rng, _OFFSETS)
        # Opcodes: 3 lists a folder, 4 opens for reading, 14 sums up; 5 reads, 15 reads in a burst;
        # any follows.
        asked = [
            (pick(rng, (3, 4, 14)), path),
            (pick(rng, (5, 15)), b""),
            (rng.randrange(17), path),
        ]
        return [
            frame(
                rng,
                "FILE_TRANSFER_PROTOCOL",
                target_network=0,
                payload=[*_file_request(rng, opcode, data, offset).ljust(251, b"\0")[:251]],
            )
            for opcode, data in asked
        ]

    def _shell(self, rng: random.Random) -> Sequence[bytes]:
        line = pick(rng, _LINES if self._is_obeyed else _LINES[:_N_HARMLESS])
        data = [*line.ljust(70, b"\0")[:70]]
        # Device 10 is the shell; the flags ask for an answer, and with 4 for the line alone.
        said = frame(
            rng, "SERIAL_CONTROL", device=10, flags=pick(rng, (2, 6)), count=len(line), data=data
        )
        return (said,)


def _file_request(rng: random.Random, opcode: int, data: bytes, offset: int) -> bytes:
    size = len(data) if chance(rng, 0.8) else rng.randrange(256)
    # Sequence, session, opcode, size, opcode answered, end of a burst, padding, offset.
    head = struct.pack(
        "<HBBBBBxI", rng.randrange(1 << 16), pick(rng, (0, 0, 1)), opcode, size, 0, 0, offset
    )
    return head + data


def _command(rng: random.Random, number: int, **given: float) -> bytes:
    name = pick(rng, ("COMMAND_LONG", "COMMAND_INT"))
    for index in range(1, 5):
        if chance(rng, 0.3):
            # The first eight are ordinary numbers, with which a command may get far.
            given.setdefault(f"param{index}", pick(rng, FLOATS[:8]))
    if name == "COMMAND_INT":
        given.setdefault("frame", pick(rng, (0, 1, 3, 5, 6, 8, 10, 11, 12, 255)))
    return frame(rng, name, command=number, **given)


def _item_command(rng: random.Random, kind: int) -> int:
    if chance(rng, 0.2):
        return pick(rng, COMMANDS)
    return pick(rng, _ITEMS[kind])
