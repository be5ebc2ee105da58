"""Encoding of pictures as a film or an animation.

A video is VP9 in MP4 or VP8 in WebM, written by the FFmpeg within OpenCV. Browsers play both, and
OpenCV is a dependency already. Wheels that encode H.264 carry x264, which is under the GPL. At 864
x 432, a picture takes 0.15 s of a core as VP9. As VP8 it takes 0.05 s and twice the bytes.
"""

from __future__ import annotations

import errno
import itertools
import os
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from PIL import Image

from aeroscene.files import replacing
from scenarios.pictures.lettering import Picture

_WEBP_QUALITY = 55
_ERRORS_ALONE = 2
"""Level of OpenCV's log that prints errors only."""


def write_video(pictures: Iterator[Picture], fps: float, out: Path) -> None:
    """Write a video, whole or not at all.

    Args:
        pictures: Pictures of one size, at least one; they are taken one at a time.
        fps: Pictures in a second.
        out: File to write; its ending chooses the codec.

    Raises:
        OSError: If it cannot be written.
    """
    # Otherwise FFmpeg prints its own messages about a film that a full disk has cut short.
    os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")
    import cv2

    # OpenCV would otherwise print a warning for each picture that is not written.
    cv2.utils.logging.setLogLevel(_ERRORS_ALONE)
    with tempfile.TemporaryDirectory(dir=out.parent, prefix=".film-") as folder:
        first = next(pictures)
        # These codecs halve the resolution of colours, so sides must be even.
        height, width = (edge - edge % 2 for edge in first.shape[:2])
        draft = Path(folder) / out.name
        codec = cv2.VideoWriter.fourcc(*"VP80" if out.suffix == ".webm" else "vp09")
        writer = cv2.VideoWriter(str(draft), codec, fps, (width, height))
        if not writer.isOpened():
            raise OSError("OpenCV has no encoder for it here")
        n_pictures = 0
        for picture in itertools.chain([first], pictures):
            # OpenCV's colours are blue, green, red.
            writer.write(np.ascontiguousarray(picture[:height, :width, ::-1]))
            n_pictures += 1
        writer.release()
        _require_whole(draft, n_pictures)
        draft.replace(out)


def _require_whole(video: Path, n_pictures: int) -> None:
    """Count the pictures in a video, because OpenCV's writer does not report a full disk.

    Raises:
        OSError: If some are missing.
    """
    import cv2

    capture = cv2.VideoCapture(str(video))
    n_found = 0
    while capture.grab():
        n_found += 1
    capture.release()
    if n_found != n_pictures:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def write_animation(pictures: Iterator[Picture], fps: float, out: Path) -> None:
    """Write a WebP or GIF that loops, whole or not at all.

    Args:
        pictures: Pictures of one size, at least one; all are kept in memory.
        fps: Pictures in a second.
        out: File to write; its ending chooses the format.

    Raises:
        OSError: If it cannot be written.
    """
    with replacing(out) as file:
        frames = [Image.fromarray(picture) for picture in pictures]
        frames[0].save(
            file,
            format=out.suffix[1:],
            save_all=True,
            append_images=frames[1:],
            duration=round(1000 / fps),
            loop=0,
            quality=_WEBP_QUALITY,
        )
