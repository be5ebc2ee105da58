"""Builders of ROS 2 messages, over the types of a library that is an extra."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from typing import Any

_ACTUATORS = "actuator_msgs/msg/Actuators"
# https://github.com/rudislabs/actuator_msgs
_ACTUATORS_MSG = """\
std_msgs/Header header
float64[] position
float64[] velocity
float64[] normalized
"""


_DEFINITIONS = {
    _ACTUATORS: _ACTUATORS_MSG,
    # https://github.com/mavlink/mavros, mavros_msgs/msg/OpticalFlowRad.msg
    "mavros_msgs/msg/OpticalFlowRad": """\
std_msgs/Header header
uint32 integration_time_us
float32 integrated_x
float32 integrated_y
float32 integrated_xgyro
float32 integrated_ygyro
float32 integrated_zgyro
int16 temperature
uint8 quality
uint32 time_delta_distance_us
float32 distance
""",
    # https://github.com/ros2/common_interfaces, the two halves of SetBool.srv and Trigger.srv
    "std_srvs/SetBool_Request": "bool data\n",
    "std_srvs/SetBool_Response": "bool success\nstring message\n",
    "std_srvs/Trigger_Request": "",
    "std_srvs/Trigger_Response": "bool success\nstring message\n",
    # https://github.com/ros-perception/vision_msgs
    "vision_msgs/msg/VisionClass": "uint16 class_id\nstring class_name\n",
    "vision_msgs/msg/LabelInfo": """\
std_msgs/Header header
vision_msgs/VisionClass[] class_map
float32 threshold
""",
}


class RosMissingError(RuntimeError):
    """The library that serializes messages is not installed; the message has no subject."""


class RosMessages:
    """Makes messages of ROS 2, actuator_msgs, mavros_msgs, std_srvs and vision_msgs.

    Attributes:
        store: Type store of rosbags, which serializes them.
    """

    def __init__(self, extra: str = "ros") -> None:
        """Load the definitions of the messages.

        Args:
            extra: Extra of ours that brings the library.

        Raises:
            RosMissingError: If the library is not installed.
        """
        try:
            from rosbags.typesys import Stores, get_types_from_msg, get_typestore
        except ImportError:
            raise RosMissingError(
                f"needs rosbags, which is not installed; valid: pip install 'aeroscene[{extra}]'"
            ) from None
        self.store = get_typestore(Stores.ROS2_HUMBLE)
        for name, definition in _DEFINITIONS.items():
            self.store.register(get_types_from_msg(definition, name))
        self._types: Mapping[str, Any] = self.store.types

    def new(self, kind: str, **fields: Any) -> Any:
        """A message by its fields; the kind is such as `sensor_msgs/Imu`."""
        return self._types[_full(kind)](**fields)

    def type_hash(self, kind: str) -> str:
        """Hash of a type after REP 2011, such as `RIHS01_7d9a00ff...`."""
        return self.store.hash_rihs01(_full(kind))

    def time(self, time_us: int) -> Any:
        """A simulated time."""
        sec, rest_us = divmod(time_us, 1_000_000)
        return self.new("builtin_interfaces/Time", sec=sec, nanosec=1000 * rest_us)

    def header(self, time_us: int, frame: str) -> Any:
        """Header with the simulated time."""
        return self.new("std_msgs/Header", stamp=self.time(time_us), frame_id=frame)

    def encode(self, message: Any) -> bytes:
        """A message as CDR, little-endian, with the header of its encoding."""
        return bytes(self.store.serialize_cdr(message, message.__msgtype__))

    def decode(self, data: bytes, kind: str) -> Any:
        """A message of CDR; the kind is such as `sensor_msgs/Imu`.

        Raises:
            Exception: Of any kind, if the bytes are no such message.
        """
        return self.store.deserialize_cdr(data, _full(kind))

    def vector(self, xyz: Any, kind: str = "Vector3") -> Any:
        """Three numbers of a kind of geometry_msgs."""
        x, y, z = xyz
        return self.new(f"geometry_msgs/{kind}", x=float(x), y=float(y), z=float(z))

    def quaternion(self, wxyz: Any) -> Any:
        """A rotation."""
        w, x, y, z = map(float, wxyz)
        return self.new("geometry_msgs/Quaternion", w=w, x=x, y=y, z=z)

    def pose(self, position: Any, wxyz: Any) -> Any:
        """A place and an attitude."""
        return self.new(
            "geometry_msgs/Pose",
            position=self.vector(position, "Point"),
            orientation=self.quaternion(wxyz),
        )

    def transforms(self, *placed: tuple[Any, str, Any, Any]) -> Any:
        """Transforms, each of a header, a child frame, a translation and a rotation."""
        stamped = [
            self.new(
                "geometry_msgs/TransformStamped",
                header=header,
                child_frame_id=child,
                transform=self.new(
                    "geometry_msgs/Transform",
                    translation=self.vector(at),
                    rotation=self.quaternion(turn),
                ),
            )
            for header, child, at, turn in placed
        ]
        return self.new("tf2_msgs/TFMessage", transforms=stamped)


@functools.cache
def _full(kind: str) -> str:
    """`sensor_msgs/Imu` as ROS 2 writes it in full: `sensor_msgs/msg/Imu`."""
    package, *folder, name = kind.split("/")
    return f"{package}/{folder[0] if folder else 'msg'}/{name}"
