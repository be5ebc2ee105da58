"""Segments, lidar, optical flow and gauges reach every format, and what does not is named."""

import io
import json
import tarfile
from dataclasses import replace

import cv2
import numpy as np
import pyarrow.parquet as pq
import pytest
import pyulog
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

from aeroscene import load_scene
from flightsim.cameras import CLASS_NAMES, Cameras
from flightsim.lidars import LIDARS, Lidar
from flightsim.plant import Plant, PlantCfg
from flightsim.plant.sensing import SENSORS
from flightsim.sensors.optical_flow import OpticalFlowCfg
from flightsim.vehicles.catalogue import AIRFRAMES
from flightsim.world import build_world
from scenarios.recording import Recorder, RunInfo, layout
from scenarios.trial_data.csv_folder import write_csv
from scenarios.trial_data.dataset.frames import FrameDataset
from scenarios.trial_data.dataset.write import add_trial
from scenarios.trial_data.omissions import left_out
from scenarios.trial_data.reading import read_trial
from scenarios.trial_data.rosbag import BAG_TABLES, write_bag
from scenarios.trial_data.tables import GAUGES, TABLES
from scenarios.trial_data.ulog import ULOG_TABLES, write_ulog
from tests.scenarios.in_process import in_process

TICKS = 30


class Flown:
    """A recording of a vehicle that stands, with every sensor, and what the sensors gave."""

    def __init__(self, path):
        self.path = path
        self.scans, self.flow, self.frames = [], [], []
        world = build_world(load_scene("42"), AIRFRAMES["iris"])
        plant = Plant(world, PlantCfg(seed=0, optical_flow=OpticalFlowCfg(is_fitted=True)))
        lidar = Lidar(plant, replace(LIDARS["mid40"], scan_hz=20.0))
        info = RunInfo(scene=world.scene.scene_id, vehicle="iris", seed=0)
        with (
            Cameras(plant, width_px=32, height_px=24, segments=True) as cameras,
            Recorder(
                path,
                scene=world.scene,
                primitives=world.solids,
                airframe=world.airframe,
                info=info,
                has_segments=True,
            ) as recorder,
        ):
            cameras.listen(recorder.first.log_frame)
            lidar.listeners += [recorder.first.log_scan, self.scans.append]
            for _ in range(TICKS):
                plant.advance()
                lidar.update()
                recorder.on_tick(plant)
                self.flow.append(plant.sensors.optical_flow)
            # One that looks ahead, and one that looks for traffic above.
            self.frames = [cameras.render(name) for name in ("forward", "up_left")]


@pytest.fixture(scope="module")
def flown(tmp_path_factory):
    return Flown(tmp_path_factory.mktemp("sensors") / "flight.rrd")


@pytest.fixture(scope="module")
def trial(flown):
    return read_trial(flown.path)


@pytest.fixture(scope="module")
def csv_folder(trial, tmp_path_factory):
    return write_csv(trial, tmp_path_factory.mktemp("csv") / "out")


def image(data):
    return cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)


def test_segments_are_images_beside_the_colours(flown, trial, csv_folder):
    rows = {row["camera"]: row for row in trial.tables["frames"].to_pylist()}
    for frame in flown.frames:
        row = rows[frame.camera]
        for kind, seen in (("classes", frame.class_ids), ("instances", frame.instance_ids)):
            found = image((csv_folder / "images" / row[f"{kind}_file"]).read_bytes())
            np.testing.assert_array_equal(found, seen.astype(found.dtype))
        turn = frame.rotation_enu_from_optical
        np.testing.assert_allclose(row["position_east_m"], frame.position_enu_m[0], atol=1e-5)
        assert turn.shape == (3, 3)


def test_labels_say_what_the_numbers_mean(flown, trial):
    labels = trial.tables["labels"].to_pylist()
    classes = {row["number"]: row["name"] for row in labels if row["image"] == "classes"}
    assert classes == dict(CLASS_NAMES)
    objects = {row["number"]: row["name"] for row in labels if row["image"] == "instances"}
    assert set(np.unique(flown.frames[0].instance_ids.astype(np.uint16))) <= set(objects)


def test_scans_are_points_on_the_vehicle(flown, trial, csv_folder):
    rows = trial.tables["scans"].to_pylist()
    assert [row["time_us"] for row in rows] == [scan.time_us for scan in flown.scans]
    assert rows
    for row, scan in zip(rows, flown.scans, strict=True):
        points = np.load(csv_folder / "scans" / row["points_file"])
        np.testing.assert_array_equal(points, scan.points_flu_m.astype(np.float32))
        assert row["points"] == len(points) > 100


def test_optical_flow_is_every_sample_of_the_sensor(flown, trial):
    expected = list({sample.time_us: sample for sample in flown.flow if sample.integration_us})
    table = trial.tables["optical_flow"]
    assert table["time_us"].to_pylist() == expected
    last = table.to_pylist()[-1]
    sample = flown.flow[-1]
    found = [last[f"flow_{axis}_rad"] for axis in ("forward", "right")]
    np.testing.assert_array_equal(found, sample.flow_frd_rad)
    found = [last[f"gyro_{axis}_rad"] for axis in ("forward", "right", "down")]
    np.testing.assert_array_equal(found, sample.gyro_frd_rad)
    assert (last["quality"], last["distance_m"]) == (sample.quality, sample.distance_m)


