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
from jaxtyping import Float
from scipy.spatial.transform import Rotation

from scenarios.recording.layout import AXES, BODY_AXES
from scenarios.trial_data.folders import building
from scenarios.trial_data.reading import RecordedTrial, decoded
from scenarios.trial_data.ros_messages import RosMessages
from scenarios.trial_data.ros_sensors import LATCHED, Message, SensorTopics
from scenarios.trial_data.tables import QUATERNION, TABLES

_MAP, _BODY = "map", "base_link"
_ENCODINGS = {"rgb": "rgb8", "depth": "16UC1", "classes": "mono8", "instances": "mono16"}
"""Encoding of each kind of image."""
BAG_TABLES = frozenset(TABLES)
"""Tables that a bag holds: all of them."""
_UNKNOWN = -1.0
"""First element of a covariance of what a message does not hold."""


def write_bag(trial: RecordedTrial, out: Path) -> Path:
    """Write a trial as a folder with `metadata.yaml` and one `.mcap`.

    Args:
        trial: The trial.
        out: Folder that is made.

    Raises:
        RosMissingError: If the library for bags is not installed.
        TrialDataError: If the recording holds no states, or something is there already.
        OSError: If it cannot be written; nothing is left.
    """
    ros = RosMessages()
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
        bag.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)
        with bag:
            connections: dict[str, Any] = {}
            for time_us, topic, message in _Topics(trial, ros).messages():
                kind = message.__msgtype__
                if topic not in connections:
                    connections[topic] = bag.add_connection(
                        topic, kind, typestore=ros.store, offered_qos_profiles=_qos(topic)
                    )
                data = ros.store.serialize_cdr(message, kind)
                bag.write(connections[topic], 1000 * time_us, data)
    return out


