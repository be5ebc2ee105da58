"""Stream of H.264 by RTP to a UDP port of this machine, where ground stations read it."""

from __future__ import annotations

import contextlib
import socket
from collections.abc import Callable

import numpy as np

from flightsim.payload.video.encoder import FRAME_US, Encoder, require_encoder
from flightsim.payload.video.rtp import CLOCK_HZ, Packetiser

_HOST = "127.0.0.1"
_SOURCE = 0xAE5CE4E0  # any number; the port makes it differ by stream


class VideoStream:
    """Stream that renders, encodes and sends ten frames per simulated second while it runs.

    Attributes:
        port: UDP port of this machine that it is sent to.
        is_running: True while frames are sent.
        n_bytes: Bytes sent so far.
    """

    def __init__(
        self, port: int, size_px: tuple[int, int], render: Callable[[], np.ndarray]
    ) -> None:
        """Prepare a stream, which opens with its first frame.

        Args:
            port: UDP port to send to; nothing is received.
            size_px: Width and height of the frames.
            render: Renders the present frame, uint8 (height, width, 3).

        Raises:
            VideoError: If there is no encoder on this machine.
        """
        require_encoder()
        self.port = port
        self.is_running = True
        self.n_bytes = 0
        self._size_px = size_px
        self._render = render
        self._packetiser = Packetiser(_SOURCE + port)
        self._open: tuple[Encoder, socket.socket] | None = None

    @property
    def uri(self) -> str:
        """Address at which ground stations find the stream."""
        return f"udp://{_HOST}:{self.port}"

    def update(self, now_us: int) -> None:
        """Send the frame that is due at this tick, if there is one.

        Args:
            now_us: Simulated time; a frame is due at every tenth of a second of it.
        """
        if not self.is_running or now_us % FRAME_US:
            return
        if self._open is None:
            transport = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
            transport.setblocking(False)
            self._open = Encoder(self._size_px), transport
        encoder, transport = self._open
        units = encoder.encode(self._render())
        for packet in self._packetiser.packets(units, now_us * CLOCK_HZ // 1_000_000):
            self.n_bytes += len(packet)
            # Nobody needs to listen, and a full buffer drops a packet as a network would.
            with contextlib.suppress(OSError):
                transport.sendto(packet, (_HOST, self.port))

    def close(self) -> None:
        """Release the socket; nothing is sent afterwards."""
        self.is_running = False
        if self._open is not None:
            self._open[1].close()
