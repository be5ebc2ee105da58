"""Arm and land as services; and partners that send rubbish, or go."""

import math
import struct
import time

import pytest
from ros2_pyterfaces.cyclone.std_srvs.srv import SetBool, Trigger

from autonomy.types import yaw_of
from flightsim.testbench import TestbenchCfg
from scenarios.ros2.messages import RosMessages
from scenarios.ros2.topics import Topics
from scenarios.ros2.transport import STATE
from scenarios.run.cfg import SitlCfg
from scenarios.run.sitl import Sitl
from tests.instances import own_instance
from tests.scenarios.ros2.kinds import kind_named
from tests.scenarios.ros2.places import NEEDS_DDS, TRANSPORTS, domain, router_port

_HALF = math.sqrt(0.5)
GOAL = {
    "__typename": "trajectory_msgs/msg/MultiDOFJointTrajectory",
    "header": {
        "__typename": "std_msgs/msg/Header",
        "stamp": {"__typename": "builtin_interfaces/msg/Time", "sec": 0, "nanosec": 0},
        "frame_id": "map",
    },
    "joint_names": ["base_link"],
    "points": [
        {
            "__typename": "trajectory_msgs/msg/MultiDOFJointTrajectoryPoint",
            "transforms": [
                {
                    "__typename": "geometry_msgs/msg/Transform",
                    "translation": {
                        "__typename": "geometry_msgs/msg/Vector3",
                        "x": 2.0,
                        "y": -1.0,
                        "z": 3.0,
                    },
                    "rotation": {
                        "__typename": "geometry_msgs/msg/Quaternion",
                        "x": 0.0,
                        "y": 0.0,
                        "z": _HALF,
                        "w": _HALF,
                    },
                }
            ],
            "velocities": [],
            "accelerations": [],
            "time_from_start": {
                "__typename": "builtin_interfaces/msg/Duration",
                "sec": 0,
                "nanosec": 0,
            },
        }
    ],
}
"""East, south and above of the start, with the nose to the north."""


def configured(transport):
    bench = TestbenchCfg(speed="max", instance=own_instance(), seed=3)
    return SitlCfg(
        scene="field", bench=bench, ros2=True, ros2_transport=transport, ros2_domain=domain()
    )


def reply_to(sitl, ask, deadline_s=20.0):
    """What `ask` returns first, while the simulation goes on."""
    end_s = time.monotonic() + deadline_s
    while time.monotonic() < end_s:
        sitl.bench.simulator.step()
        if (found := ask()) is not None:
            return found
        time.sleep(0.001)
    raise AssertionError("no reply")


def dds_client(service, kind):
    """Sends requests and takes replies as rmw_cyclonedds_cpp does: the caller comes first."""
    from cyclonedds.core import Policy, Qos
    from cyclonedds.domain import DomainParticipant
    from cyclonedds.idl import make_idl_struct, types
    from cyclonedds.pub import DataWriter
    from cyclonedds.sub import DataReader
    from cyclonedds.topic import Topic

    participant = DomainParticipant(domain())
    qos = Qos(Policy.Reliability.Reliable(0), Policy.History.KeepLast(10))
    caller = {"client": types.uint64, "number": types.int64}
    package, _, name = kind.get_type_name().split("/")
    field = {"SetBool": {"data": bool}, "Trigger": {"nothing": types.uint8}}[name]
    request = make_idl_struct("Q", f"{package}.srv.dds_.{name}_Request_", {**caller, **field})
    fields = {**caller, "success": bool, "message": str}
    response = make_idl_struct("R", f"{package}.srv.dds_.{name}_Response_", fields)
    writer = DataWriter(participant, Topic(participant, f"rq{service}Request", request), qos=qos)
    reader = DataReader(participant, Topic(participant, f"rr{service}Reply", response), qos=qos)

    def call(sitl, *values):
        both = (writer.get_matched_subscriptions, reader.get_matched_publications)
        reply_to(sitl, lambda: all(each() for each in both) or None)
        writer.write(request(0x1122334455667788, 42, *values))
        reply = reply_to(sitl, lambda: next(iter(reader.take()), None))
        assert (reply.client, reply.number) == (0x1122334455667788, 42)
        return reply

    return call


def zenoh_client(service, kind):
    """Asks as rmw_zenoh does: a query with the request, its number and the client's id."""
    import zenoh

    config = zenoh.Config()
    config.insert_json5("connect/endpoints", f'["tcp/127.0.0.1:{router_port()}"]')
    config.insert_json5("scouting/multicast/enabled", "false")
    session = zenoh.open(config)
    package, _, name = kind.get_type_name().split("/")
    key = f"{domain()}{service}/{package}::srv::dds_::{name}_/{kind.hash_rihs01()}"

    def call(sitl, *values):
        sent = struct.pack("<qqB16s", 42, 1, 16, b"client")
        request = kind.Request(*values).serialize()
        queue = session.get(key, payload=request, attachment=sent, timeout=20.0)
        reply = reply_to(sitl, queue.try_recv).ok
        number, _, length, client = struct.unpack("<qqB16s", reply.attachment.to_bytes())
        assert (number, length, client.rstrip(b"\0")) == (42, 16, b"client")
        return kind.Response.deserialize(reply.payload.to_bytes())

    return call


