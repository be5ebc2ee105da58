"""Payload of the vehicle: a gimbal, a camera on it, and the pictures that it takes."""

from flightsim.payload.payload import VIDEO_PORT, Payload, PayloadCfg
from flightsim.payload.video import VideoError

__all__ = ["VIDEO_PORT", "Payload", "PayloadCfg", "VideoError"]
