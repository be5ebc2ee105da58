"""Each format, read back by a library that did not write it."""

import json
import subprocess
import sys

import numpy as np
import pyarrow.csv
import pytest
import pyulog
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags import rosbag2
from scipy.spatial.transform import Rotation

from scenarios.trial_data.csv_folder import write_csv
from scenarios.trial_data.reading import TrialDataError, read_trial
from scenarios.trial_data.rosbag import write_bag
from scenarios.trial_data.tables import TABLES
from scenarios.trial_data.ulog import write_ulog
from tests.scenarios.recording.conftest import PLAN_ENU_M

ENU, FLU, WXYZ = ("east", "north", "up"), ("forward", "left", "up"), ("w", "x", "y", "z")
NED_FROM_ENU = np.array([(0.0, 1.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, -1.0)])
FRD_FROM_FLU = np.diag([1.0, -1.0, -1.0])


@pytest.fixture(scope="module")
def aligned(flight):
    rows = flight.history[4::5]
    return rows[rows["position_est_enu_m"].any(axis=1)]


def test_csv_holds_every_number(trial, tmp_path):
    out = write_csv(trial, tmp_path / "csv")
    for name, table in trial.tables.items():
        read = pyarrow.csv.read_csv(out / f"{name}.csv")
        assert read.num_rows == table.num_rows
        for column in TABLES[name]:
            if column.unit:
                found = np.array(read[column.name].to_pylist(), dtype=float)
                np.testing.assert_array_equal(found, table[column.name].to_numpy())
    schema = json.loads((out / "schema.json").read_text())
    units = {column["name"]: column["unit"] for column in schema["tables"]["states"]}
    assert (units["velocity_true_east_mps"], units["attitude_true_w"]) == ("m/s", "")
    frame = trial.tables["frames"].to_pylist()[0]
    (picture,) = [each for each in trial.pictures if each.file == frame["rgb_file"]]
    assert (out / "images" / frame["rgb_file"]).read_bytes() == picture.data
    with pytest.raises(TrialDataError, match="is there already; valid: a name that is free"):
        write_csv(trial, out)
    assert list(tmp_path.iterdir()) == [out]


def test_pyulog_reads_the_ulog(flight, aligned, trial, tmp_path):
    log = pyulog.ULog(str(write_ulog(trial, tmp_path / "flight.ulg")))
    assert log.msg_info_dict["aeroscene_scene"] == "42"

    def columns(topic, *fields):
        data = log.get_dataset(topic).data
        return data["timestamp"], np.column_stack([data[field] for field in fields])

    xyz = [f"xyz[{k}]" for k in range(3)]
    q = [f"q[{k}]" for k in range(4)]
    for suffix, whose, rows in (
        ("", "est", aligned),
        ("_groundtruth", "true", flight.history[4::5]),
    ):
        times, found = columns(f"vehicle_local_position{suffix}", *"xyz", "vx", "vy", "vz")
        position, velocity = rows[f"position_{whose}_enu_m"], rows[f"velocity_{whose}_enu_mps"]
        expected = np.hstack([position @ NED_FROM_ENU.T, velocity @ NED_FROM_ENU.T])
        np.testing.assert_array_equal(times, rows["time_us"])
        np.testing.assert_allclose(found, expected, atol=1e-4)
        quats = columns(f"vehicle_attitude{suffix}", *q)[1]
        turns = Rotation.from_quat(rows[f"quat_{whose}_wxyz"], scalar_first=True).as_matrix()
        np.testing.assert_allclose(
            Rotation.from_quat(quats, scalar_first=True).as_matrix(),
            NED_FROM_ENU @ turns @ FRD_FROM_FLU,
            atol=1e-5,
        )
        rates = columns(f"vehicle_angular_velocity{suffix}", *xyz)[1]
        expected = rows[f"angular_rate_{whose}_flu_radps"] @ FRD_FROM_FLU
        np.testing.assert_allclose(rates, expected, atol=1e-5)
    gyro = columns("sensor_combined", *(f"gyro_rad[{k}]" for k in range(3)))[1]
    np.testing.assert_allclose(gyro, flight.history["gyro_flu_radps"] @ FRD_FROM_FLU, atol=1e-5)
    force = columns("sensor_combined", *(f"accelerometer_m_s2[{k}]" for k in range(3)))[1]
    np.testing.assert_allclose(force, flight.history["accel_flu_mps2"] @ FRD_FROM_FLU, atol=1e-4)
    outputs = columns("actuator_outputs", *(f"output[{k}]" for k in range(4)))[1]
    np.testing.assert_allclose(outputs, flight.history["rotor_command_radps"], rtol=1e-6)
    assert "battery low" in [message.message for message in log.logged_messages]


