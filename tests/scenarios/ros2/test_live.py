"""What a process of its own hears of a run, and how it flies; decoded by another library."""

import pickle
import select
import subprocess
import sys
from contextlib import contextmanager

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

from flightsim.testbench import TestbenchCfg
from scenarios.run.cfg import SitlCfg
from scenarios.run.sitl import Sitl
from scenarios.trial_data.reading import read_trial
from scenarios.trial_data.rosbag import write_bag
from tests.instances import own_instance
from tests.scenarios.ros2.kinds import TOPICS
from tests.scenarios.ros2.places import NEEDS_DDS, TRANSPORTS, domain, router_port
from tests.thorough import THOROUGH

COMPARED = (
    *("/odometry/true", "/odometry/estimate", "/imu", "/battery", "/lidar/points"),
    *(
        f"/camera_down/{part}"
        for part in ("depth/image_raw", "depth/camera_info", "rgb/camera_info")
    ),
)
"""Topics whose messages have a header and are in a bag as they are."""


_PATIENCE_S = 300.0
"""Wall time in which the listener decodes what it has heard, on a busy machine too."""


@contextmanager
def listening(transport, out, *rest):
    """A listener that has found the run, and its output once the run has ended."""
    command = [sys.executable, "-m", "tests.scenarios.ros2.listener", transport, str(domain())]
    command += [str(router_port()), str(out), *rest]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        try:
            assert process.stdout.readline() == b"ready\n"
            yield process
            process.stdin.close()
            assert process.wait(_PATIENCE_S) == 0
        finally:
            process.kill()


def configured(folder, transport, speed, **rest):
    lidar = folder / "few.csv"
    shots = "".join(f"{k},-{10 + k % 60}\n" for k in range(90))
    lidar.write_text("azimuth_deg,elevation_deg\n" + shots)
    bench = TestbenchCfg(
        speed=speed, instance=own_instance(), lidar=str(lidar), camera_size="64x48", seed=3
    )
    return SitlCfg(
        scene="field",
        bench=bench,
        ros2=True,
        ros2_transport=transport,
        ros2_domain=domain(),
        **rest,
    )


def ns(stamp):
    return 1_000_000_000 * stamp["sec"] + stamp["nanosec"]


@pytest.mark.parametrize("transport", TRANSPORTS)
def test_a_node_flies_by_velocities_and_hears_all_that_is_recorded(tmp_path, transport):
    record, out = tmp_path / "flight.rrd", tmp_path / "heard"
    cfg = configured(tmp_path, transport, 2.0, record=record, headless_seconds=40.0)
    with Sitl(cfg) as sitl, listening(transport, out, "fly") as listener:
        sitl.run(lambda: bool(select.select([listener.stdout], [], [], 0)[0]))  # It has landed.
        flown, truth = sitl.bench.autopilot, sitl.bench.plant.truth
    assert (flown.is_armed, flown.landed_state.value) == (False, "on ground")
    assert 2.0 < truth.position_enu_m[0] < 12.0
    heard = pickle.loads(out.read_bytes())
    assert [topic for topic in TOPICS if not heard[topic]] == []
    forward(heard["/clock"])
    assert [each["data"] for each in heard["/mode"]] == ["Hold", "Offboard", "Land", "Hold"]
    bag = bag_of(record, tmp_path / "bag", heard)
    for topic in COMPARED:
        recorded = {time_of(message): message for message in bag[topic]}
        stamped = {ns(each["header"]["stamp"]): each for each in heard[topic]}
        both = sorted(recorded.keys() & stamped.keys())
        assert len(both) >= 5, topic
        for time in both:
            require_equal(stamped[time], recorded[time], topic)
    fixed = {each.child_frame_id: each for each in bag["/tf_static"][0].transforms}
    assert len(fixed) == 3
    for each in heard["/tf_static"][0]["transforms"]:
        require_equal(each, fixed[each["child_frame_id"]], "/tf_static")
    colours = {time_of(message): message for message in bag["/camera_down/rgb/image_raw"]}
    for image in heard["/camera_down/rgb/image_raw"][::5]:
        of_jpeg = np.frombuffer(colours[ns(image["header"]["stamp"])].data, np.uint8)
        assert np.abs(np.array(image["data"], float) - of_jpeg).mean() < 10.0


@pytest.mark.parametrize(
    ("transport", "speed"),
    [
        *(pytest.param("dds", speed, marks=(NEEDS_DDS, THOROUGH)) for speed in (0.5, 4.0)),
        pytest.param("dds", "max", marks=NEEDS_DDS),
        ("zenoh", "max"),
    ],
)
def test_the_clock_only_goes_forward_at_every_speed(tmp_path, transport, speed):
    out, until_s = tmp_path / "heard", 2.0 if speed == 0.5 else 8.0
    cfg = configured(tmp_path, transport, speed, headless_seconds=until_s)
    with Sitl(cfg) as sitl, listening(transport, out):
        sitl.run()
    heard = pickle.loads(out.read_bytes())
    clock = forward(heard["/clock"])
    assert clock[-1] == pytest.approx(until_s, abs=0.5)


def forward(messages):
    """Times of the clock in s, none of which is earlier than the one before."""
    clock = np.array([1e-9 * ns(each["clock"]) for each in messages])
    assert len(clock) > 50
    assert np.all(np.diff(clock) > 0.0)
    return clock


def bag_of(record, folder, heard):
    """Messages of the recording as a bag, of times that were heard, read by the makers of MCAP."""
    topics, factory = {}, DecoderFactory()
    times = {
        topic: {ns(each["header"]["stamp"]) for each in found if "header" in each}
        for topic, found in heard.items()
    }
    (mcap,) = write_bag(read_trial(record), folder).glob("*.mcap")
    with mcap.open("rb") as file:
        for schema, channel, message in make_reader(file).iter_messages():
            if channel.topic == "/tf_static" or message.log_time in times.get(channel.topic, ()):
                decode = factory.decoder_for(channel.message_encoding, schema)
                topics.setdefault(channel.topic, []).append(decode(message.data))
    return topics


def time_of(message):
    return 1_000_000_000 * message.header.stamp.sec + message.header.stamp.nanosec


def require_equal(heard, recorded, where):
    """A message that was heard is one of the bag, up to the single precision of recordings."""
    if isinstance(heard, dict):
        for name, value in heard.items():
            if name != "__typename":
                require_equal(value, getattr(recorded, name), f"{where}.{name}")
    elif heard and isinstance(heard, (list, tuple)) and isinstance(heard[0], dict):
        assert len(heard) == len(recorded), where
        for each, other in zip(heard, recorded, strict=True):
            require_equal(each, other, where)
    elif isinstance(heard, (str, bool)):
        assert heard == recorded, where
    else:
        recorded = list(recorded) if isinstance(recorded, (bytes, bytearray)) else recorded
        np.testing.assert_allclose(heard, recorded, rtol=1e-5, atol=2e-5, err_msg=where)
