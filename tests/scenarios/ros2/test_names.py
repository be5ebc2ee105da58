"""Types, hashes, keys and bytes, beside those of implementations that are not ours."""

import struct

import numpy as np
import pytest
from ros2_pyterfaces.cyclone.std_srvs.srv import SetBool, Trigger

from scenarios.ros2 import commands, zenoh_names
from scenarios.ros2.clouds import cloud
from scenarios.ros2.images import camera_info, depth_cloud, image
from scenarios.ros2.messages import RosMessages
from scenarios.ros2.motion import imu, in_body, odometry
from scenarios.ros2.power import battery
from scenarios.ros2.transport import LATCHED, SENSOR, STATE, Kind
from tests.scenarios.ros2.kinds import TOPICS, kind_named

COMMANDS = {
    *("geometry_msgs/msg/TwistStamped", "trajectory_msgs/msg/MultiDOFJointTrajectory"),
    *("std_msgs/msg/Bool", "std_msgs/msg/Empty"),
}


@pytest.fixture(scope="module")
def ros():
    return RosMessages()


@pytest.mark.parametrize("name", sorted({*TOPICS.values(), *COMMANDS}))
def test_the_hash_of_a_type_is_that_of_another_library(ros, name):
    package, _, last = name.split("/")
    assert ros.type_hash(f"{package}/{last}") == kind_named(name).hash_rihs01()


def test_the_hashes_of_services_are_those_of_another_library():
    for ours, theirs in ((commands.SET_BOOL, SetBool), (commands.TRIGGER, Trigger)):
        assert (ours.name, ours.type_hash) == (theirs.get_type_name(), theirs.hash_rihs01())


def test_bytes_are_those_of_another_library(ros):
    header = ros.header(1_234_567, "base_link")
    lens, depth_m = (20.0, 21.0, 1.5, 1.0), np.array([[1.0, np.inf, 2.0, 3.0]] * 3)
    for message in (
        imu(ros, header, (1.0, 2.0, 3.0), (4.0, 5.0, 6.0)),
        odometry(ros, header, "odom", (1, 2, 3), (1.0, 0, 0, 0), (4, 5, 6), (7, 8, 9)),
        battery(ros, header, 12.5, 3.0, 0.5),
        image(ros, header, np.arange(24, dtype=np.uint8).reshape(2, 4, 3), "rgb8"),
        camera_info(ros, header, (4, 3), lens),
        cloud(ros, header, np.arange(12.0).reshape(4, 3)),
        depth_cloud(ros, header, depth_m, lens),
        ros.transforms((header, "odom", (1, 2, 3), (1, 0, 0, 0))),
    ):
        data = ros.encode(message)
        kind = kind_named(message.__msgtype__)
        again = kind.deserialize(data).serialize()
        assert again[4:] == data[4:], message.__msgtype__  # After the name of the encoding.


def test_depth_is_a_row_by_row_cloud_with_gaps(ros):
    lens, depth_m = (2.0, 4.0, 1.0, 0.0), np.array([[2.0, np.inf], [2.0, 4.0]])
    found = depth_cloud(ros, ros.header(0, "camera_down_optical"), depth_m, lens)
    points = np.frombuffer(found.data.tobytes(), np.float32).reshape(2, 2, 3)
    assert (found.height, found.width, found.is_dense) == (2, 2, False)
    assert points[0, 0].tolist() == [-1.0, 0.0, 2.0]
    assert points[1, 1].tolist() == [0.0, 1.0, 4.0]
    assert np.isnan(points[0, 1]).all()


def test_a_velocity_of_the_world_is_turned_into_the_body():
    half = np.sqrt(0.5)
    north = in_body((0.0, 2.0, 1.0), (half, 0.0, 0.0, half))  # The nose looks north.
    assert north == pytest.approx((2.0, 0.0, 1.0))


def test_names_are_those_of_rmw_zenoh():
    kind = Kind(name="std_msgs/msg/String", type_hash="RIHS01_df668c740482bbd48fb39d76a70dfd4b")
    assert kind.dds_name == "std_msgs::msg::dds_::String_"
    assert zenoh_names.topic_key(2, "/chatter", kind) == (
        "2/chatter/std_msgs::msg::dds_::String_/RIHS01_df668c740482bbd48fb39d76a70dfd4b"
    )
    token = zenoh_names.entity_token(2, "q1w2", 11, "MP", "/a/chatter", kind, STATE)
    assert token == (
        "@ros2_lv/2/q1w2/0/11/MP/%/%/aeroscene/%a%chatter/std_msgs::msg::dds_::String_/"
        "RIHS01_df668c740482bbd48fb39d76a70dfd4b/::,10:,:,:,,"
    )
    assert zenoh_names.node_token(2, "q1w2") == "@ros2_lv/2/q1w2/0/0/NN/%/%/aeroscene"
    assert zenoh_names.qos_words(SENSOR) == "2::,5:,:,:,,"
    assert zenoh_names.qos_words(LATCHED) == ":1:,1:,:,:,,"
    number, _, length, sender = struct.unpack("<qqB16s", zenoh_names.attachment(7, b"x" * 16))
    assert (number, length, sender) == (7, 16, b"x" * 16)
    assert zenoh_names.read_attachment(zenoh_names.attachment(7, b"x" * 16)) == (7, b"x" * 16)
