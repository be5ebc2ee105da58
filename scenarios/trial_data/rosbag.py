"""A trial as a ROS 2 bag in MCAP, which rosbag2 and Foxglove open.

Frames follow REP 103 and REP 105: `map` is ENU, `base_link` is FLU, a camera's `_optical` frame
looks along z. Stamps are simulated time. Depth is 16UC1 in mm with 0 for nothing seen (REP 118).
"""

from __future__ import annotations

import heapq
import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from scenarios.recording.layout import AXES, BODY_AXES
from scenarios.ros2.frames import BASE, MAP, ODOM, TRUE_BASE, optical
from scenarios.ros2.images import camera_info, image
from scenarios.ros2.messages import RosMessages, RosMissingError
from scenarios.ros2.motion import imu, odometry
from scenarios.trial_data.folders import building
from scenarios.trial_data.reading import RecordedTrial, TrialDataError, decoded
from scenarios.trial_data.ros_sensors import LATCHED, Message, SensorTopics
from scenarios.trial_data.tables import QUATERNION, TABLES

_ENCODINGS = {"rgb": "rgb8", "depth": "16UC1", "classes": "mono8", "instances": "mono16"}
"""Encoding of each kind of image."""
BAG_TABLES = frozenset(TABLES)
"""Tables that a bag holds: all of them."""


def write_bag(trial: RecordedTrial, out: Path) -> Path:
    """Write a trial as a folder with `metadata.yaml` and one `.mcap`.

    Args:
        trial: The trial.
        out: Folder to create.

    Returns:
        The folder.

    Raises:
        TrialDataError: If the library for bags is not installed, the recording holds no states, or
            something is there already.
        OSError: If it cannot be written; nothing is left.
    """
    try:
        ros = RosMessages()
    except RosMissingError as error:
        raise TrialDataError(f"mcap {error}") from None
    from rosbags.rosbag2 import (  # an extra, which is there now
        CompressionFormat,
        CompressionMode,
        StoragePlugin,
        Writer,
    )

    trial.require("states", "imu", "motors", what="a bag")
    with building(out) as folder:
        folder.rmdir()  # The writer makes it.
        bag = Writer(folder, version=8, storage_plugin=StoragePlugin.MCAP)
        # Chunks of the file are compressed, not single messages.
        bag.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)
        with bag:
            connections: dict[str, Any] = {}
            for time_us, topic, message in _Topics(trial, ros).messages():
                kind = message.__msgtype__
                if topic not in connections:
                    connections[topic] = bag.add_connection(
                        topic, kind, typestore=ros.store, offered_qos_profiles=_qos(topic)
                    )
                # Stamps of a bag are in nanoseconds.
                data = ros.store.serialize_cdr(message, kind)
                bag.write(connections[topic], 1000 * time_us, data)
    return out


