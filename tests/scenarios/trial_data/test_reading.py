"""Tables of a recording against what the plant logged and the cameras saw."""

import cv2
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from aeroscene.sources import load_scene
from scenarios.recording.scene_file import write_scene_recording
from scenarios.recording.summary import UnreadableRecordingError
from scenarios.trial_data.reading import TrialDataError, read_trial
from scenarios.trial_data.tables import TABLES
from tests.scenarios.recording.conftest import (
    CONTACT,
    NEW_PLAN_ENU_M,
    PLAN_ENU_M,
    PLAN_S,
    REPLANNED_US,
)

ENU, FLU, WXYZ = ("east", "north", "up"), ("forward", "left", "up"), ("w", "x", "y", "z")
STATES = (
    ("position_true", "m", ENU, "position_true_enu_m"),
    ("velocity_true", "mps", ENU, "velocity_true_enu_mps"),
    ("attitude_true", "", WXYZ, "quat_true_wxyz"),
    ("angular_rate_true", "radps", FLU, "angular_rate_true_flu_radps"),
    ("position_estimate", "m", ENU, "position_est_enu_m"),
    ("velocity_estimate", "mps", ENU, "velocity_est_enu_mps"),
    ("attitude_estimate", "", WXYZ, "quat_est_wxyz"),
    ("angular_rate_estimate", "radps", FLU, "angular_rate_est_flu_radps"),
    ("position_reference", "m", ENU, "reference_position_enu_m"),
    ("wind", "mps", ENU, "wind_enu_mps"),
)
FAST = (
    ("imu", "acceleration", "mps2", FLU, "accel_flu_mps2"),
    ("imu", "angular_rate", "radps", FLU, "gyro_flu_radps"),
    ("motors", "command", "radps", ("1", "2", "3", "4"), "rotor_command_radps"),
    ("motors", "speed", "radps", ("1", "2", "3", "4"), "rotor_speed_radps"),
)


def test_every_table_has_its_columns(trial):
    for name, columns in TABLES.items():
        assert trial.tables[name].column_names == [column.name for column in columns]


@pytest.mark.parametrize(("prefix", "unit", "parts", "field"), STATES)
def test_states_are_those_of_the_plant_at_every_tick(flight, trial, prefix, unit, parts, field):
    rows = flight.history[4::5]
    found = trial.array("states", prefix, unit, parts)
    np.testing.assert_array_equal(trial.tables["states"]["time_us"], rows["time_us"])
    is_known = np.ones(len(rows), dtype=bool)
    if "estimate" in prefix:
        is_known = rows["position_est_enu_m"].any(axis=1)
    elif "reference" in prefix:
        is_known = rows["reference_position_enu_m"].any(axis=1)
    assert is_known.any()
    # Attitudes are kept in single precision.
    np.testing.assert_allclose(found[is_known], rows[field][is_known], atol=2e-7, rtol=0.0)
    assert np.isnan(found[~is_known]).all()


@pytest.mark.parametrize(("table", "prefix", "unit", "parts", "field"), FAST)
def test_measurements_and_motors_are_whole(flight, trial, table, prefix, unit, parts, field):
    np.testing.assert_array_equal(trial.tables[table]["time_us"], flight.history["time_us"])
    np.testing.assert_array_equal(trial.array(table, prefix, unit, parts), flight.history[field])


def test_touching_is_that_of_the_plant(flight, trial):
    touching = trial.tables["states"]["is_touching"].to_numpy()
    np.testing.assert_array_equal(touching, flight.history["is_touching"][4::5] > 0)
    assert touching.any()


