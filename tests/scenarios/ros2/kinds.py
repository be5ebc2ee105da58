"""Types of ROS 2 by `ros2_pyterfaces`, whose definitions, hashes and CDR are not the door's."""

from dataclasses import dataclass

from ros2_pyterfaces.cyclone import all_msgs
from ros2_pyterfaces.cyclone.geometry_msgs.msg import TransformStamped
from ros2_pyterfaces.cyclone.idl import IdlStruct, types


@dataclass
class TFMessage(IdlStruct, typename="tf2_msgs/msg/TFMessage"):  # tf2_msgs is not among them
    transforms: types.sequence[TransformStamped]


def kind_named(name):
    """Class of messages such as `sensor_msgs/msg/Imu`."""
    return TFMessage if name == TFMessage.get_type_name() else getattr(all_msgs, name.split("/")[2])


TOPICS = {
    "/clock": "rosgraph_msgs/msg/Clock",
    "/tf": "tf2_msgs/msg/TFMessage",
    "/tf_static": "tf2_msgs/msg/TFMessage",
    "/odometry/true": "nav_msgs/msg/Odometry",
    "/odometry/estimate": "nav_msgs/msg/Odometry",
    "/imu": "sensor_msgs/msg/Imu",
    "/gnss/fix": "sensor_msgs/msg/NavSatFix",
    "/battery": "sensor_msgs/msg/BatteryState",
    "/camera_down/rgb/image_raw": "sensor_msgs/msg/Image",
    "/camera_down/rgb/camera_info": "sensor_msgs/msg/CameraInfo",
    "/camera_down/depth/image_raw": "sensor_msgs/msg/Image",
    "/camera_down/depth/camera_info": "sensor_msgs/msg/CameraInfo",
    "/camera_down/depth/points": "sensor_msgs/msg/PointCloud2",
    "/lidar/points": "sensor_msgs/msg/PointCloud2",
    "/landing_areas": "visualization_msgs/msg/MarkerArray",
    "/mode": "std_msgs/msg/String",
    "/armed": "std_msgs/msg/String",
    "/landed_state": "std_msgs/msg/String",
    "/failsafe": "std_msgs/msg/String",
}
LATCHED = {"/tf_static", "/landing_areas", "/mode", "/armed", "/landed_state", "/failsafe"}
"""What late subscribers still get."""
