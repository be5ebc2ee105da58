"""A dataset of trials: whole, resumable, and as torch reads it."""

import errno
import io
import json
import os
import shutil
import subprocess
import sys
import tarfile
from dataclasses import replace

import cv2
import numpy as np
import pyarrow.parquet as pq
import pytest
import torch

from scenarios.trial_data.dataset.frames import FrameDataset
from scenarios.trial_data.dataset.write import DATASET_TABLES, add_trial, has_trial
from scenarios.trial_data.reading import TrialDataError
from tests.full_disk import files_end_after
from tests.scenarios.in_process import in_process


@pytest.fixture(scope="module")
def folder(trial, tmp_path_factory):
    folder = tmp_path_factory.mktemp("dataset")
    add_trial(folder, trial)
    return folder


def test_tables_come_back_with_their_units(trial, folder):
    described = json.loads((folder / "schema.json").read_text())["tables"]
    for name, table in trial.tables.items():
        read = pq.read_table(folder / name)
        assert read.column_names == [column.name for column in DATASET_TABLES[name]]
        assert [column["name"] for column in described[name]] == read.column_names
        for column in table.column_names:
            np.testing.assert_array_equal(read[column].to_pylist(), table[column].to_pylist())
    field = pq.read_schema(folder / "states" / "flight.parquet").field("velocity_true_up_mps")
    assert field.metadata[b"unit"] == b"m/s"


def test_places_in_the_shard_are_those_of_the_images(trial, folder):
    data = {picture.file: picture.data for picture in trial.pictures}
    shard = (folder / "images" / "flight.tar").read_bytes()
    frames = pq.read_table(folder / "frames").to_pylist()
    for frame in frames:
        for kind in ("rgb", "depth"):
            start, n_bytes = frame[f"{kind}_offset"], frame[f"{kind}_bytes"]
            assert shard[start : start + n_bytes] == data[frame[f"{kind}_file"]]
    with tarfile.open(fileobj=io.BytesIO(shard)) as tar:
        names = tar.getnames()
    keys = [name.partition(".")[0] for name in names]
    assert len(names) == 3 * len(frames)
    assert len(set(keys)) == len(frames)
    assert {name.partition(".")[2] for name in names} == {"rgb.jpg", "depth.png", "json"}


def test_torch_gets_what_the_cameras_saw(flight, folder):
    frames = FrameDataset(folder, camera="down", imu_rows=25)
    expected = [frame for frame in flight.frames if frame.camera == "down"]
    assert len(frames) == len(expected)
    history = flight.history
    for frame, seen in zip((frames[k] for k in range(len(frames))), expected, strict=True):
        assert frame.time_us.item() == seen.time_us
        assert (frame.rgb.dtype, frame.depth_m.dtype) == (torch.uint8, torch.float32)
        colours = frame.rgb.numpy().transpose(1, 2, 0).astype(float)
        assert np.abs(colours - seen.rgb).mean() < 10.0
        near = np.isfinite(seen.depth_m) & (seen.depth_m < 65.0)
        depth_m = frame.depth_m.numpy()[0]
        np.testing.assert_allclose(depth_m[near], seen.depth_m[near], atol=6e-4)
        assert not depth_m[~near].any()
        pose = frame.enu_from_optical.numpy()
        np.testing.assert_allclose(pose[:3, :3], seen.rotation_enu_from_optical, atol=1e-6)
        np.testing.assert_allclose(pose[:3, 3], seen.position_enu_m, atol=1e-5)
        lens = ((seen.fx, 0.0, seen.cx), (0.0, seen.fy, seen.cy), (0.0, 0.0, 1.0))
        np.testing.assert_allclose(frame.intrinsics_px.numpy(), lens, rtol=1e-6)
        before = history[history["time_us"] <= seen.time_us][-25:]
        rows = np.hstack([before["accel_flu_mps2"], before["gyro_flu_radps"]])
        np.testing.assert_allclose(frame.imu.numpy(), rows, rtol=1e-6)
    batch = next(iter(torch.utils.data.DataLoader(frames, batch_size=3)))
    assert batch.rgb.shape == (3, 3, *expected[0].depth_m.shape)


def test_frames_before_there_is_enough_imu_are_left_out(flight, folder):
    first_us = flight.frames[0].time_us
    n_before = int((flight.history["time_us"] <= first_us).sum())
    assert len(FrameDataset(folder, imu_rows=n_before)) == len(flight.frames)
    later = [frame for frame in flight.frames if frame.time_us > first_us]
    assert len(FrameDataset(folder, imu_rows=n_before + 1)) == len(later)


def test_the_loader_names_what_is_no_dataset(folder, tmp_path):
    with pytest.raises(TrialDataError, match="holds no dataset; valid: a folder of"):
        FrameDataset(tmp_path)
    with pytest.raises(TrialDataError, match="holds no frames of camera 'left'"):
        FrameDataset(folder, camera="left")
    shutil.copytree(folder, tmp_path / "torn")
    shard = tmp_path / "torn" / "images" / "flight.tar"
    shard.write_bytes(shard.read_bytes()[:600])
    with pytest.raises(TrialDataError, match=r"image of shard '.*flight.tar' is damaged; valid: "):
        FrameDataset(tmp_path / "torn")[5].rgb  # noqa: B018 - reading is what fails


