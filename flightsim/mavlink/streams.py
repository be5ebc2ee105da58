"""Stream rates of each partner: which messages it gets unrequested, and how often."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from flightsim.mavlink.dialect import LAYOUTS
from flightsim.mavlink.dialect import dialect as mav

Profile = Literal["normal", "onboard"]
"""Default stream rates: for a ground station or for a companion computer."""

TICK_US = 20_000
"""Period of the server, and so the shortest interval of a stream."""

LONGEST_US = 0x7FFFFFFF
"""Longest interval of a stream, 36 minutes: the most that MESSAGE_INTERVAL can tell."""

# Rates in Hz of PX4's modes of the same names (mavlink_main.cpp, v1.15), capped at the tick; ground
# stations get the local position more often, because scripts on 14550 steer by it.
_RATES_HZ: Mapping[str, tuple[float, float]] = {
    "HEARTBEAT": (1, 1),
    "SYS_STATUS": (1, 5),
    "EXTENDED_SYS_STATE": (1, 5),
    "CURRENT_MODE": (0.5, 0.5),
    "CURRENT_EVENT_SEQUENCE": (0.2, 0.2),
    "HOME_POSITION": (0.5, 0.5),
    "BATTERY_STATUS": (0.5, 0.5),
    "SYSTEM_TIME": (1, 1),
    "MISSION_CURRENT": (1, 1),
    "ESTIMATOR_STATUS": (0.5, 1),
    "EKF_STATUS_REPORT": (1, 1),
    "VIBRATION": (0.1, 0.5),
    "GPS_RAW_INT": (1, 5),
    "ATTITUDE": (15, 50),
    "ATTITUDE_QUATERNION": (5, 50),
    "ATTITUDE_TARGET": (2, 10),
    "LOCAL_POSITION_NED": (10, 30),
    "GLOBAL_POSITION_INT": (5, 50),
    "POSITION_TARGET_LOCAL_NED": (1.5, 10),
    "POSITION_TARGET_GLOBAL_INT": (1, 10),
    "VFR_HUD": (4, 10),
    "ALTITUDE": (1, 10),
    "HIGHRES_IMU": (2, 50),
    "ODOMETRY": (0, 30),
    "SERVO_OUTPUT_RAW": (1, 10),
    "DISTANCE_SENSOR": (0.5, 10),
    "OPTICAL_FLOW_RAD": (1, 10),
    "NAV_CONTROLLER_OUTPUT": (1, 10),
    "SCALED_PRESSURE": (1, 1),
    "RANGEFINDER": (1, 1),
    "RC_CHANNELS": (2, 2),
    "ESC_STATUS": (1, 1),
    "ESC_INFO": (0.5, 0.5),
    "WIND_COV": (0.5, 0.5),
    "ADSB_VEHICLE": (2, 2),
    "GIMBAL_MANAGER_STATUS": (1, 1),
    "GIMBAL_DEVICE_ATTITUDE_STATUS": (10, 10),
}

# The groups of REQUEST_DATA_STREAM as ground stations use them.
_GROUPS: Mapping[int, Sequence[str]] = {
    mav.MAV_DATA_STREAM_RAW_SENSORS: ("HIGHRES_IMU", "SCALED_PRESSURE"),
    mav.MAV_DATA_STREAM_EXTENDED_STATUS: (
        "SYS_STATUS",
        "GPS_RAW_INT",
        "MISSION_CURRENT",
        "NAV_CONTROLLER_OUTPUT",
    ),
    mav.MAV_DATA_STREAM_RC_CHANNELS: ("SERVO_OUTPUT_RAW", "RC_CHANNELS"),
    mav.MAV_DATA_STREAM_POSITION: ("GLOBAL_POSITION_INT", "LOCAL_POSITION_NED"),
    mav.MAV_DATA_STREAM_EXTRA1: ("ATTITUDE",),
    mav.MAV_DATA_STREAM_EXTRA2: ("VFR_HUD",),
    mav.MAV_DATA_STREAM_EXTRA3: (
        *("BATTERY_STATUS", "SYSTEM_TIME", "DISTANCE_SENSOR"),
        *("EKF_STATUS_REPORT", "RANGEFINDER"),
    ),
}


@dataclass(slots=True, eq=False)
class _Beat:
    """Streams of one interval that are due together, now and ever after."""

    interval_us: int
    next_us: int
    message_ids: list[int]


class StreamTable:
    """Streams of one partner, in a calendar of ticks: beats that are not due cost nothing."""

    def __init__(self, profile: Profile, supported: Collection[int], now_us: int = 0) -> None:
        """Start with the default rates of `profile` for the message ids in `supported`."""
        column = 0 if profile == "normal" else 1
        self._defaults_us = {
            message_id: round(1e6 / rates[column]) if rates[column] else -1
            for name, rates in _RATES_HZ.items()
            if (message_id := LAYOUTS[name].message_id) in supported
        }
        self._supported = frozenset(supported)
        self._beats: dict[int, _Beat] = {}
        self._calendar: dict[int, list[_Beat]] = {}
        self._now_us = now_us
        self._last_tick = now_us // TICK_US
        for message_id, interval_us in self._defaults_us.items():
            self.set_interval(message_id, interval_us)

    def interval_us(self, message_id: int) -> int:
        """Present interval in us; -1 if not streamed."""
        beat = self._beats.get(message_id)
        return -1 if beat is None else beat.interval_us

    def set_interval(self, message_id: int, interval_us: float) -> bool:
        """Set an interval in us; 0 is the default rate, -1 stops the stream.

        An interval beyond `TICK_US` and `LONGEST_US` becomes the nearer of the two.

        Returns:
            False if this message is never streamed.
        """
        if message_id not in self._supported:
            return False
        if interval_us == 0:
            interval_us = self._defaults_us.get(message_id, -1)
        self._leave_beat(message_id)
        if interval_us >= 0:
            self._join_beat(message_id, round(max(TICK_US, min(LONGEST_US, interval_us))))
        return True

    def set_group(self, group: int, rate_hz: float, *, is_on: bool) -> bool:
        """Handle REQUEST_DATA_STREAM: one rate for a group of messages, except heartbeats.

        Returns:
            False if there is no such group.
        """
        if group == mav.MAV_DATA_STREAM_ALL:
            names: Sequence[str] = [name for group in _GROUPS.values() for name in group]
        elif group in _GROUPS:
            names = _GROUPS[group]
        else:
            return False
        interval_us = 1e6 / rate_hz if is_on and rate_hz > 0 else -1
        for name in names:
            self.set_interval(LAYOUTS[name].message_id, interval_us)
        return True

    def due(self, now_us: int) -> Sequence[int]:
        """Message ids to send at this tick, with those of the ticks at which nobody asked."""
        self._now_us = now_us
        tick, last_tick = now_us // TICK_US, self._last_tick
        self._last_tick = tick
        if tick > last_tick + 1:
            beats = self._overdue(tick)
        else:
            beats = self._calendar.pop(tick, [])
            for beat in beats:
                beat.next_us += beat.interval_us
        for beat in beats:
            self._calendar.setdefault(_tick(beat.next_us), []).append(beat)
        if len(beats) == 1:
            return beats[0].message_ids
        return [message_id for beat in beats for message_id in beat.message_ids]

    def _overdue(self, tick: int) -> list[_Beat]:
        """Beats that were due until a tick, each once, however often it was due."""
        passed = sorted(waiting for waiting in self._calendar if waiting <= tick)
        beats = [beat for waiting in passed for beat in self._calendar.pop(waiting)]
        for beat in beats:
            beat.next_us = max(beat.next_us + beat.interval_us, self._now_us + TICK_US)
        return beats

    def _join_beat(self, message_id: int, interval_us: int) -> None:
        """Schedule a stream from the next tick on, with those of its interval that are due then."""
        next_us = self._now_us + TICK_US
        beats = self._calendar.setdefault(_tick(next_us), [])
        for beat in beats:
            if (beat.interval_us, beat.next_us) == (interval_us, next_us):
                break
        else:
            beat = _Beat(interval_us, next_us, [])
            beats.append(beat)
        beat.message_ids.append(message_id)
        self._beats[message_id] = beat

    def _leave_beat(self, message_id: int) -> None:
        """Take a stream out of the calendar, so that changes of it leave nothing there."""
        beat = self._beats.pop(message_id, None)
        if beat is None:
            return
        beat.message_ids.remove(message_id)
        if beat.message_ids:
            return
        waiting = self._calendar[_tick(beat.next_us)]
        waiting.remove(beat)
        if not waiting:
            del self._calendar[_tick(beat.next_us)]


def _tick(time_us: int) -> int:
    """Number of the first tick at or after a time."""
    return -(-time_us // TICK_US)
