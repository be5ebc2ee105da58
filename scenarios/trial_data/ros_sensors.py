"""Topics of a bag for lidar, optical flow, gauges, labels of segments, movers and contacts.

Each table of a trial becomes messages of the standard type that ROS tools already display, if there
is one, else plain numbers or JSON.
"""

from __future__ import annotations

import io
import json
import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from scenarios.recording.layout import AXES
from scenarios.ros2.clouds import cloud
from scenarios.ros2.frames import BASE, MAP
from scenarios.ros2.messages import RosMessages
from scenarios.ros2.power import battery
from scenarios.trial_data.reading import RecordedTrial
from scenarios.trial_data.tables import QUATERNION

_INFRARED, _RANGE_M = 1, (0.0, 100.0)
_LABELS = {image: f"/labels/{image}" for image in ("classes", "instances")}
LATCHED = frozenset({"/tf_static", *_LABELS.values()})
"""Topics whose last message is also sent to late subscribers."""
Message = tuple[int, str, Any]
"""A message with its time in us and its topic."""


@dataclass(frozen=True, kw_only=True)
class SensorTopics:
    """Sensors of a vehicle besides IMU and cameras, and its encounters."""

    trial: RecordedTrial
    ros: RosMessages

    def streams(self) -> tuple[Iterator[Message], ...]:
        """Return the messages of each topic, in order of time; none if nothing was recorded."""
        return (
            self._labels(),
            self._scans(),
            self._flow(),
            self._gauges(),
            self._movers(),
            self._contacts(),
        )

    def _labels(self) -> Iterator[Message]:
        rows = self.trial.tables["labels"].to_pylist()
        for image, topic in _LABELS.items():
            names = {row["number"]: row["name"] for row in rows if row["image"] == image}
            if names:
                # vision_msgs has one message for the meaning of all numbers of an image.
                classes = [
                    self.ros.new("vision_msgs/VisionClass", class_id=number, class_name=name)
                    for number, name in names.items()
                ]
                header = self.ros.header(0, "")
                info = {"header": header, "class_map": classes, "threshold": 0.0}
                yield 0, topic, self.ros.new("vision_msgs/LabelInfo", **info)

    def _scans(self) -> Iterator[Message]:
        """Yield points on the vehicle, as the recording has them."""
        points = {each.file: each.data for each in self.trial.scans}
        for row in self.trial.tables["scans"].to_pylist():
            scan = np.load(io.BytesIO(points[row["points_file"]]))
            header = self.ros.header(row["time_us"], BASE)
            yield row["time_us"], "/lidar/points", cloud(self.ros, header, scan)

    def _flow(self) -> Iterator[Message]:
        """Yield angles in FRD, as MAVLink and mavros have them."""
        for row in self.trial.tables["optical_flow"].to_pylist():
            yield (
                row["time_us"],
                "/optical_flow",
                self.ros.new(
                    "mavros_msgs/OpticalFlowRad",
                    header=self.ros.header(row["time_us"], BASE),
                    integration_time_us=row["integration_us"],
                    integrated_x=row["flow_forward_rad"],
                    integrated_y=row["flow_right_rad"],
                    integrated_xgyro=row["gyro_forward_rad"],
                    integrated_ygyro=row["gyro_right_rad"],
                    integrated_zgyro=row["gyro_down_rad"],
                    temperature=0,
                    quality=row["quality"],
                    time_delta_distance_us=0,
                    distance=row["distance_m"],
                ),
            )

    def _gauges(self) -> Iterator[Message]:
        """Yield battery, rangefinder, and the others as plain numbers."""
        for row in self.trial.tables["gauges"].to_pylist():
            time_us = row["time_us"]
            yield time_us, "/battery", self._battery(row)
            # NaN means that the vehicle lacks the sensor or that nothing was met.
            if not math.isnan(row["range_m"]):
                yield time_us, "/rangefinder", self._range(row)
            for topic, column in (
                ("/airspeed", "airspeed_mps"),
                ("/estimate/sigma_horizontal", "sigma_horizontal_m"),
                ("/estimate/sigma_vertical", "sigma_vertical_m"),
            ):
                if not math.isnan(row[column]):
                    yield time_us, topic, self.ros.new("std_msgs/Float64", data=row[column])

    def _battery(self, row: dict[str, Any]) -> Any:
        return battery(
            self.ros,
            self.ros.header(row["time_us"], BASE),
            row["battery_voltage_v"],
            row["battery_current_a"],
            # ROS has a share.
            row["battery_remaining_percent"] / 100.0,
        )

    def _range(self, row: dict[str, Any]) -> Any:
        return self.ros.new(
            "sensor_msgs/Range",
            header=self.ros.header(row["time_us"], BASE),
            radiation_type=_INFRARED,
            field_of_view=0.0,
            min_range=_RANGE_M[0],
            max_range=_RANGE_M[1],
            range=row["range_m"],
        )

    def _movers(self) -> Iterator[Message]:
        # The table has one mover after the other, a bag's streams are in order of time.
        rows = sorted(self.trial.tables["movers"].to_pylist(), key=lambda row: row["time_us"])
        for row in rows:
            pose = self.ros.pose(
                [row[f"position_{axis}_m"] for axis in AXES],
                [row[f"attitude_{part}"] for part in QUATERNION],
            )
            header = self.ros.header(row["time_us"], MAP)
            message = self.ros.new("geometry_msgs/PoseStamped", header=header, pose=pose)
            yield row["time_us"], f"/movers/{row['mover']}", message

    def _contacts(self) -> Iterator[Message]:
        """Yield each contact as JSON, at its beginning."""
        for row in self.trial.tables["contacts"].sort_by("since_us").to_pylist():
            del row["trial"]
            message = self.ros.new("std_msgs/String", data=json.dumps(row))
            yield row["since_us"], "/contacts", message