class _Topics:
    """Topics of a trial, each in order of time."""

    def __init__(self, trial: RecordedTrial, ros: RosMessages) -> None:
        self._trial = trial
        self._ros = ros

    def messages(self) -> Iterator[Message]:
        """Yield all messages in order of time.

        Each stream is sorted, so merging them needs no list of all messages.
        """
        streams = (
            self._static_transforms(),
            self._odometry("true", MAP, TRUE_BASE),
            self._odometry("estimate", ODOM, BASE),
            self._imu(),
            self._motors("command"),
            self._motors("speed"),
            self._plans(),
            self._frames(),
            self._events(),
            *SensorTopics(trial=self._trial, ros=self._ros).streams(),
        )
        return heapq.merge(*streams, key=lambda message: message[0])

    def _odometry(self, whose: str, world: str, frame: str) -> Iterator[Message]:
        """Yield the pose in the world and the velocity in the body, and the pose as a transform."""
        trial = self._trial
        position = trial.array("states", f"position_{whose}", "m", AXES)
        wxyz = trial.array("states", f"attitude_{whose}", "", QUATERNION)
        velocity = trial.array("states", f"velocity_{whose}", "mps", AXES)
        rate = trial.array("states", f"angular_rate_{whose}", "radps", BODY_AXES)
        # The estimate is NaN before the filter is aligned, which no message can hold usefully.
        is_known = np.isfinite(wxyz).all(axis=1) & np.isfinite(position).all(axis=1)
        for row in np.flatnonzero(is_known).tolist():
            time_us = trial.tables["states"]["time_us"][row].as_py()
            header = self._ros.header(time_us, world)
            message = odometry(
                self._ros, header, frame, position[row], wxyz[row], velocity[row], rate[row]
            )
            yield time_us, f"/odometry/{whose}", message
            yield time_us, "/tf", self._ros.transforms((header, frame, position[row], wxyz[row]))

    def _static_transforms(self) -> Iterator[Message]:
        header = self._ros.header(0, BASE)
        # `map` and `odom` coincide: the estimate is in the scene's frame already.
        same = (self._ros.header(0, MAP), ODOM, (0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0))
        placed = [
            (header, optical(name), mount.position_flu_m, mount.quat_flu_from_optical_wxyz)
            for name, mount in self._trial.mounts.items()
        ]
        yield 0, "/tf_static", self._ros.transforms(same, *placed)

    def _imu(self) -> Iterator[Message]:
        trial = self._trial
        time_us = trial.tables["imu"]["time_us"].to_pylist()
        force = trial.array("imu", "acceleration", "mps2", BODY_AXES)
        rate = trial.array("imu", "angular_rate", "radps", BODY_AXES)
        for time, a, w in zip(time_us, force, rate, strict=True):
            message = imu(self._ros, self._ros.header(time, BASE), a, w)
            yield time, "/imu", message

    def _motors(self, prefix: str) -> Iterator[Message]:
        """Yield rotor speeds in rad/s."""
        nothing = np.zeros(0)
        time_us = self._trial.tables["motors"]["time_us"].to_pylist()
        speeds = self._trial.array("motors", prefix, "radps", self._trial.rotors)
        for time, speed in zip(time_us, speeds, strict=True):
            message = self._ros.new(
                "actuator_msgs/Actuators",
                header=self._ros.header(time, BASE),
                position=nothing,
                velocity=speed,
                normalized=nothing,
            )
            yield time, f"/motors/{prefix}", message

    def _plans(self) -> Iterator[Message]:
        """Yield each plan when it takes over; its points are stamped with their times."""
        table = self._trial.tables["plans"]
        number, since_us = table["plan"].to_numpy(), table["since_us"].to_numpy()
        time_us = table["time_us"].to_numpy()
        points = self._trial.array("plans", "position", "m", AXES)
        for plan in np.unique(number).tolist():
            rows = np.flatnonzero(number == plan).tolist()
            poses = [
                self._ros.new(
                    "geometry_msgs/PoseStamped",
                    header=self._ros.header(int(time_us[row]), MAP),
                    pose=self._ros.pose(points[row], (1.0, 0.0, 0.0, 0.0)),
                )
                for row in rows
            ]
            time = int(since_us[rows[0]])
            yield (
                time,
                "/plan",
                self._ros.new("nav_msgs/Path", header=self._ros.header(time, MAP), poses=poses),
            )

    def _frames(self) -> Iterator[Message]:
        """Yield images decoded, and the lens beside each."""
        encoded = {picture.file: picture.data for picture in self._trial.pictures}
        where = f"recording {self._trial.name!r}"
        for frame in self._trial.tables["frames"].to_pylist():
            for kind, encoding in _ENCODINGS.items():
                if (file := frame[f"{kind}_file"]) is not None:
                    yield from self._image(frame, kind, encoding, decoded(encoded[file], where))

    def _image(
        self, frame: Mapping[str, Any], kind: str, encoding: str, pixels: np.ndarray
    ) -> Iterator[Message]:
        time_us, camera = frame["time_us"], frame["camera"]
        header, topic = self._ros.header(time_us, optical(camera)), f"/camera_{camera}/{kind}"
        height, width = pixels.shape[:2]
        fx, fy = frame["focal_x_px"], frame["focal_y_px"]
        cx, cy = frame["centre_x_px"], frame["centre_y_px"]
        yield time_us, f"{topic}/image_raw", image(self._ros, header, pixels, encoding)
        info = camera_info(self._ros, header, (width, height), (fx, fy, cx, cy))
        yield time_us, f"{topic}/camera_info", info

    def _events(self) -> Iterator[Message]:
        """Yield changes and texts, and the verdict at the end."""
        for event in self._trial.tables["events"].to_pylist():
            line = self._ros.new("std_msgs/String", data=event["value"])
            yield event["time_us"], f"/{event['what']}", line
        about = self._trial.tables["trials"].to_pylist()[0]
        # The verdict has no time of its own.
        end_us = self._trial.tables["states"]["time_us"][-1].as_py()
        words = {name: about[name] for name in ("scene", "vehicle", "success", "code", "reason")}
        yield end_us, "/verdict", self._ros.new("std_msgs/String", data=json.dumps(words))


def _qos(topic: str) -> tuple[Any, ...]:
    """Return the quality of service: late subscribers still get messages that never change."""
    from rosbags.interfaces import (
        Qos,
        QosDurability,
        QosHistory,
        QosLiveliness,
        QosReliability,
        QosTime,
    )

    forever = QosTime(0, 0)
    is_latched = topic in LATCHED
    return (
        Qos(
            QosHistory.KEEP_LAST,
            10,
            QosReliability.RELIABLE,
            QosDurability.TRANSIENT_LOCAL if is_latched else QosDurability.VOLATILE,
            forever,
            forever,
            QosLiveliness.AUTOMATIC,
            forever,
            avoid_ros_namespace_conventions=False,
        ),
    )