def test_it_goes_on_where_it_was_stopped(flight, trial, tmp_path, capsys):
    recordings = tmp_path / "run" / "recordings"
    recordings.mkdir(parents=True)
    whole = flight.path.read_bytes()
    for name in ("42-iris-0", "42-iris-1"):
        shutil.copy(flight.path, recordings / f"{name}.rrd")
    (recordings / "42-iris-2.rrd").write_bytes(whole[: round(0.65 * len(whole))])
    out = tmp_path / "data"
    args = ("export-trial", recordings.parent, "--to", "dataset", "--out", out, "--json")
    # As a process leaves it that is killed between two tables.
    add_trial(out, replace(trial, name="42-iris-0"))
    (out / "images" / "42-iris-1.tar").write_bytes(b"cut")
    assert has_trial(out, "42-iris-0")
    assert not has_trial(out, "42-iris-1")
    kept = (out / "states" / "42-iris-0.parquet").stat().st_mtime_ns
    status, said, errors = in_process(capsys, *args)
    assert status == 0
    left_out = ["the pilot's landing map", "the pilot's tracks of movers"]
    facts = {"trials": 1, "there": 1, "skipped": 1, "left_out": left_out}
    assert json.loads(said) == {"out": str(out), "format": "dataset", **facts}
    assert "left out: recording '42-iris-2' has no end; valid: " in errors
    assert (out / "states" / "42-iris-0.parquet").stat().st_mtime_ns == kept
    shards = [(out / "images" / f"42-iris-{k}.tar").read_bytes() for k in (0, 1)]
    assert len(shards[0]) == len(shards[1]) > 10_000
    assert pq.read_table(out / "trials" / "42-iris-1.parquet")["trial"].to_pylist() == ["42-iris-1"]


def test_two_recordings_of_one_name_are_refused(flight, tmp_path, capsys):
    (tmp_path / "other").mkdir()
    other = shutil.copy(flight.path, tmp_path / "other")
    args = ("export-trial", flight.path, other, "--to", "dataset", "--out", tmp_path / "data")
    status, _, errors = in_process(capsys, *args)
    assert (status, errors.count("\n")) == (2, 1)
    assert "have one name; valid: unlike names" in errors
    assert not (tmp_path / "data").exists()


def test_a_recording_has_to_be_named(tmp_path, capsys):
    out = tmp_path / "data"
    status, _, errors = in_process(capsys, "export-trial", "--to", "dataset", "--out", out)
    assert (status, out.exists()) == (2, False)
    assert errors.startswith("aeroscene export-trial: error: no recording is named; valid: ")


@pytest.mark.parametrize("fault", ["missing", "damaged", "several"])
@pytest.mark.parametrize("to", ["mcap", "ulog", "csv", "dataset"])
def test_bad_input_is_one_line_and_leaves_nothing(flight, tmp_path, capsys, to, fault):
    path, out = tmp_path / "bad.rrd", tmp_path / "out"
    if fault == "damaged":
        path.write_bytes(bytes(1000))
    named = [path, flight.path] if fault == "several" else [path]
    status, _, errors = in_process(capsys, "export-trial", *named, "--to", to, "--out", out)
    if (fault, to) == ("several", "dataset"):
        assert status == 0
        assert "left out: recording" in errors
        return
    assert (status, errors.count("\n")) == (2, 1)
    assert errors.startswith("aeroscene export-trial: error: recording")
    assert "; valid: " in errors
    assert not out.exists()


def test_a_disk_that_fills_up_between_two_tables_leaves_nothing(trial, tmp_path, monkeypatch):
    written = []

    def write_three(table, file, write=pq.write_table, **options):
        if len(written) == 3:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        written.append(table)
        write(table, file, **options)

    monkeypatch.setattr("scenarios.trial_data.dataset.write.pq.write_table", write_three)
    with pytest.raises(OSError, match="No space left"):
        add_trial(tmp_path, trial)
    assert [path.name for path in tmp_path.rglob("*") if path.is_file()] == ["schema.json"]
    assert not has_trial(tmp_path, trial.name)


@pytest.mark.parametrize("to", ["mcap", "ulog", "csv", "dataset"])
def test_a_full_disk_is_one_line_and_leaves_nothing(flight, tmp_path, capsys, to):
    out = tmp_path / "out"
    with files_end_after(20_000):
        status, _, err = in_process(capsys, "export-trial", flight.path, "--to", to, "--out", out)
    assert status == 2, err
    assert err.count("\n") == 1, err
    assert "file too large" in err
    left = [path for path in tmp_path.rglob("*") if path.is_file()]
    assert left in ([], [out / "schema.json"])


def test_the_loader_imports_no_torch():
    code = "import sys, scenarios.trial_data.dataset.frames; sys.exit('torch' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_images_are_decoded_as_they_were_recorded(trial, folder):
    frames = FrameDataset(folder, imu_rows=1)
    (row,) = frames.table.slice(3, 1).to_pylist()
    (picture,) = [each for each in trial.pictures if each.file == row["depth_file"]]
    depth = cv2.imdecode(np.frombuffer(picture.data, np.uint8), cv2.IMREAD_UNCHANGED)
    np.testing.assert_array_equal(frames[3].depth_m.numpy()[0], (depth / 1000.0).astype(np.float32))
