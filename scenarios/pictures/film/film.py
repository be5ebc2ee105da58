"""Film of a recorded flight: from behind on the left, the vehicle's cameras on the right.

The pictures are rendered anew from the recorded poses. A film therefore needs no camera that ran in
the flight, nor a recording with camera images, which is many times larger.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing
from pathlib import Path

import numpy as np

from autonomy.rotation import yaw_from_quat
from flightsim.cameras import CameraRenderer, open_camera_renderer
from scenarios.pictures.film.encode import write_animation, write_video
from scenarios.pictures.film.reel import Moment, Reel
from scenarios.pictures.lettering import Picture, label
from scenarios.pictures.story import PictureError
from scenarios.recording.chase import FOV_RAD, ChaseEye

SUFFIXES = (".mp4", ".webm", ".webp", ".gif")
_VIDEO_PX, _VIDEO_FPS = 432, 20.0
_LOOP_PX, _LOOP_FPS, _LOOP_SPEED = 324, 10.0, 2.0
"""Height, frame rate and speed of an animation on a page, where every byte is loaded."""
_WORDS_PX = 36
"""Height of a picture divided by the height of its caption."""


def draw_film(recording: Path, out: Path, on_frame: Callable[[int, int], None]) -> None:
    """Render a recorded flight as a film; no camera needs to have run in it.

    Args:
        recording: An .rrd file of a flight.
        out: File to write, whole or not at all: .mp4 or .webm to play, .webp or .gif for a page.
        on_frame: Called with each picture's number, from 1, and the number of all pictures.

    Raises:
        UnreadableRecordingError: If the file is missing or no recording.
        PictureError: If it holds no flight, or the film cannot be written.
    """
    if out.suffix not in SUFFIXES:
        valid = ", ".join(SUFFIXES)
        raise PictureError(f"video {str(out)!r} ends in {out.suffix!r}; valid: {valid}")
    is_loop = out.suffix in (".webp", ".gif")
    height_px, fps = (_LOOP_PX, _LOOP_FPS) if is_loop else (_VIDEO_PX, _VIDEO_FPS)
    step_s = (_LOOP_SPEED if is_loop else 1.0) / fps
    reel = Reel(recording)
    n_frames = len(reel.times_us(step_s))

    def counted() -> Iterator[Picture]:
        for number, picture in enumerate(_pictures(reel, height_px, step_s), start=1):
            on_frame(number, n_frames)
            yield picture

    try:
        (write_animation if is_loop else write_video)(counted(), fps, out)
    except OSError as error:
        raise PictureError(
            f"video {str(out)!r} cannot be written ({error.strerror or error}); "
            "valid: a file in a folder you may write to"
        ) from None


def _pictures(reel: Reel, height_px: int, step_s: float) -> Iterator[Picture]:
    world = reel.world
    cameras = [mount.name for mount in world.airframe.rgbd_cameras]
    # A single camera fills half of the height, so that the film keeps its shape.
    small_px = height_px // max(2, len(cameras))
    with ExitStack() as stack:

        def renderer(height: int) -> CameraRenderer:
            opened = open_camera_renderer(world, round(height * 4 / 3), height)
            return stack.enter_context(closing(opened))

        behind, aboard = renderer(height_px), renderer(small_px)
        eye: ChaseEye | None = None
        for moment in reel.play(step_s):
            # The eye begins behind the first attitude, which is known with the first moment.
            eye = eye or ChaseEye(world, yaw_from_quat(moment.data.qpos[3:7]))
            place = eye.follow(moment.position_enu_m, moment.velocity_enu_mps, step_s)
            target = tuple(moment.position_enu_m.tolist())
            chase = behind.render_view(moment.data, place, target, FOV_RAD).rgb
            seen = [aboard.render(moment.data, name, 0).rgb for name in cameras]
            views = [_named(chase, _words(moment)), _stacked(cameras, seen, height_px)]
            yield np.hstack(views)


def _words(moment: Moment) -> str:
    phase = f"  {moment.phase}" if moment.phase else ""
    return f"{moment.time_s:5.1f} s{phase}"


def _stacked(names: list[str], pictures: list[Picture], height_px: int) -> Picture:
    """Return pictures with their names above each other, with black below if height is left."""
    named = [_named(picture, name) for name, picture in zip(names, pictures, strict=True)]
    left_px = height_px - sum(len(picture) for picture in named)
    return np.vstack([*named, np.zeros((left_px, named[0].shape[1], 3), np.uint8)])


def _named(picture: Picture, name: str) -> Picture:
    return label(picture, name, size_px=max(11, len(picture) // _WORDS_PX))
