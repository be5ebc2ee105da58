"""A client outside the lockstep: it arms a flight stack, has a mission flown, and brings it home.

Plain pymavlink over the port that the stack offers its clients. Prints one JSON object of what it
has seen, or of the `fault` where the stack does not do what it is told; then its status is 1.

    python tools/waypoints/client.py px4 udpin:127.0.0.1:14540 < mission.json
"""

from __future__ import annotations

import contextlib
import json
import math
import statistics
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from pymavlink import mavutil
from pymavlink.dialects.v20 import common as mavlink

_PATIENCE_S = 30.0
"""Wall time within which an answer must come, or another try at arming succeed."""
_ACK_S, _TRIES = 3.0, 10
"""Wall time after which a command is repeated: at many times real time UDP loses some messages."""
# A stack gives no sign that it hovers, so that the speed has to show it.
_SLOW_MPS, _SETTLED_S = 0.3, 5.0
"""Speed below which the vehicle hovers, and the time until its throttle is steady."""
_TAKEOFF_M = 5.0  # height at which ArduCopter's take-off ends
_RELATIVE = mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT_INT
_STREAMS_HZ = {
    mavlink.MAVLINK_MSG_ID_ATTITUDE_TARGET: 10,
    mavlink.MAVLINK_MSG_ID_LOCAL_POSITION_NED: 10,
}

Message = Any
Waypoint = tuple[float, float, float]
"""Latitude and longitude in degrees, metres above home."""
Item = tuple[int, tuple[float, float, float, float], Waypoint]
"""Command, four parameters, place."""


@dataclass(frozen=True, kw_only=True)
class Customs:
    """Ways in which PX4 and ArduCopter want the same thing said."""

    before_arming: tuple[float, ...]
    """Mode to arm in: the last parameters of MAV_CMD_DO_SET_MODE; empty keeps the stack's own."""
    mission_mode: tuple[float, ...]
    takeoff_m: float
    """Height given at take-off; for not-a-number PX4 takes its own, MIS_TAKEOFF_ALT."""
    unused: float
    """Value of a take-off's parameter that is left open.

    ArduCopter's simulation ends by one that is not a number.
    """
    first_item: int
    """Number of the first item of a mission; ArduCopter's number 0 is home."""


# PX4's mode (4, 4) is automatic flight of a mission; ArduCopter's 4 is guided, 3 automatic.
CUSTOMS = {
    "px4": Customs(
        before_arming=(), mission_mode=(4, 4), takeoff_m=math.nan, unused=math.nan, first_item=0
    ),
    "ardupilot": Customs(
        before_arming=(4,), mission_mode=(3,), takeoff_m=_TAKEOFF_M, unused=0.0, first_item=1
    ),
}


class StackError(RuntimeError):
    """The flight stack refused something, did not answer, or was too slow."""