def test_every_gauge_of_a_sensor_has_a_column():
    entities = {entity for entity, _ in GAUGES.values()}
    assert {layout.sensor(sensor.setting) for sensor in SENSORS if sensor.gauge} <= entities


def test_gauges_are_sampled_at_10_hz(trial):
    gauges = trial.tables["gauges"]
    assert np.diff(gauges["time_us"].to_numpy()).tolist() == [100_000] * (TICKS // 5 - 1)
    assert 12.0 < gauges["battery_voltage_v"][0].as_py() < 13.0


def test_the_dataset_has_segments_and_scans_in_its_shard(flown, trial, tmp_path):
    add_trial(tmp_path, trial)
    shard = (tmp_path / "images" / "flight.tar").read_bytes()
    for table, kind in (("frames", "classes"), ("frames", "instances"), ("scans", "points")):
        for row in pq.read_table(tmp_path / table).to_pylist():
            start, n = row[f"{kind}_offset"], row[f"{kind}_bytes"]
            files = (*trial.pictures, *trial.scans)
            (data,) = (each.data for each in files if each.file == row[f"{kind}_file"])
            assert shard[start : start + n] == data
    with tarfile.open(fileobj=io.BytesIO(shard)) as tar:
        names = tar.getnames()
    assert "flight_000000_lidar.points.npy" in names
    assert any(name.endswith("_forward.instances.png") for name in names)
    frame = FrameDataset(tmp_path, camera="forward", imu_rows=1)[0]
    seen = flown.frames[0]
    np.testing.assert_array_equal(frame.classes.numpy()[0], seen.class_ids)
    np.testing.assert_array_equal(frame.instances.numpy()[0], seen.instance_ids.astype(np.uint16))


def test_the_ulog_has_flow_battery_and_distance(trial, tmp_path):
    log = pyulog.ULog(str(write_ulog(trial, tmp_path / "flight.ulg")))
    flow = log.get_dataset("sensor_optical_flow").data
    table = trial.tables["optical_flow"]
    np.testing.assert_array_equal(flow["timestamp"], table["time_us"])
    np.testing.assert_allclose(flow["pixel_flow[0]"], table["flow_forward_rad"], rtol=1e-6)
    np.testing.assert_array_equal(flow["integration_timespan_us"], table["integration_us"])
    np.testing.assert_array_equal(flow["quality"], table["quality"])
    battery = log.get_dataset("battery_status").data
    gauges = trial.tables["gauges"]
    np.testing.assert_allclose(battery["voltage_v"], gauges["battery_voltage_v"], rtol=1e-6)
    assert 0.9 < battery["remaining"][0] <= 1.0


@pytest.fixture(scope="module")
def bag(trial, tmp_path_factory):
    folder = write_bag(trial, tmp_path_factory.mktemp("bag") / "flight")
    topics: dict[str, list] = {}
    with (folder / "flight.mcap").open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        for _, channel, message, decoded in reader.iter_decoded_messages():
            topics.setdefault(channel.topic, []).append((message.log_time // 1000, decoded))
    return topics


def test_the_bag_has_clouds_flow_labels_and_segments(flown, trial, bag):
    scan, (time_us, cloud) = flown.scans[0], bag["/lidar/points"][0]
    assert (time_us, cloud.header.frame_id) == (scan.time_us, "base_link")
    points = np.frombuffer(cloud.data, "<f4").reshape(-1, 3)
    np.testing.assert_array_equal(points, scan.points_flu_m.astype(np.float32))
    assert len(bag["/optical_flow"]) == len(trial.tables["optical_flow"])
    assert bag["/optical_flow"][-1][1].quality == flown.flow[-1].quality
    names = {each.class_id: each.class_name for each in bag["/labels/classes"][0][1].class_map}
    assert names == dict(CLASS_NAMES)
    seen = flown.frames[0]
    (_, classes), (_, objects) = (
        bag[f"/camera_forward/{kind}/image_raw"][0] for kind in ("classes", "instances")
    )
    assert (classes.encoding, objects.encoding) == ("mono8", "mono16")
    found = np.frombuffer(objects.data, "<u2").reshape(seen.instance_ids.shape)
    np.testing.assert_array_equal(found, seen.instance_ids.astype(np.uint16))
    assert bag["/battery"][0][1].voltage == pytest.approx(12.6, abs=0.2)


def test_what_a_format_leaves_out_is_named(flown, trial, tmp_path, capsys):
    assert left_out(trial) == []
    assert left_out(trial, BAG_TABLES) == []
    lacking = left_out(trial, ULOG_TABLES)
    assert lacking == ["camera images", "labels of segments", "lidar scans"]
    args = ("export-trial", flown.path, "--to", "ulog", "--out")
    status, out, _ = in_process(capsys, *args, tmp_path / "a.ulg")
    assert status == 0
    assert f"Left out of ulog: {', '.join(lacking)}" in out
    _, out, _ = in_process(capsys, *args, tmp_path / "b.ulg", "--json")
    assert json.loads(out)["left_out"] == lacking


def test_a_part_of_a_recording_that_no_table_knows_is_named_by_its_path(trial):
    others = frozenset({"sensors/sonar", "world/landing_map/grid", "error/position"})
    told = left_out(replace(trial, others=others))
    assert told == ["sensors/sonar", "the pilot's landing map"]


def test_tables_that_formats_hold_are_tables():
    assert set(TABLES) >= ULOG_TABLES
    assert set(TABLES) == BAG_TABLES
