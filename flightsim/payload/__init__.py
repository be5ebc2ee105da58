"""What the vehicle carries besides itself: a gimbal, a camera on it, and its pictures."""

from flightsim.payload.payload import VIDEO_PORT, Payload, PayloadCfg
from flightsim.payload.video import VideoError

__all__ = ["VIDEO_PORT", "Payload", "PayloadCfg", "VideoError"]
