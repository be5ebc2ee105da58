"""Topics of a vehicle's state: clock, transforms, odometry, IMU, satellites, battery, modes."""

from __future__ import annotations

from typing import Any

import numpy as np

from flightsim.autopilot.reports import FlightReports
from flightsim.frames import LocalFrame
from flightsim.plant import Plant
from scenarios.ros2.frames import BASE, MAP, ODOM, TRUE_BASE
from scenarios.ros2.motion import imu, odometry
from scenarios.ros2.places import satellite_fix
from scenarios.ros2.power import battery
from scenarios.ros2.topics import Topics
from scenarios.ros2.transport import LATCHED, SENSOR, STATE, TRANSFORM

PERIOD_US = 10_000
"""Simulated time between two samples of poses and of the clock: 100 Hz."""
BATTERY_PERIOD_US = 100_000
_FIELDS = {
    whose: tuple(
        name.format(whose)
        for name in (
            *("position_{}_enu_m", "quat_{}_wxyz"),
            *("velocity_{}_enu_mps", "angular_rate_{}_flu_radps"),
        )
    )
    for whose in ("true", "est")
}
"""Fields of a row of the history that make an odometry, for the truth and for the estimate."""


class StateTopics:
    """Publishes the state of a vehicle after each tick."""

    def __init__(
        self, topics: Topics, plant: Plant, frame: LocalFrame, reports: FlightReports
    ) -> None:
        self._ros, self._plant, self._frame, self._reports = topics.ros, plant, frame, reports
        self._base = topics.frame(BASE)
        self._frames = {
            "true": (MAP, topics.frame(TRUE_BASE)),
            "est": (topics.frame(ODOM), self._base),
        }
        self._clock = None
        # One clock for all: every vehicle of a world has the same time.
        if plant.world.number == 0:
            self._clock = topics.publisher("/clock", "rosgraph_msgs/Clock", SENSOR)
        self._tf = topics.publisher("/tf", "tf2_msgs/TFMessage", TRANSFORM)
        self._odometry = {
            whose: topics.publisher(f"odometry/{name}", "nav_msgs/Odometry", STATE)
            for whose, name in (("true", "true"), ("est", "estimate"))
        }
        self._imu = topics.publisher("imu", "sensor_msgs/Imu", SENSOR)
        self._fix = topics.publisher("gnss/fix", "sensor_msgs/NavSatFix", SENSOR)
        self._fix_us = 0
        self._battery = topics.publisher("battery", "sensor_msgs/BatteryState", SENSOR)
        self._battery_due_us = 0
        self._words = {
            name: topics.publisher(name, "std_msgs/String", LATCHED)
            for name in ("mode", "armed", "landed_state", "failsafe")
        }
        self._said: dict[str, str] = {}

    def on_tick(self) -> None:
        """Publish the rows of the last tick in order of time, then fix, battery and modes."""
        rows, tick_us = self._plant.history, self._plant.tick_us
        for row, time_us in zip(rows, rows["time_us"].tolist(), strict=True):
            # True for the first row at or after each multiple of the period.
            if time_us // PERIOD_US > (time_us - tick_us) // PERIOD_US:
                self._send_poses(row, time_us)
            if self._imu.is_heard:
                header = self._ros.header(time_us, self._base)
                accel, gyro = row["accel_flu_mps2"].tolist(), row["gyro_flu_radps"].tolist()
                self._imu.send(imu(self._ros, header, accel, gyro))
        self._send_fix()
        self._send_battery()
        self._send_words()

    def _send_poses(self, row: np.void, time_us: int) -> None:
        """Publish clock, odometry and transforms of a row.

        The clock comes first, so that a node which gets a transform knows its time already.
        """
        ros = self._ros
        if self._clock is not None:
            self._clock.offer(lambda: ros.new("rosgraph_msgs/Clock", clock=ros.time(time_us)))
        placed: list[tuple[Any, str, Any, Any]] = []
        for whose, publisher in self._odometry.items():
            position, wxyz, velocity, rate = (row[field].tolist() for field in _FIELDS[whose])
            if whose == "est" and not any(position):
                continue  # The estimator is not aligned yet.
            world, base = self._frames[whose]
            header = ros.header(time_us, world)
            placed.append((header, base, position, wxyz))
            if publisher.is_heard:
                publisher.send(odometry(ros, header, base, position, wxyz, velocity, rate))
        if self._tf.is_heard:
            self._tf.send(ros.transforms(*placed))

    def _send_fix(self) -> None:
        reading = self._plant.sensors.gnss
        # The receiver is slower than the loop, and its reading stays until the next one.
        if reading.time_us == self._fix_us:
            return
        self._fix_us = reading.time_us
        header = self._ros.header(reading.time_us, self._base)
        self._fix.offer(lambda: satellite_fix(self._ros, header, reading, self._frame))

    def _send_battery(self) -> None:
        now_us, state = self._plant.time_us, self._plant.battery
        if now_us < self._battery_due_us:
            return
        self._battery_due_us = now_us + BATTERY_PERIOD_US
        header = self._ros.header(now_us, self._base)
        self._battery.offer(
            lambda: battery(self._ros, header, state.voltage_v, state.current_a, state.remaining)
        )

    def _send_words(self) -> None:
        """Publish mode, armed state, landed state and failsafe whenever one of them changes."""
        # Also while nobody listens, because late subscribers get the last value.
        reports = self._reports
        failsafe = reports.failsafe
        said = {
            "mode": reports.mode.value,
            "armed": "armed" if reports.is_armed else "disarmed",
            "landed_state": reports.landed_state.value,
            "failsafe": failsafe.value if failsafe else "none",
        }
        for name, word in said.items():
            if self._said.get(name) != word:
                self._said[name] = word
                self._words[name].send(self._ros.new("std_msgs/String", data=word))