class _Topics:
    """Topics of a trial, each in order of time."""

    def __init__(self, trial: RecordedTrial, ros: RosMessages) -> None:
        self._trial = trial
        self._ros = ros

    def messages(self) -> Iterator[Message]:
        """All messages in order of time."""
        streams = (
            self._static_transforms(),
            self._odometry("true", _BODY),
            self._odometry("estimate", f"{_BODY}_estimate"),
            self._imu(),
            self._motors("command"),
            self._motors("speed"),
            self._plans(),
            self._frames(),
            self._events(),
            *SensorTopics(trial=self._trial, ros=self._ros).streams(),
        )
        return heapq.merge(*streams, key=lambda message: message[0])

    def _odometry(self, whose: str, frame: str) -> Iterator[Message]:
        """Pose in the map and velocity in the body, and the pose as a transform."""
        trial = self._trial
        position = trial.array("states", f"position_{whose}", "m", AXES)
        wxyz = trial.array("states", f"attitude_{whose}", "", QUATERNION)
        velocity = trial.array("states", f"velocity_{whose}", "mps", AXES)
        rate = trial.array("states", f"angular_rate_{whose}", "radps", BODY_AXES)
        is_known = np.isfinite(wxyz).all(axis=1) & np.isfinite(position).all(axis=1)
        for row in np.flatnonzero(is_known).tolist():
            time_us = trial.tables["states"]["time_us"][row].as_py()
            twist = self._ros.new(
                "geometry_msgs/Twist",
                linear=self._ros.vector(_in_body(velocity[row], wxyz[row])),
                angular=self._ros.vector(rate[row]),
            )
            header = self._ros.header(time_us, _MAP)
            message = self._ros.new(
                "nav_msgs/Odometry",
                header=header,
                child_frame_id=frame,
                pose=self._ros.new(
                    "geometry_msgs/PoseWithCovariance",
                    pose=self._ros.pose(position[row], wxyz[row]),
                    covariance=np.zeros(36),
                ),
                twist=self._ros.new(
                    "geometry_msgs/TwistWithCovariance", twist=twist, covariance=np.zeros(36)
                ),
            )
            yield time_us, f"/odometry/{whose}", message
            yield time_us, "/tf", self._ros.transforms((header, frame, position[row], wxyz[row]))

    def _static_transforms(self) -> Iterator[Message]:
        header = self._ros.header(0, _BODY)
        placed = [
            (header, _optical(name), mount.position_flu_m, mount.quat_flu_from_optical_wxyz)
            for name, mount in self._trial.mounts.items()
        ]
        if placed:
            yield 0, "/tf_static", self._ros.transforms(*placed)

    def _imu(self) -> Iterator[Message]:
        trial = self._trial
        time_us = trial.tables["imu"]["time_us"].to_pylist()
        force = trial.array("imu", "acceleration", "mps2", BODY_AXES)
        rate = trial.array("imu", "angular_rate", "radps", BODY_AXES)
        unknown = np.array([_UNKNOWN, *np.zeros(8)])
        for time, a, w in zip(time_us, force, rate, strict=True):
            message = self._ros.new(
                "sensor_msgs/Imu",
                header=self._ros.header(time, _BODY),
                orientation=self._ros.quaternion((1.0, 0.0, 0.0, 0.0)),
                orientation_covariance=unknown,
                angular_velocity=self._ros.vector(w),
                angular_velocity_covariance=np.zeros(9),
                linear_acceleration=self._ros.vector(a),
                linear_acceleration_covariance=np.zeros(9),
            )
            yield time, "/imu", message

    def _motors(self, prefix: str) -> Iterator[Message]:
        """Rotor speeds in rad/s."""
        nothing = np.zeros(0)
        time_us = self._trial.tables["motors"]["time_us"].to_pylist()
        speeds = self._trial.array("motors", prefix, "radps", self._trial.rotors)
        for time, speed in zip(time_us, speeds, strict=True):
            message = self._ros.new(
                "actuator_msgs/Actuators",
                header=self._ros.header(time, _BODY),
                position=nothing,
                velocity=speed,
                normalized=nothing,
            )
            yield time, f"/motors/{prefix}", message

    def _plans(self) -> Iterator[Message]:
        """Each plan when it is taken up; its points are stamped with their times."""
        table = self._trial.tables["plans"]
        number, since_us = table["plan"].to_numpy(), table["since_us"].to_numpy()
        time_us = table["time_us"].to_numpy()
        points = self._trial.array("plans", "position", "m", AXES)
        for plan in np.unique(number).tolist():
            rows = np.flatnonzero(number == plan).tolist()
            poses = [
                self._ros.new(
                    "geometry_msgs/PoseStamped",
                    header=self._ros.header(int(time_us[row]), _MAP),
                    pose=self._ros.pose(points[row], (1.0, 0.0, 0.0, 0.0)),
                )
                for row in rows
            ]
            time = int(since_us[rows[0]])
            yield (
                time,
                "/plan",
                self._ros.new("nav_msgs/Path", header=self._ros.header(time, _MAP), poses=poses),
            )

    def _frames(self) -> Iterator[Message]:
        """Images as they are, decoded, and the lens beside each."""
        encoded = {picture.file: picture.data for picture in self._trial.pictures}
        where = f"recording {self._trial.name!r}"
        for frame in self._trial.tables["frames"].to_pylist():
            for kind, encoding in _ENCODINGS.items():
                if (file := frame[f"{kind}_file"]) is not None:
                    yield from self._image(frame, kind, encoding, decoded(encoded[file], where))

    def _image(
        self, frame: Mapping[str, Any], kind: str, encoding: str, image: np.ndarray
    ) -> Iterator[Message]:
        time_us, camera = frame["time_us"], frame["camera"]
        header, topic = self._ros.header(time_us, _optical(camera)), f"/camera_{camera}/{kind}"
        height, width = image.shape[:2]
        fx, fy = frame["focal_x_px"], frame["focal_y_px"]
        cx, cy = frame["centre_x_px"], frame["centre_y_px"]
        size = {"header": header, "height": height, "width": width}
        yield (
            time_us,
            f"{topic}/image_raw",
            self._ros.new(
                "sensor_msgs/Image",
                **size,
                encoding=encoding,
                is_bigendian=0,
                step=image.strides[0],
                data=image.reshape(-1).view(np.uint8),
            ),
        )
        no_region = self._ros.new(
            "sensor_msgs/RegionOfInterest",
            x_offset=0,
            y_offset=0,
            height=0,
            width=0,
            do_rectify=False,
        )
        yield (
            time_us,
            f"{topic}/camera_info",
            self._ros.new(
                "sensor_msgs/CameraInfo",
                **size,
                distortion_model="plumb_bob",
                d=np.zeros(5),
                k=np.array([fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0]),
                r=np.eye(3).ravel(),
                p=np.array([fx, 0.0, cx, 0.0, 0.0, fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0]),
                binning_x=0,
                binning_y=0,
                roi=no_region,
            ),
        )

    def _events(self) -> Iterator[Message]:
        """Changes and texts, and the verdict at the end."""
        for event in self._trial.tables["events"].to_pylist():
            line = self._ros.new("std_msgs/String", data=event["value"])
            yield event["time_us"], f"/{event['what']}", line
        about = self._trial.tables["trials"].to_pylist()[0]
        end_us = self._trial.tables["states"]["time_us"][-1].as_py()
        words = {name: about[name] for name in ("scene", "vehicle", "success", "code", "reason")}
        yield end_us, "/verdict", self._ros.new("std_msgs/String", data=json.dumps(words))


def _qos(topic: str) -> tuple[Any, ...]:
    """Quality of service: who subscribes late still gets what never changes."""
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


def _optical(camera: str) -> str:
    return f"camera_{camera}_optical"


def _in_body(
    vector_enu: Float[np.ndarray, " 3"], quat_wxyz: Float[np.ndarray, " 4"]
) -> Float[np.ndarray, " 3"]:
    """A vector of the world in the body's frame."""
    return Rotation.from_quat(quat_wxyz, scalar_first=True).inv().apply(vector_enu)
