"""Builders of ROS 2 messages, over the types of a library that is an extra."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from scenarios.trial_data.reading import TrialDataError

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
    # https://github.com/ros-perception/vision_msgs
    "vision_msgs/msg/VisionClass": "uint16 class_id\nstring class_name\n",
    "vision_msgs/msg/LabelInfo": """\
std_msgs/Header header
vision_msgs/VisionClass[] class_map
float32 threshold
""",
}


class RosMissingError(TrialDataError):
    """The library for bags is not installed."""


class RosMessages:
    """Makes messages of ROS 2, actuator_msgs, mavros_msgs and vision_msgs.

    Attributes:
        store: Type store of rosbags, which serializes them.
    """

    def __init__(self) -> None:
        """Load the definitions of the messages.

        Raises:
            RosMissingError: If the library is not installed.
        """
        try:
            from rosbags.typesys import Stores, get_types_from_msg, get_typestore
        except ImportError:
            raise RosMissingError(
                "mcap needs rosbags, which is not installed; valid: pip install 'aeroscene[ros]'"
            ) from None
        self.store = get_typestore(Stores.ROS2_HUMBLE)
        for name, definition in _DEFINITIONS.items():
            self.store.register(get_types_from_msg(definition, name))
        self._types: Mapping[str, Any] = self.store.types

    def new(self, kind: str, **fields: Any) -> Any:
        """A message by its fields; the kind is such as `sensor_msgs/Imu`."""
        package, _, name = kind.partition("/")
        return self._types[f"{package}/msg/{name}"](**fields)

    def header(self, time_us: int, frame: str) -> Any:
        """Header with the simulated time."""
        stamp = self.new(
            "builtin_interfaces/Time",
            sec=time_us // 1_000_000,
            nanosec=1000 * (time_us % 1_000_000),
        )
        return self.new("std_msgs/Header", stamp=stamp, frame_id=frame)

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
