import json
import socket
from itertools import pairwise

import cv2
import numpy as np
import pytest
from rerun.chunk import RrdReader
from scipy.spatial.transform import Rotation

from scenarios.recording import Recorder, RecordingError, RunInfo, layout
from scenarios.trials.measures.estimation import rotation_angle_rad
from tests.scenarios.recording.conftest import (
    CHOICE_ENU_M,
    FIRST_CHOICE_ENU_M,
    LANDING,
    LIMITS,
    NEW_PLAN_ENU_M,
    PLAN_ENU_M,
    PLAN_S,
    REPLANNED_US,
    SEEN,
)

FAST = (
    *(
        (f"state/{what}/{axis}", field, 5, k, whose)
        for k, axis in enumerate(("east", "north", "up"))
        for what, whose, field in (
            ("position", 0, "reference_position_enu_m"),
            ("position", 1, "position_est_enu_m"),
            ("position", 2, "position_true_enu_m"),
            ("velocity", 0, "reference_velocity_enu_mps"),
            ("velocity", 1, "velocity_est_enu_mps"),
            ("velocity", 2, "velocity_true_enu_mps"),
        )
    ),
    ("sensors/imu/acceleration", "accel_flu_mps2", 1, None, None),
    ("sensors/imu/angular_rate", "gyro_flu_radps", 1, None, None),
    ("motors/command", "rotor_command_radps", 1, None, None),
    ("motors/speed", "rotor_speed_radps", 1, None, None),
    ("contacts/touching", "is_touching", 1, None, None),
)


def _is_known(history, field):
    """Whether a field means something: after alignment, and once there is a reference."""
    if "_est_" in field:
        return history["position_est_enu_m"].any(axis=1)
    if "reference" in field:
        return history["reference_position_enu_m"].any(axis=1)
    return np.ones(len(history), dtype=bool)


@pytest.mark.parametrize(("entity", "field", "step", "column", "whose"), FAST)
def test_fast_data_comes_back_as_the_plant_logged_it(
    flight, contents, entity, field, step, column, whose
):
    times_us, rows = contents.column(entity, "Scalars:scalars")
    if whose is not None:
        rows = [[row[whose]] for row in rows]
    history = flight.history[step - 1 :: step]
    expected = history[field].reshape(len(history), -1)
    if column is not None:
        expected = expected[:, column : column + 1]
    np.testing.assert_array_equal(times_us, history["time_us"])
    is_known = _is_known(history, field)
    np.testing.assert_array_equal(np.array(rows)[is_known], expected[is_known])
    assert np.isnan(np.array(rows)[~is_known]).all()


def test_nothing_of_the_estimate_is_drawn_before_its_alignment(flight, contents):
    is_aligned = flight.history["position_est_enu_m"][4::5].any(axis=1)
    assert not is_aligned[0]
    assert is_aligned[-1]
    aligned_us = flight.history["time_us"][4::5][is_aligned]
    for entity, component in (
        ("error/position", "Scalars:scalars"),
        ("error/attitude", "Scalars:scalars"),
        ("world/estimate", "Transform3D:translation"),
    ):
        np.testing.assert_array_equal(contents.column(entity, component)[0], aligned_us)


def test_vehicle_pose_is_the_true_one_at_every_control_tick(flight, contents):
    times_us, positions = contents.column("world/vehicle", "Transform3D:translation")
    _, quats_xyzw = contents.column("world/vehicle", "Transform3D:quaternion")
    np.testing.assert_array_equal(times_us, flight.history["time_us"])
    np.testing.assert_allclose(
        np.array(positions)[:, 0], flight.history["position_true_enu_m"], atol=1e-5
    )
    np.testing.assert_allclose(
        np.array(quats_xyzw)[:, 0][:, [3, 0, 1, 2]], flight.history["quat_true_wxyz"], atol=1e-6
    )


