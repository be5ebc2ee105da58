"""Builders of ROS 2 messages, over the types of rosbags, which is an optional library.

rosbags serialises the message types of ROS 2 in pure Python, without ROS. The types that it lacks
are defined here by their original text.
"""

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
    """The library that serialises messages is missing; the message needs a subject before it."""


class RosMessages:
    """Makes messages of ROS 2, actuator_msgs, mavros_msgs, std_srvs and vision_msgs.

    Attributes:
        store: Type store of rosbags, which serialises them.
    """

    def __init__(self, extra: str = "ros") -> None:
        """Load the definitions of the messages.

        Args:
            extra: Extra of the package `aeroscene` that installs the library, for the error.

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
        """Return a message with the given fields.

        Args:
            kind: Type, such as `sensor_msgs/Imu`.
            fields: All fields of the type.
        """
        return self._types[_full(kind)](**fields)

    def type_hash(self, kind: str) -> str:
        """Return the hash of a type after REP 2011, such as `RIHS01_7d9a00ff...`."""
        return self.store.hash_rihs01(_full(kind))

    def time(self, time_us: int) -> Any:
        """Return a builtin_interfaces/Time of a simulated time since the start."""
        sec, rest_us = divmod(time_us, 1_000_000)
        return self.new("builtin_interfaces/Time", sec=sec, nanosec=1000 * rest_us)

    def header(self, time_us: int, frame: str) -> Any:
        """Return a std_msgs/Header with the simulated time and the name of a frame."""
        return self.new("std_msgs/Header", stamp=self.time(time_us), frame_id=frame)

    def encode(self, message: Any) -> bytes:
        """Return a message as CDR, little-endian, with the header of its encoding."""
        return bytes(self.store.serialize_cdr(message, message.__msgtype__))

    def decode(self, data: bytes, kind: str) -> Any:
        """Return the message that bytes of CDR hold.

        Args:
            data: Message with the header of its encoding.
            kind: Type, such as `sensor_msgs/Imu`.

        Raises:
            Exception: Of any class, if the bytes are no such message.
        """
        return self.store.deserialize_cdr(data, _full(kind))

    def vector(self, xyz: Any, kind: str = "Vector3") -> Any:
        """Return a geometry_msgs/Vector3 of three numbers, or another type with x, y and z.

        Args:
            xyz: Three numbers.
            kind: Name of the type in geometry_msgs, such as "Point".
        """
        x, y, z = xyz
        return self.new(f"geometry_msgs/{kind}", x=float(x), y=float(y), z=float(z))

    def quaternion(self, wxyz: Any) -> Any:
        """Return a geometry_msgs/Quaternion; ours have w first, those of ROS have it last."""
        w, x, y, z = map(float, wxyz)
        return self.new("geometry_msgs/Quaternion", w=w, x=x, y=y, z=z)

    def pose(self, position: Any, wxyz: Any) -> Any:
        """Return a geometry_msgs/Pose of a position and an attitude, w first."""
        return self.new(
            "geometry_msgs/Pose",
            position=self.vector(position, "Point"),
            orientation=self.quaternion(wxyz),
        )

    def transforms(self, *placed: tuple[Any, str, Any, Any]) -> Any:
        """Return a tf2_msgs/TFMessage.

        Args:
            placed: For each transform a header, a child frame, a translation and a rotation, w
                first.
        """
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
    """Return the full name of a type: `sensor_msgs/msg/Imu` for `sensor_msgs/Imu`."""
    package, *folder, name = kind.split("/")
    return f"{package}/{folder[0] if folder else 'msg'}/{name}"
