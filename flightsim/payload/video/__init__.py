"""Moving pictures of the gimbal's camera: H.264 in a file, or by RTP to a port."""

from flightsim.payload.video.encoder import (
    BITRATE_BPS,
    FRAME_US,
    RATE_HZ,
    Encoder,
    VideoError,
    has_encoder,
)
from flightsim.payload.video.film import Film
from flightsim.payload.video.stream import VideoStream

__all__ = [
    "BITRATE_BPS",
    "FRAME_US",
    "RATE_HZ",
    "Encoder",
    "Film",
    "VideoError",
    "VideoStream",
    "has_encoder",
]