def test_errors_are_estimate_against_truth(flight, contents):
    rows = flight.history[4::5]
    rows = rows[_is_known(rows, "position_est_enu_m")]
    _, position = contents.column("error/position", "Scalars:scalars")
    _, attitude = contents.column("error/attitude", "Scalars:scalars")
    error_m = rows["position_est_enu_m"] - rows["position_true_enu_m"]
    np.testing.assert_allclose(np.array(position)[:, :3], error_m)
    np.testing.assert_allclose(np.array(position)[:, 3], np.linalg.norm(error_m, axis=1))
    angle_deg = np.degrees(rotation_angle_rad(rows["quat_est_wxyz"], rows["quat_true_wxyz"]))
    np.testing.assert_allclose(np.array(attitude)[:, 0], angle_deg)


def test_executed_trajectory_is_one_line_to_the_last_position(flight, contents):
    times_us, strips = contents.column("world/trajectory/executed", "LineStrips3D:strips")
    pieces = [np.array(strip[0]) for strip in strips]
    for before, after in pairwise(pieces):
        np.testing.assert_array_equal(before[-1], after[0])
    last = flight.history[-1]
    np.testing.assert_allclose(pieces[-1][-1], last["position_true_enu_m"], atol=1e-5)
    assert times_us[-1] == last["time_us"]


def test_the_eye_behind_looks_at_the_vehicle_25_times_a_second(flight, contents):
    times_us, eyes = contents.column(layout.CHASE, "Transform3D:translation")
    _, quats = contents.column(layout.CHASE, "Transform3D:quaternion")
    rows = flight.history[flight.history["time_us"] % 40_000 == 0]
    np.testing.assert_array_equal(times_us, rows["time_us"])
    to_vehicle = rows["position_true_enu_m"] - np.array(eyes)[:, 0]
    distance_m = np.linalg.norm(to_vehicle, axis=1, keepdims=True)
    assert np.all((distance_m > 0.5) & (distance_m < 3.5))
    camera = Rotation.from_quat(np.array(quats)[:, 0])
    ahead, right = camera.apply((0.0, 0.0, 1.0)), camera.apply((1.0, 0.0, 0.0))
    np.testing.assert_allclose(ahead, to_vehicle / distance_m, atol=1e-5)
    np.testing.assert_allclose(right[:, 2], 0.0, atol=1e-6)
    assert camera.apply((0.0, 1.0, 0.0))[0, 2] < 0.0


def test_contacts_stand_in_words_and_in_the_scene_at_their_times(contents):
    times_us, texts = contents.column(layout.TOUCHED, "TextLog:text")
    assert times_us.tolist() == [3_100_000]
    assert texts == [["object 7 (gate), until 3.40 s"]]
    times_us, points = contents.column(layout.CONTACTS, "Points3D:positions")
    assert times_us.tolist() == [3_100_000]
    np.testing.assert_array_equal(points[0], [[1.0, 2.0, 3.0]])


def test_limits_and_code_of_the_verdict_are_in_the_file(contents):
    _, limits = contents.column("__properties/run", "limits")
    assert json.loads(limits[0][0]) == LIMITS
    _, code = contents.column("__properties/verdict", "code")
    assert code[0] == ["contact"]


def test_everything_in_time_is_on_one_timeline(contents):
    timelines = {name for chunk in contents.chunks for name in chunk.timeline_names}
    assert timelines == {layout.TIMELINE}


def test_frames_come_back_in_colour_and_in_metres(flight, contents):
    for camera in ("forward", "down"):
        frames = [frame for frame in flight.frames if frame.camera == camera]
        times_us, jpegs = contents.column(layout.camera_rgb(camera), "EncodedImage:blob")
        _, pngs = contents.column(layout.camera_depth(camera), "EncodedDepthImage:blob")
        assert times_us.tolist() == [frame.time_us for frame in frames]
        for frame, jpeg, png in zip(frames, jpegs, pngs, strict=True):
            rgb = cv2.imdecode(_bytes(jpeg), cv2.IMREAD_COLOR_RGB)
            assert np.abs(rgb.astype(float) - frame.rgb).mean() < 12.0
            depth_m = cv2.imdecode(_bytes(png), cv2.IMREAD_UNCHANGED) / 1000.0
            is_seen = np.isfinite(frame.depth_m) & (frame.depth_m < 65.5)
            np.testing.assert_allclose(depth_m[is_seen], frame.depth_m[is_seen], atol=6e-4)
            assert (depth_m[~is_seen] == 0).all()


def _bytes(blob):
    return np.frombuffer(bytes(blob[0]), np.uint8)