def test_frames_have_their_images_poses_and_lenses(flight, trial):
    rows = trial.tables["frames"].to_pylist()
    expected = sorted(flight.frames, key=lambda frame: (frame.time_us, frame.camera))
    data = {picture.file: picture.data for picture in trial.pictures}
    assert len(rows) == len(expected)
    for row, frame in zip(rows, expected, strict=True):
        assert (row["time_us"], row["camera"]) == (frame.time_us, frame.camera)
        at_m = [row[f"position_{axis}_m"] for axis in ENU]
        np.testing.assert_allclose(at_m, frame.position_enu_m, atol=1e-5)
        turn = Rotation.from_quat([row[f"attitude_{k}"] for k in WXYZ], scalar_first=True)
        np.testing.assert_allclose(turn.as_matrix(), frame.rotation_enu_from_optical, atol=1e-6)
        lens = [row[f"{what}_px"] for what in ("focal_x", "focal_y", "centre_x", "centre_y")]
        np.testing.assert_allclose(lens, (frame.fx, frame.fy, frame.cx, frame.cy), rtol=1e-6)
        depth = cv2.imdecode(np.frombuffer(data[row["depth_file"]], np.uint8), -1)
        near = np.isfinite(frame.depth_m) & (frame.depth_m < 65.0)
        np.testing.assert_allclose(depth[near] / 1000.0, frame.depth_m[near], atol=6e-4)
        assert not depth[~near].any()
        bgr = cv2.imdecode(np.frombuffer(data[row["rgb_file"]], np.uint8), cv2.IMREAD_COLOR)
        assert np.abs(bgr[:, :, ::-1].astype(float) - frame.rgb).mean() < 10.0


def test_plans_have_the_time_of_each_point(trial):
    rows = trial.tables["plans"].to_pylist()
    points = [tuple(row[f"position_{axis}_m"] for axis in ENU) for row in rows]
    assert points == [*PLAN_ENU_M, *NEW_PLAN_ENU_M]
    assert [row["since_us"] for row in rows] == [0, 0, 0, REPLANNED_US, REPLANNED_US]
    end_us = round(1e6 * PLAN_S)
    times = [0, end_us // 2, end_us, REPLANNED_US, REPLANNED_US + end_us]
    assert [row["time_us"] for row in rows] == times


def test_movers_contacts_and_events_are_there(flight, trial):
    (mover,) = set(trial.tables["movers"]["mover"].to_pylist())
    last = trial.tables["movers"].to_pylist()[-1]
    path = next(each for each in flight.story.movers if each.name == mover)
    at_m = np.array([last[f"position_{axis}_m"] for axis in ENU])
    assert np.linalg.norm(path.points_enu_m[-1] - at_m) < 0.5
    (contact,) = trial.tables["contacts"].to_pylist()
    assert (contact["since_us"], contact["until_us"]) == (3_100_000, 3_400_000)
    assert contact["what"] == CONTACT["what"]
    events = trial.tables["events"].to_pylist()
    assert {"phase", "armed", "mode", "text"} <= {event["what"] for event in events}
    assert [e["value"] for e in events if e["what"] == "armed"] == ["disarmed", "armed"]
    assert events == sorted(events, key=lambda event: event["time_us"])


def test_a_file_that_is_no_flight_is_named(tmp_path):
    path = tmp_path / "no.rrd"
    with pytest.raises(UnreadableRecordingError, match="does not exist"):
        read_trial(path)
    path.write_bytes(b"RRF2" + bytes(500))
    with pytest.raises(UnreadableRecordingError, match="is no rerun recording"):
        read_trial(path)
    write_scene_recording(load_scene("field"), path)
    with pytest.raises(TrialDataError, match="holds no flight; valid: one of"):
        read_trial(path)


def test_a_torn_recording_gives_what_is_whole(flight, tmp_path):
    torn = tmp_path / "torn.rrd"
    data = flight.path.read_bytes()
    # States come in a few pieces, among pictures of other sizes in every scene.
    for share in np.arange(0.95, 0.4, -0.02):
        torn.write_bytes(data[: round(share * len(data))])
        trial = read_trial(torn)
        n = len(trial.tables["states"])
        if n < len(flight.history[4::5]):
            break
    assert 0 < n < len(flight.history[4::5])
    found = trial.array("states", "position_true", "m", ENU)
    np.testing.assert_array_equal(found, flight.history["position_true_enu_m"][4::5][:n])
    with pytest.raises(TrialDataError, match="has no end"):
        trial.require_end()
