"""Encoding of pictures as a film or an animation.

VP9 in MP4 or VP8 in WebM by the FFmpeg within OpenCV: browsers play both, and no library is needed
that the product does not have. (Wheels that encode H.264 carry x264, which is under the GPL.) At
864 x 432 a picture takes 0.15 s of a core as VP9 and 0.05 s as VP8, which is twice as large.
"""

from __future__ import annotations

import itertools
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from PIL import Image

from aeroscene.files import replacing
from scenarios.pictures.lettering import Picture

_WEBP_QUALITY = 55


def write_video(pictures: Iterator[Picture], fps: float, out: Path) -> None:
    """Write a video, whole or not at all.

    Raises:
        OSError: If it cannot be written.
    """
    import cv2  # noqa: PLC0415 - heavy, and only films need its encoder

    with tempfile.TemporaryDirectory(dir=out.parent, prefix=".film-") as folder:
        first = next(pictures)
        height, width = (edge - edge % 2 for edge in first.shape[:2])
        draft = Path(folder) / out.name
        codec = cv2.VideoWriter.fourcc(*"VP80" if out.suffix == ".webm" else "vp09")
        writer = cv2.VideoWriter(str(draft), codec, fps, (width, height))
        if not writer.isOpened():
            raise OSError("OpenCV has no encoder for it here")
        for picture in itertools.chain([first], pictures):
            writer.write(np.ascontiguousarray(picture[:height, :width, ::-1]))
        writer.release()
        draft.replace(out)


def write_animation(pictures: Iterator[Picture], fps: float, out: Path) -> None:
    """Write a WebP or GIF that loops, whole or not at all.

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