@pytest.fixture(scope="module")
def bag_folder(trial, tmp_path_factory):
    return write_bag(trial, tmp_path_factory.mktemp("bag") / "flight")


@pytest.fixture(scope="module")
def bag(bag_folder):
    """Topics of a bag, read by the libraries of MCAP's makers: times in us, and messages."""
    topics: dict[str, list] = {}
    with (bag_folder / "flight.mcap").open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        for _, channel, message, decoded in reader.iter_decoded_messages():
            topics.setdefault(channel.topic, []).append((message.log_time // 1000, decoded))
    return topics


def test_the_folder_is_a_bag_whose_fixed_transforms_reach_late_listeners(bag_folder, bag):
    assert sorted(path.name for path in bag_folder.iterdir()) == ["flight.mcap", "metadata.yaml"]
    with rosbag2.Reader(bag_folder) as reader:
        counts = {each.topic: each.msgcount for each in reader.connections}
        durability = {c.topic: c.ext.offered_qos_profiles[0].durability for c in reader.connections}
    assert counts == {topic: len(messages) for topic, messages in bag.items()}
    assert durability["/tf_static"].name == "TRANSIENT_LOCAL"
    assert durability["/imu"].name == "VOLATILE"


def stamps_us(messages):
    return [1_000_000 * m.header.stamp.sec + m.header.stamp.nanosec // 1000 for _, m in messages]


def xyz(vector):
    return (vector.x, vector.y, vector.z)


def test_odometry_is_the_pose_in_the_world_and_the_velocity_in_the_body(flight, aligned, bag):
    for topic, whose, world, body, rows in (
        ("true", "true", "map", "base_link_true", flight.history[4::5]),
        ("estimate", "est", "odom", "base_link", aligned),
    ):
        messages = bag[f"/odometry/{topic}"]
        assert stamps_us(messages) == [time for time, _ in messages] == rows["time_us"].tolist()
        found = [message for _, message in messages]
        assert {m.header.frame_id for m in found} == {world}
        assert {m.child_frame_id for m in found} == {body}
        position = [xyz(m.pose.pose.position) for m in found]
        np.testing.assert_allclose(position, rows[f"position_{whose}_enu_m"], atol=1e-6)
        turns = Rotation.from_quat(
            [(*xyz(m.pose.pose.orientation), m.pose.pose.orientation.w) for m in found]
        )
        quats = Rotation.from_quat(rows[f"quat_{whose}_wxyz"], scalar_first=True)
        assert (turns.inv() * quats).magnitude().max() < 1e-5
        velocity = [xyz(m.twist.twist.linear) for m in found]
        expected = quats.inv().apply(rows[f"velocity_{whose}_enu_mps"])
        np.testing.assert_allclose(velocity, expected, atol=1e-5)
        rates = [xyz(m.twist.twist.angular) for m in found]
        np.testing.assert_allclose(rates, rows[f"angular_rate_{whose}_flu_radps"], atol=1e-9)


def test_imu_and_motors_are_whole(flight, bag):
    history = flight.history
    imu = bag["/imu"]
    assert stamps_us(imu) == history["time_us"].tolist()
    force = [xyz(m.linear_acceleration) for _, m in imu]
    np.testing.assert_array_equal(force, history["accel_flu_mps2"])
    rates = [xyz(m.angular_velocity) for _, m in imu]
    np.testing.assert_array_equal(rates, history["gyro_flu_radps"])
    assert imu[0][1].orientation_covariance[0] == -1.0
    command = [m.velocity for _, m in bag["/motors/command"]]
    np.testing.assert_array_equal(command, history["rotor_command_radps"])


def test_images_come_with_their_lens_and_frame(flight, bag):
    for camera in ("forward", "down"):
        frames = [frame for frame in flight.frames if frame.camera == camera]
        depths = bag[f"/camera_{camera}/depth/image_raw"]
        colours = bag[f"/camera_{camera}/rgb/image_raw"]
        lenses = bag[f"/camera_{camera}/rgb/camera_info"]
        assert stamps_us(depths) == stamps_us(lenses) == [frame.time_us for frame in frames]
        for frame, (_, depth), (_, rgb), (_, lens) in zip(
            frames, depths, colours, lenses, strict=True
        ):
            shape = frame.depth_m.shape
            assert (depth.encoding, depth.height, depth.width) == ("16UC1", *shape)
            assert depth.header.frame_id == f"camera_{camera}_optical"
            metres = np.frombuffer(depth.data, "<u2").reshape(shape) / 1000.0
            near = np.isfinite(frame.depth_m) & (frame.depth_m < 65.0)
            np.testing.assert_allclose(metres[near], frame.depth_m[near], atol=6e-4)
            assert (rgb.encoding, rgb.step) == ("rgb8", 3 * shape[1])
            found = np.frombuffer(rgb.data, np.uint8).reshape(*shape, 3)
            assert np.abs(found.astype(float) - frame.rgb).mean() < 10.0
            expected = (frame.fx, 0.0, frame.cx, 0.0, frame.fy, frame.cy, 0.0, 0.0, 1.0)
            np.testing.assert_allclose(lens.k, expected, rtol=1e-6)


def test_transforms_place_the_cameras(flight, bag):
    (_, static), *_ = bag["/tf_static"]
    moving = {}
    for time, message in bag["/tf"]:
        for each in message.transforms:
            moving[time, each.child_frame_id] = each
    frame = flight.frames[-1]
    mount = next(
        t for t in static.transforms if t.child_frame_id == f"camera_{frame.camera}_optical"
    )
    body = moving[frame.time_us, "base_link_true"]
    assert (mount.header.frame_id, body.header.frame_id) == ("base_link", "map")

    def pose(t):
        q = t.transform.rotation
        return Rotation.from_quat((q.x, q.y, q.z, q.w)), np.array(xyz(t.transform.translation))

    (turn, at), (mount_turn, mount_at) = pose(body), pose(mount)
    np.testing.assert_allclose(at + turn.apply(mount_at), frame.position_enu_m, atol=1e-5)
    found = (turn * mount_turn).as_matrix()
    np.testing.assert_allclose(found, frame.rotation_enu_from_optical, atol=1e-5)


def test_a_plan_is_a_path_with_times(bag):
    _, plan = bag["/plan"][0]
    assert [xyz(pose.pose.position) for pose in plan.poses] == list(PLAN_ENU_M)
    assert [pose.header.stamp.sec for pose in plan.poses] == [0, 1, 2]
    assert "touched object 7" in bag["/verdict"][0][1].data


WITHOUT_ROSBAGS = """
import sys
sys.modules["rosbags"] = None
from scenarios.cli.main import main
sys.exit(main(sys.argv[1:]))
"""


def test_without_the_extra_the_way_to_it_is_told(flight, tmp_path):
    args = ["export-trial", str(flight.path), "--to", "mcap", "--out", str(tmp_path / "bag")]
    done = subprocess.run(
        [sys.executable, "-c", WITHOUT_ROSBAGS, *args], capture_output=True, text=True, check=False
    )
    assert done.returncode == 2
    assert done.stderr == (
        "aeroscene export-trial: error: mcap needs rosbags, which is not installed; "
        "valid: pip install 'aeroscene[ros]'\n"
    )
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("write", [write_ulog, write_bag])
def test_a_summary_is_refused_by_formats_of_states(flight, tmp_path, write):
    trial = read_trial(flight.path)
    tables = {**trial.tables, "states": trial.tables["states"].slice(0, 0)}
    bare = type(trial)(name="bare", tables=tables, pictures=(), mounts={})
    with pytest.raises(TrialDataError, match=r"'bare' holds no states, which .* needs"):
        write(bare, tmp_path / "out")
    assert not list(tmp_path.iterdir())