def test_pinhole_has_the_frames_intrinsics(flight, contents):
    frame = flight.frames[0]
    _, matrices = contents.column(layout.camera(frame.camera), "Pinhole:image_from_camera")
    _, sizes = contents.column(layout.camera(frame.camera), "Pinhole:resolution")
    expected = [frame.fx, 0, 0, 0, frame.fy, 0, frame.cx, frame.cy, 1]
    np.testing.assert_allclose(matrices[0][0], expected, rtol=1e-6)
    assert sizes[0][0] == [64, 48]


def test_camera_entity_stands_where_the_renderer_looks_from(flight, contents):
    for frame in flight.frames[-2:]:
        entity = layout.camera(frame.camera)
        _, ((mount_flu_m,),) = contents.column(entity, "Transform3D:translation")
        _, ((columns,),) = contents.column(entity, "Transform3D:mat3x3")
        row = flight.history[flight.history["time_us"] == frame.time_us][0]
        rotation_enu_from_flu = _matrix(row["quat_true_wxyz"])
        rotation_flu_from_optical = np.array(columns).reshape(3, 3).T
        np.testing.assert_allclose(
            rotation_enu_from_flu @ rotation_flu_from_optical,
            frame.rotation_enu_from_optical,
            atol=1e-4,
        )
        position = row["position_true_enu_m"] + rotation_enu_from_flu @ np.array(mount_flu_m)
        np.testing.assert_allclose(position, frame.position_enu_m, atol=1e-3)


def _matrix(quat_wxyz):
    return Rotation.from_quat(quat_wxyz, scalar_first=True).as_matrix()


def test_states_are_written_when_they_change(contents):
    times_us, armed = contents.column(layout.ARMED, "StateChange:state")
    assert [state[0] for state in armed] == ["disarmed", "armed"]
    assert times_us.tolist() == [20_000, 2_020_000]
    _, modes = contents.column(layout.MODE, "StateChange:state")
    assert modes
    _, landed = contents.column(layout.LANDED, "StateChange:state")
    assert landed[0] == ["on ground"]
    _, failsafe = contents.column(layout.FAILSAFE, "StateChange:state")
    assert failsafe[0] == ["none"]


def test_statustext_keeps_time_level_and_words(flight, contents):
    times_us, texts = contents.column(layout.STATUSTEXT, "TextLog:text")
    _, levels = contents.column(layout.STATUSTEXT, "TextLog:level")
    assert texts[-1] == ["battery low"]
    assert levels[-1] == ["WARN"]
    assert times_us[-1] == flight.history[-1]["time_us"]
    assert len(texts) > 1, "the autopilot's own words are missing"


def test_gauges_are_sampled_ten_times_a_second(contents):
    for entity in (
        layout.BATTERY_VOLTAGE,
        layout.BATTERY_CURRENT,
        layout.BATTERY_REMAINING,
        layout.sensor("rangefinder"),
        layout.sensor("airspeed"),
        f"{layout.POSITION_SIGMA}/horizontal",
        f"{layout.POSITION_SIGMA}/vertical",
    ):
        times_us, values = contents.column(entity, "Scalars:scalars")
        assert times_us.tolist() == list(range(20_000, 3_500_000, 100_000))
        assert len(values) == len(times_us)
    _, volts = contents.column(layout.BATTERY_VOLTAGE, "Scalars:scalars")
    assert 9.0 < volts[0][0] < 13.0


def test_plans_come_back_and_a_replaced_one_is_split_where_it_was_left(contents):
    times_us, strips = contents.column(layout.PLANNED, "LineStrips3D:strips")
    assert times_us.tolist() == [0, REPLANNED_US]
    np.testing.assert_allclose(strips[0][0], PLAN_ENU_M)
    np.testing.assert_allclose(strips[1][0], NEW_PLAN_ENU_M)
    _, durations = contents.column(layout.PLANNED, "duration_s")
    assert durations == [[PLAN_S], [PLAN_S]]
    times_us, ((flown, left),) = contents.column(layout.EARLIER_PLANS, "LineStrips3D:strips")
    assert times_us.tolist() == [REPLANNED_US]
    np.testing.assert_allclose(flown, PLAN_ENU_M[:2])
    np.testing.assert_allclose(left, PLAN_ENU_M[1:])
    _, labels = contents.column(layout.EARLIER_PLANS, "LineStrips3D:labels")
    assert labels == [["plan 1 since 0.0 s", "plan 1 since 0.0 s, replaced at 1.0 s"]]