class Client:
    """A ground station that commands one flight stack, and keeps its throttle in hover."""

    def __init__(self, name: str, address: str) -> None:
        """Connect, and ask for what is measured.

        Args:
            name: "px4" or "ardupilot".
            address: Address in the words of pymavlink.

        Raises:
            StackError: If no heartbeat comes.
        """
        self._customs = CUSTOMS[name]
        # Another system than a usual ground station, so that a real one may listen too.
        self._link = mavutil.mavlink_connection(address, source_system=254, retries=60)
        if self._link.wait_heartbeat(timeout=2 * _PATIENCE_S) is None:
            raise StackError(f"no heartbeat at {address}")
        self._beat_due_s = 0.0
        self._slow_since_ms: int | None = None
        self._height_m = 0.0
        self.hover_throttles: list[float] = []
        for message_id, hz in _STREAMS_HZ.items():
            self._command(mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, message_id, 1e6 / hz)

    def fly(self, waypoints: Sequence[Waypoint], laps: int, hover_s: float) -> int:
        """Fly a mission some times over, hover at its end, return and land.

        Args:
            waypoints: Places to fly to.
            laps: Number of times that all of them are flown.
            hover_s: Time of steady hover.

        Returns:
            Number of waypoints that the stack has reported to have reached.

        Raises:
            StackError: If the stack refuses something, or stays silent.
        """
        customs, first = self._customs, self._customs.first_item
        plain = (0.0, 0.0, 0.0, 0.0)
        items: list[Item] = [(mavlink.MAV_CMD_NAV_WAYPOINT, plain, place) for place in waypoints]
        if laps > 1:
            # Back to the first item, once less than there are laps.
            jump = (float(first), laps - 1.0, 0.0, 0.0)
            items.append((mavlink.MAV_CMD_DO_JUMP, jump, (0.0, 0.0, 0.0)))
        # ArduCopter takes item 0 for home, so that any item may stand there.
        self._upload([items[0]] * first + items)
        _say(f"has {len(items)} items of a mission")
        self._arm()
        _say("takes off")
        self._demand(mavlink.MAV_CMD_NAV_TAKEOFF, *(customs.unused,) * 6, customs.takeoff_m)
        self._wait("LOCAL_POSITION_NED", lambda _: self._height_m > 2.0)
        self._set_mode(customs.mission_mode)
        n_reached = self._follow(len(waypoints), laps)
        self._hover(hover_s)
        self._demand(mavlink.MAV_CMD_NAV_RETURN_TO_LAUNCH)
        armed = mavlink.MAV_MODE_FLAG_SAFETY_ARMED
        _say("returns")
        self._wait("HEARTBEAT", lambda m: _is_vehicle(m) and not m.base_mode & armed)
        return n_reached

    def _follow(self, n_waypoints: int, laps: int) -> int:
        """Wait for the end of the mission, and count the waypoints reported to be reached."""
        first, n_reached = self._customs.first_item, 0
        complete = mavlink.MISSION_STATE_COMPLETE
        while n_reached < laps * n_waypoints:
            told = self._wait(
                ["MISSION_ITEM_REACHED", "MISSION_CURRENT"],
                lambda m: m.get_type() == "MISSION_ITEM_REACHED" or m.mission_state == complete,
            )
            if told.get_type() == "MISSION_CURRENT":
                if n_reached > (laps - 1) * n_waypoints:
                    break  # The report of the last one was lost.
            elif first <= told.seq < first + n_waypoints:
                n_reached += 1
                _say(f"reached {n_reached} of {laps * n_waypoints}")
        return n_reached

    def _upload(self, items: Sequence[Item]) -> None:
        system, component = self._link.target_system, self._link.target_component
        self._link.mav.mission_count_send(system, component, len(items), 0)
        kinds = ["MISSION_REQUEST_INT", "MISSION_REQUEST", "MISSION_ACK"]
        while (asked := self._wait(kinds)).get_type() != "MISSION_ACK":
            command, params, (latitude_deg, longitude_deg, height_m) = items[asked.seq]
            place = round(latitude_deg * 1e7), round(longitude_deg * 1e7), height_m
            # PX4 takes a jump, which has no place, in no frame but this.
            is_jump = command == mavlink.MAV_CMD_DO_JUMP
            frame = mavlink.MAV_FRAME_MISSION if is_jump else _RELATIVE
            self._link.mav.mission_item_int_send(
                *(system, component, asked.seq, frame, command, 0, 1), *params, *place, 0
            )
        if asked.type != mavlink.MAV_MISSION_ACCEPTED:
            raise StackError(f"mission of {len(items)} items: refused with {asked.type}")

    def _arm(self) -> None:
        """Arm as soon as the stack accepts it: it is ready only when its estimator is."""
        deadline_s = time.monotonic() + 2 * _PATIENCE_S
        while True:
            self._set_mode(self._customs.before_arming)
            result = self._command(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1)
            if result == mavlink.MAV_RESULT_ACCEPTED:
                return
            if time.monotonic() > deadline_s:
                raise StackError(f"arming: refused with {result}")
            self._wait("HEARTBEAT")

    def _set_mode(self, numbers: tuple[float, ...]) -> None:
        if numbers:
            flag = mavlink.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED
            self._demand(mavlink.MAV_CMD_DO_SET_MODE, flag, *numbers)

    def _hover(self, seconds: float) -> None:
        """Wait for so much steady hover, and keep the throttle meanwhile."""
        self._slow_since_ms = None
        self.hover_throttles.clear()
        n_wanted = round(seconds * _STREAMS_HZ[mavlink.MAVLINK_MSG_ID_ATTITUDE_TARGET])
        while len(self.hover_throttles) < n_wanted:
            target = self._wait("ATTITUDE_TARGET")
            since_ms = self._slow_since_ms
            if since_ms is not None and target.time_boot_ms > since_ms + 1e3 * _SETTLED_S:
                self.hover_throttles.append(target.thrust)

    def _demand(self, number: int, *params: float) -> None:
        if (result := self._command(number, *params)) != mavlink.MAV_RESULT_ACCEPTED:
            raise StackError(f"command {number}: refused with {result}")

    def _command(self, number: int, *params: float) -> int:
        """Send a command, again if no answer comes.

        Returns:
            MAV_RESULT of the answer.
        """
        padded = (*params, *(0.0,) * (7 - len(params)))
        system, component = self._link.target_system, self._link.target_component
        for attempt in range(_TRIES):
            # The confirmation counts repetitions of a command.
            self._link.mav.command_long_send(system, component, number, attempt, *padded)
            with contextlib.suppress(StackError):
                acked = self._wait("COMMAND_ACK", lambda m: m.command == number, limit_s=_ACK_S)
                return acked.result
        raise StackError(f"command {number}: no answer to {_TRIES} tries")

    def _wait(
        self,
        kinds: str | list[str],
        is_it: Callable[[Message], bool] = lambda _: True,
        limit_s: float = math.inf,
    ) -> Message:
        """Wait for a message; every other one that comes in the meantime is looked at, too.

        Args:
            kinds: Names of messages, one of which is wanted.
            is_it: True for the wanted message among those of these names.
            limit_s: Longest wall time to wait.

        Raises:
            StackError: If the message does not come, or the stack falls silent.
        """
        wanted = [kinds] if isinstance(kinds, str) else kinds
        began_s = heard_s = time.monotonic()
        while time.monotonic() < min(heard_s + _PATIENCE_S, began_s + limit_s):
            # Without its heartbeats a ground station counts as lost.
            self._beat()
            message = self._link.recv_match(blocking=True, timeout=1.0)
            if message is None:
                continue
            kind = message.get_type()
            if kind == "LOCAL_POSITION_NED":
                self._look(message)
                # The stack lives, however slowly it flies here.
                heard_s = time.monotonic()
            if kind in wanted and is_it(message):
                return message
        raise StackError(f"{' or '.join(wanted)}: not what was waited for within {_PATIENCE_S:g} s")

    def _look(self, position: Message) -> None:
        self._height_m = -position.z
        speed_mps = (position.vx**2 + position.vy**2 + position.vz**2) ** 0.5
        if speed_mps > _SLOW_MPS:
            self._slow_since_ms = None
        elif self._slow_since_ms is None:
            self._slow_since_ms = position.time_boot_ms

    def _beat(self) -> None:
        if time.monotonic() >= self._beat_due_s:
            self._beat_due_s = time.monotonic() + 1.0
            self._link.mav.heartbeat_send(
                mavlink.MAV_TYPE_GCS, mavlink.MAV_AUTOPILOT_INVALID, 0, 0, 0
            )


def _is_vehicle(heartbeat: Message) -> bool:
    return heartbeat.autopilot != mavlink.MAV_AUTOPILOT_INVALID


def _say(line: str) -> None:
    print(line, file=sys.stderr, flush=True)


def main() -> int:
    """Fly the task that comes as JSON on standard input: waypoints, laps and hover_s.

    Returns:
        Exit status: 1 if the stack failed.
    """
    name, address = sys.argv[1:]
    task = json.load(sys.stdin)
    try:
        client = Client(name, address)
        n_reached = client.fly(task["waypoints"], task["laps"], task["hover_s"])
    except StackError as error:
        print(json.dumps({"fault": str(error)}))
        return 1
    told = {
        "waypoints_reported": n_reached,
        "hover_throttle": statistics.fmean(client.hover_throttles),
        "cpu_s": time.process_time(),
    }
    print(json.dumps(told))
    return 0


if __name__ == "__main__":
    sys.exit(main())
