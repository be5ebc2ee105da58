"""What the door costs and opens, and what it says where it cannot."""

import socket
import subprocess
import sys

import pytest

from flightsim.testbench import TestbenchCfg, TestbenchError
from scenarios.ros2.loopback import open_sockets
from scenarios.ros2.topics import Topics
from scenarios.run.cfg import SitlCfg
from scenarios.run.sitl import Sitl
from tests.instances import own_instance
from tests.scenarios.ros2.places import NEEDS_DDS, TRANSPORTS, domain


def configured(**rest):
    bench = TestbenchCfg(speed="max", instance=own_instance(), seed=3)
    return SitlCfg(scene="field", bench=bench, headless_seconds=1.5, **rest)


def test_a_run_without_it_loads_no_library_of_it():
    code = (
        "import sys\n"
        "from scenarios.run.cfg import SitlCfg\n"
        "from scenarios.run.sitl import Sitl\n"
        "Sitl(SitlCfg(scene='field', headless_seconds=0.02), has_network=False).run()\n"
        "print({'cyclonedds', 'zenoh', 'rosbags', 'scenarios.ros2'} & sys.modules.keys())\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "set()\n"


@pytest.mark.parametrize("transport", TRANSPORTS)
def test_a_flight_is_the_same_with_it_and_without_and_no_camera_opens_unheard(transport):
    with Sitl(configured()) as sitl:
        alone = sitl.run().state_hash
    with Sitl(configured(ros2=True, ros2_transport=transport, ros2_domain=domain())) as sitl:
        assert sitl.run().state_hash == alone
        assert sitl.flights[0]._cameras is None


@pytest.mark.skipif(sys.platform != "linux", reason="asks Linux for the interface of a socket")
@pytest.mark.parametrize("transport", TRANSPORTS)
def test_nothing_listens_beyond_loopback(transport):
    before = open_sockets()
    with Sitl(configured(ros2=True, ros2_transport=transport, ros2_domain=domain())):
        opened = open_sockets() - before
        for descriptor in opened:
            each = socket.socket(fileno=descriptor)
            if each.family in {socket.AF_INET, socket.AF_INET6}:
                device = each.getsockopt(socket.SOL_SOCKET, socket.SO_BINDTODEVICE, 16)
                here = each.getsockname()[0]
                assert device.rstrip(b"\0") == b"lo" or here.startswith("127."), here
            each.detach()
    assert opened


@NEEDS_DDS
def test_several_vehicles_have_namespaces_and_one_clock(monkeypatch):
    named, publisher = [], Topics.publisher

    def noted(topics, topic, *rest):
        named.append(topics.name(topic))
        return publisher(topics, topic, *rest)

    monkeypatch.setattr(Topics, "publisher", noted)
    with Sitl(configured(vehicles="2", ros2=True, ros2_domain=domain())) as sitl:
        sitl.run()
    assert named.count("/clock") == 1
    assert {"/imu", "/vehicle_2/imu", "/vehicle_2/camera_down/rgb/image_raw"} <= set(named)


def test_what_is_wrong_is_named(monkeypatch):
    monkeypatch.setenv("ROS_DOMAIN_ID", "many")
    with pytest.raises(TestbenchError, match="ROS_DOMAIN_ID 'many' is no domain; valid: 0 to 232"):
        configured(ros2=True)
    configured(ros2=True, ros2_domain=3)
    monkeypatch.setenv("ROS_DOMAIN_ID", "7")
    assert configured(ros2=True).domain == 7
    with pytest.raises(TestbenchError, match="ros2-domain 233 is out of range"):
        configured(ros2=True, ros2_domain=233)


@pytest.mark.parametrize(
    ("library", "transport", "words"),
    [
        (
            "rosbags.typesys",
            "dds",
            r"ros2 needs rosbags, which is not installed; valid: pip install .aeroscene\[ros2\].",
        ),
        ("cyclonedds.core", "dds", "ros2 needs cyclonedds, which is not installed"),
        ("zenoh", "zenoh", "ros2 needs eclipse-zenoh, which is not installed"),
    ],
)
def test_a_missing_library_is_named(monkeypatch, library, transport, words):
    monkeypatch.setitem(sys.modules, library, None)
    with pytest.raises(TestbenchError, match=words):
        Sitl(configured(ros2=True, ros2_transport=transport, ros2_domain=domain()))


@NEEDS_DDS
def test_endpoints_announce_the_name_and_the_hash_of_their_type_and_not_its_structure():
    from cyclonedds.builtin import BuiltinDataReader, BuiltinTopicDcpsPublication
    from cyclonedds.core import Policy
    from cyclonedds.domain import DomainParticipant

    with Sitl(configured(ros2=True, ros2_domain=domain())):
        participant = DomainParticipant(domain())
        reader = BuiltinDataReader(participant, BuiltinTopicDcpsPublication)
        found = {each.topic_name: each for each in reader.take(100)}
    imu = found["rt/imu"]
    assert (imu.type_name, imu.type_id) == ("sensor_msgs::msg::dds_::Imu_", None)
    assert imu.qos[Policy.Userdata].data.startswith(b"typehash=RIHS01_7d9a00ff")
    assert imu.qos[Policy.Reliability] == Policy.Reliability.BestEffort
    assert found["rt/tf_static"].qos[Policy.Durability] == Policy.Durability.TransientLocal
    assert isinstance(found["rt/tf_static"].qos[Policy.Reliability], Policy.Reliability.Reliable)
