import numpy as np
import pytest
import rerun as rr

from scenarios.cli import replay
from scenarios.pictures import PictureError
from scenarios.pictures.recorded_story import read_story
from tests.scenarios.recording.conftest import (
    CHOICE_ENU_M,
    LANDING,
    NEW_PLAN_ENU_M,
    PLAN_S,
)


@pytest.fixture(scope="module")
def story(flight):
    return read_story(flight.path)


def test_track_is_the_one_that_was_flown(flight, story):
    told = flight.story.track
    for name in ("time_s", "true_enu_m", "est_enu_m", "ref_enu_m"):
        np.testing.assert_array_equal(getattr(story.track, name), getattr(told, name), err_msg=name)
    assert np.isnan(story.track.ref_enu_m[0]).all()
    assert np.isfinite(story.track.ref_enu_m[-1]).all()


def test_scene_and_vehicle_come_whole_out_of_the_file(flight, story):
    assert story.scene == flight.scene
    assert story.airframe == flight.airframe
    assert story.title == flight.story.title


def test_movers_walk_the_paths_they_walked(flight, story):
    assert [path.name for path in story.movers] == ["drone_0"]
    recorded, told = story.movers[0].points_enu_m, flight.story.movers[0].points_enu_m
    np.testing.assert_allclose(recorded[4::5, :2], told[:, :2], atol=1e-4)


def test_only_plans_that_were_flown_are_told(story):
    # The first was replaced before the rotors turned.
    (leg,) = story.plans
    np.testing.assert_allclose(leg.points_enu_m, NEW_PLAN_ENU_M)
    assert leg.time_s == pytest.approx(2.02)
    assert leg.step_s == PLAN_S


def test_landing_map_and_touchdown_are_the_last_ones(story):
    np.testing.assert_allclose(story.touchdown_enu_m, CHOICE_ENU_M, atol=1e-6)
    seen = LANDING.is_observed
    for name in ("height_m", "slope_rad", "roughness_m", "clearance_m"):
        layer = getattr(story.landing, name)
        np.testing.assert_allclose(layer[seen], getattr(LANDING, name)[seen], atol=2e-4)
        assert np.isnan(layer[~seen]).all()
    np.testing.assert_array_equal(story.landing.is_safe, LANDING.is_safe)
    np.testing.assert_allclose(story.landing.east_m, LANDING.axes_enu_m[0])


def test_torn_recording_still_tells_its_flight(flight, tmp_path):
    torn = tmp_path / "torn.rrd"
    whole = flight.path.read_bytes()
    torn.write_bytes(whole[: int(0.9 * len(whole))])
    story = read_story(torn)
    assert len(story.track.time_s) > 100
    assert story.scene == flight.scene


def test_recording_of_something_else_has_no_pictures(tmp_path):
    path = tmp_path / "foreign.rrd"
    recording = rr.RecordingStream("somebody_elses")
    recording.set_sinks(rr.FileSink(path))
    recording.log("a/text", rr.TextLog("hello"))
    recording.flush()
    recording.disconnect()
    with pytest.raises(PictureError, match="holds no scene"):
        read_story(path)
    with pytest.raises(SystemExit) as end:
        replay.run(replay.ReplayCfg(recording=path, pictures=tmp_path / "out"))
    assert end.value.code == 2


def test_replay_draws_pictures_of_a_recording(flight, tmp_path, capsys):
    cfg = replay.ReplayCfg(recording=flight.path, pictures=tmp_path / "out")
    assert replay.run(cfg) == 0
    drawn = capsys.readouterr().out.split()
    assert drawn == [str(tmp_path / "out" / name) for name in ("flight.png", "landing.png")]