@pytest.mark.parametrize("transport", TRANSPORTS)
def test_arm_and_land_are_services_that_say_how_it_went(transport):
    client = dds_client if transport == "dds" else zenoh_client
    nothing = (0,) if transport == "dds" else ()
    with Sitl(configured(transport)) as sitl:
        arm, land = client("/arm", SetBool), client("/land", Trigger)
        sitl.bench.run(2.0)
        reply = arm(sitl, True)
        assert (reply.success, reply.message) == (True, "accepted")
        assert sitl.bench.autopilot.is_armed
        reply = land(sitl, *nothing)
        assert (reply.success, reply.message) == (True, "accepted")
        assert sitl.bench.autopilot.mode.value == "Land"


@NEEDS_DDS
def test_rubbish_and_partners_that_go_change_nothing_of_a_flight(caplog):
    from cyclonedds.domain import DomainParticipant

    from scenarios.ros2.dds import DdsTransport

    def fly(disturb):
        with Sitl(configured("dds")) as sitl:
            for second in range(4):
                disturb(sitl, second)
                sitl.bench.run(1.0)
            return sitl.flights[0].log.state_hash()

    quiet = fly(lambda *_: None)
    ros, gone = RosMessages(), []

    def rubbish(_, second):
        stranger = DdsTransport.__new__(DdsTransport)
        stranger.__dict__.update(
            _participant=DomainParticipant(domain()), _endpoints=[], _types=types_of(ros)
        )
        topics = Topics(stranger, ros)
        for topic, kind in (
            ("cmd_vel", "std_msgs/String"),  # Not the type of this topic.
            ("cmd_vel", "geometry_msgs/TwistStamped"),
            ("command/arm", "std_msgs/Bool"),
            ("command/trajectory", "trajectory_msgs/MultiDOFJointTrajectory"),
        ):
            outlet = stranger.outlet(topics.name(topic), topics.kind(kind), STATE)
            time.sleep(0.05)
            for data in (b"\0\1\0\0", b"\0\1\0\0" + bytes([255]) * 64, b"\xff" * 40):
                outlet.send(data)
        gone.append(second)
        del stranger  # Without a word.

    assert fly(rubbish) == quiet
    assert gone == [0, 1, 2, 3]


def types_of(ros):
    from scenarios.ros2.idl import IdlTypes

    return IdlTypes(ros.store.fielddefs)


def test_a_trajectory_is_followed_by_its_first_point():
    arm = kind_named("std_msgs/msg/Bool")(data=True)
    goal = kind_named("trajectory_msgs/msg/MultiDOFJointTrajectory").from_core_message(GOAL)
    with Sitl(configured("zenoh")) as sitl:
        publish = zenoh_publishers()
        sitl.bench.run(2.0)
        for k in range(200):
            publish("/command/trajectory", goal)
            if k < 10:
                publish("/command/arm", arm)
            time.sleep(0.005)
            sitl.bench.run(0.06)
        truth = sitl.bench.plant.truth
    assert truth.position_enu_m == pytest.approx((2.0, -1.0, 3.0), abs=0.3)
    assert yaw_of(truth.quat_wxyz) == pytest.approx(math.pi / 2, abs=0.1)


def test_values_that_are_no_command_are_named_once_and_dropped(caplog):
    twist = kind_named("geometry_msgs/msg/TwistStamped")()
    twist.header.frame_id = "camera"
    not_finite = kind_named("geometry_msgs/msg/TwistStamped")()
    not_finite.twist.linear.x = float("nan")
    empty = kind_named("trajectory_msgs/msg/MultiDOFJointTrajectory")()
    with Sitl(configured("zenoh")) as sitl:
        publish = zenoh_publishers()
        time.sleep(0.5)
        for _ in range(3):
            publish("/cmd_vel", twist)
            publish("/cmd_vel", not_finite)
            publish("/command/trajectory", empty)
            publish("/cmd_vel", None)
            time.sleep(0.1)
            sitl.bench.run(0.5)
        assert sitl.bench.autopilot.mode.value == "Hold"
    lines = [record.getMessage() for record in caplog.records]
    assert len([line for line in lines if line.startswith("ROS 2: ")]) == 4
    assert "ROS 2: cmd_vel in frame 'camera' is dropped; valid: base_link, map, odom" in lines
    assert "ROS 2: cmd_vel with a value that is not finite is dropped" in lines
    assert "ROS 2: trajectory without a finite first point is dropped" in lines


def zenoh_publishers():
    import zenoh

    config = zenoh.Config()
    config.insert_json5("connect/endpoints", f'["tcp/127.0.0.1:{router_port()}"]')
    config.insert_json5("scouting/multicast/enabled", "false")
    session = zenoh.open(config)

    def publish(topic, message):
        kind = kind_named(
            "geometry_msgs/msg/TwistStamped" if message is None else message.get_type_name()
        )
        package, folder, last = kind.get_type_name().split("/")
        key = f"{domain()}{topic}/{package}::{folder}::dds_::{last}_/{kind.hash_rihs01()}"
        session.put(key, b"rubbish" if message is None else message.serialize())

    return publish
