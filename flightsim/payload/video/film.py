"""Film: H.264 in an MP4 file, which takes its name when it is whole."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import numpy as np

from flightsim.payload.video.encoder import BITRATE_BPS, CODEC, OPTIONS, RATE_HZ


class Film:
    """Frames that are written to a file as they come."""

    def __init__(self, path: Path, size_px: tuple[int, int]) -> None:
        """Open a file for frames; PyAV must be installed.

        Args:
            path: Name of the file once it is closed; until then it is a hidden one beside it.
            size_px: Width and height of the frames.

        Raises:
            OSError: If it cannot be written.
        """
        import av  # an extra, where somebody films

        self._path = path
        self._part = path.with_name(f".{path.name}.part")
        self._container = av.open(str(self._part), "w", format="mp4")
        stream = self._container.add_stream(CODEC, rate=RATE_HZ, options=OPTIONS)
        stream.width, stream.height = size_px
        stream.pix_fmt = "yuv420p"
        stream.bit_rate = BITRATE_BPS
        stream.gop_size = RATE_HZ
        stream.thread_count = 1
        self._stream = stream
        self._n_frames = 0
        self.n_bytes = 0
        """Bytes of the frames so far, without the index that closes the file."""

    def add(self, rgb: np.ndarray) -> None:
        """Add a frame, 0.1 s after the one before it.

        Args:
            rgb: Colours, uint8 (height, width, 3).

        Raises:
            OSError: If the disk refuses it.
        """
        import av

        frame = av.VideoFrame.from_ndarray(rgb, format="rgb24")
        frame.pts, frame.time_base = self._n_frames, Fraction(1, RATE_HZ)
        self._n_frames += 1
        for packet in self._stream.encode(frame):
            self.n_bytes += packet.size
            self._container.mux(packet)

    def close(self) -> int:
        """Write what is left and give the file its name.

        Returns:
            The size of the file in bytes.

        Raises:
            OSError: If the disk refuses it; no file is left.
        """
        try:
            # Encoding nothing yields the packets that the encoder still holds.
            self._container.mux(self._stream.encode())
            self._container.close()
            return self._part.replace(self._path).stat().st_size
        finally:
            self._part.unlink(missing_ok=True)