def test_landing_map_comes_back_layer_by_layer_on_the_cells_that_were_seen(contents):
    _, cells = contents.column(layout.LANDING_SAFETY, "Points3D:positions")
    np.testing.assert_allclose(cells[0], LANDING.cells_enu_m, atol=1e-6)
    for layer in (layout.LANDING_SLOPE, layout.LANDING_ROUGHNESS, layout.LANDING_CLEARANCE):
        _, drawn = contents.column(layer, "Points3D:positions")
        np.testing.assert_allclose(drawn[0], LANDING.cells_enu_m[[0, 2, 6]], atol=1e-6)
    seen = LANDING.is_observed
    for name in ("height_m", "slope_rad", "roughness_m", "clearance_m", "is_safe"):
        _, values = contents.column(layout.LANDING_GRID, name)
        np.testing.assert_allclose(values[-1], getattr(LANDING, name)[seen], atol=2e-4)


def test_every_choice_of_a_place_stays_and_the_last_one_is_the_touchdown(contents):
    _, choices = contents.column(layout.CHOICES, "Points3D:positions")
    np.testing.assert_allclose([c[0] for c in choices], [FIRST_CHOICE_ENU_M, CHOICE_ENU_M])
    _, touchdown = contents.column(layout.TOUCHDOWN, "Points3D:positions")
    np.testing.assert_allclose(touchdown[-1][0], CHOICE_ENU_M)


def test_what_is_seen_to_move_comes_back_as_boxes_with_velocities(contents):
    times_us, centres = contents.column(layout.TRACKS, "Boxes3D:centers")
    assert times_us.tolist() == [REPLANNED_US]
    np.testing.assert_allclose(centres[0], SEEN.position_enu_m)
    _, sizes = contents.column(layout.TRACKS, "Boxes3D:half_sizes")
    np.testing.assert_allclose(sizes[0], [[0.4, 0.4, 0.4]])
    _, velocities = contents.column(layout.TRACK_VELOCITIES, "Arrows3D:vectors")
    np.testing.assert_allclose(velocities[0], SEEN.velocity_enu_mps)


def test_phases_of_the_pilot_are_states(flight, contents):
    times_us, phases = contents.column(layout.PHASE, "StateChange:state")
    assert phases == [["arm"], ["search"]]
    assert times_us.tolist() == [0, flight.history["time_us"][-1]]


def test_blueprint_is_in_the_file(contents):
    (blueprint,) = contents.reader.blueprints()
    assert blueprint.application_id == layout.APPLICATION_ID


@pytest.mark.parametrize("place", ["folder", "under_a_file"])
def test_path_that_cannot_be_written_is_refused_in_one_line(flight, tmp_path, place):
    (tmp_path / "file").touch()
    path = tmp_path if place == "folder" else tmp_path / "file" / "x.rrd"
    with pytest.raises(RecordingError, match="cannot be written") as error:
        _open(flight, path)
    assert "\n" not in str(error.value)


def test_live_port_in_use_is_refused_in_one_line(flight, tmp_path):
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        with pytest.raises(RecordingError, match=f"port {port} cannot be had") as error:
            _open(flight, tmp_path / "x.rrd", serve_port=port)
    assert "\n" not in str(error.value)


def test_closing_twice_is_fine_and_two_recordings_are_two(flight, tmp_path):
    ids = set()
    for name in ("a.rrd", "b.rrd"):
        recorder = _open(flight, tmp_path / name)
        recorder.close()
        recorder.close()
        (entry,) = RrdReader(tmp_path / name).recordings()
        ids.add(entry.recording_id)
    assert len(ids) == 2


def _open(flight, path, serve_port=None):
    return Recorder(
        path,
        scene=flight.scene,
        primitives=flight.primitives[:3],
        airframe=flight.airframe,
        info=RunInfo(scene="42", vehicle="iris", seed=0),
        serve_port=serve_port,
    )
