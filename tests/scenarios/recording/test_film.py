import cv2
import numpy as np
import pytest
from PIL import Image

from scenarios.pictures.film import draw_film
from scenarios.pictures.film import film as film_module
from scenarios.pictures.film.reel import Reel
from scenarios.pictures.story import PictureError
from scenarios.recording.chase import ChaseEye


def _unseen(*_):
    """Nobody waits for the pictures."""


@pytest.fixture
def small(monkeypatch):
    """Films of few and small pictures."""
    for name, value in {
        "_VIDEO_PX": 96,
        "_VIDEO_FPS": 4.0,
        "_LOOP_PX": 96,
        "_LOOP_FPS": 4.0,
    }.items():
        monkeypatch.setattr(film_module, name, value)


def test_a_reel_has_the_vehicle_where_it_was(flight):
    history = flight.history
    for moment in Reel(flight.path).play(0.25):
        row = np.searchsorted(history["time_us"], round(1e6 * moment.time_s), side="right") - 1
        true_m = history["position_true_enu_m"][row]
        np.testing.assert_allclose(moment.data.qpos[:3], true_m, atol=1e-5)


@pytest.mark.parametrize("suffix", [".mp4", ".webm"])
def test_a_video_plays_every_picture(flight, small, tmp_path, suffix):
    seen = []
    out = tmp_path / f"flight{suffix}"
    draw_film(flight.path, out, lambda number, of: seen.append((number, of)))
    video = cv2.VideoCapture(str(out))
    pictures = []
    while (read := video.read())[0]:
        pictures.append(read[1])
    assert [number for number, _ in seen] == list(range(1, len(pictures) + 1))
    assert {of for _, of in seen} == {len(pictures)}
    assert pictures[0].shape[:2] == (96, 192)
    assert np.abs(pictures[0].astype(float) - pictures[-1]).mean() > 0.3
    assert list(tmp_path.iterdir()) == [out]


def test_a_loop_goes_round_for_ever(flight, small, tmp_path):
    out = tmp_path / "flight.webp"
    draw_film(flight.path, out, _unseen)
    with Image.open(out) as loop:
        assert loop.n_frames > 1
        assert loop.info["loop"] == 0


@pytest.mark.parametrize("name", ["flight.avi", "flight"])
def test_other_formats_are_refused_with_those_that_there_are(flight, tmp_path, name):
    with pytest.raises(PictureError, match=r"valid: \.mp4, \.webm, \.webp, \.gif"):
        draw_film(flight.path, tmp_path / name, _unseen)


@pytest.mark.parametrize("suffix", [".mp4", ".webp"])
def test_a_folder_that_is_not_there_is_told_before_anything_is_drawn(
    flight, small, tmp_path, suffix
):
    drawn = []
    with pytest.raises(PictureError, match="cannot be written"):
        draw_film(flight.path, tmp_path / "none" / f"flight{suffix}", lambda *n: drawn.append(n))
    assert drawn == []


def test_no_wall_is_between_the_eye_and_the_vehicle(flight):
    world = Reel(flight.path).world
    start = np.array(world.scene.start_position_enu_m) + (0.0, 0.0, 1.0)
    eye = ChaseEye(world, heading_rad=0.0)
    places = [eye.follow(start, np.array([0.0, 1.0, 0.0]), 0.1) for _ in range(60)]
    behind = np.subtract(places[-1], start)
    assert behind[1] < 0
    assert abs(behind[0]) < 0.1 * abs(behind[1])
    assert behind[2] > 0
