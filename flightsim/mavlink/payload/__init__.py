"""Camera and gimbal on the wire: components of their own beside the autopilot."""

from flightsim.mavlink.payload.components import PayloadComponents

__all__ = ["PayloadComponents"]
