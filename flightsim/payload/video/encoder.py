"""H.264 by PyAV, which is imported only when somebody films or streams.

PyAV is an optional extra; the rest of the package works without it.
"""

from __future__ import annotations

import importlib.util
from collections.abc import Iterator
from fractions import Fraction
from typing import Final

import numpy as np

RATE_HZ = 10
FRAME_US = 1_000_000 // RATE_HZ
"""Simulated time between two frames."""
BITRATE_BPS = 2_000_000
CODEC: Final = "libx264"
OPTIONS = {"preset": "ultrafast", "tune": "zerolatency", "profile": "baseline"}
"""Options of the encoder: each frame leaves as soon as it is encoded, and any player decodes it."""


class VideoError(ValueError):
    """This machine cannot make moving pictures."""


def has_encoder() -> bool:
    """Return True if PyAV is installed; nothing is imported for it."""
    return importlib.util.find_spec("av") is not None


def require_encoder() -> None:
    """Refuse to go on without PyAV.

    Raises:
        VideoError: If it is not installed.
    """
    if not has_encoder():
        raise VideoError(
            "video needs PyAV, which is not installed; valid: pip install 'aeroscene[video]'"
        )


class Encoder:
    """Encoder of frames to H.264, one after the other, with a whole picture each second."""

    def __init__(self, size_px: tuple[int, int]) -> None:
        """Open an encoder; PyAV must be installed.

        Args:
            size_px: Width and height of the frames.
        """
        import av  # an extra, which is there now

        context = av.CodecContext.create(CODEC, "w")
        context.width, context.height = size_px
        context.pix_fmt = "yuv420p"
        # Frames have simulated time, ten to a second, however long one takes to render.
        context.time_base = Fraction(1, RATE_HZ)
        context.framerate = Fraction(RATE_HZ)
        context.bit_rate = BITRATE_BPS
        context.gop_size = RATE_HZ  # a whole picture each second, for who joins late
        context.thread_count = 1  # no threads besides ours
        context.options = OPTIONS
        self._context = context
        self._n_frames = 0

    def encode(self, rgb: np.ndarray) -> list[bytes]:
        """Return the NAL units of a frame, without start codes.

        Args:
            rgb: Colours, uint8 (height, width, 3).
        """
        import av

        frame = av.VideoFrame.from_ndarray(rgb, format="rgb24")
        frame.pts = self._n_frames
        self._n_frames += 1
        return [unit for packet in self._context.encode(frame) for unit in nal_units(bytes(packet))]


def nal_units(stream: bytes) -> Iterator[bytes]:
    """Yield the NAL units of a byte stream with start codes of three or four bytes.

    The layout is annex B of H.264.
    """
    for part in stream.split(b"\0\0\1"):
        # A fourth byte of the next start code, and zeros that may trail, belong to no unit.
        unit = part.rstrip(b"\0")
        if unit:
            yield unit
