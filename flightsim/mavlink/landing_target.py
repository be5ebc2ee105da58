"""LANDING_TARGET: position of the target of a precision landing."""

from __future__ import annotations

import math
from collections.abc import Mapping

from autonomy.types import Vector3
from flightsim.mavlink.channel import Channel
from flightsim.mavlink.dialect import dialect as mav
from flightsim.mavlink.parsing import Message
from flightsim.mavlink.service import Handler
from flightsim.mavlink.view import VehicleView

_FARTHEST_M = 1e3
_STEEPEST_RAD = 1.4  # about 80 degrees: the tangent of a steeper angle says nothing of the place
_STILL = (0.0, 0.0, 0.0)
_LOCAL, _BODY = mav.MAV_FRAME_LOCAL_NED, mav.MAV_FRAME_BODY_FRD


class LandingTargetService:
    """Passes the target's place on; a report that is incomplete or out of range is dropped whole.

    Its sender gets a text with the reason.

    A report has a position, in the local frame as PX4 wants it or relative to the body, or the two
    angles at which a camera that looks down sees the target, right and up in its image.
    """

    def __init__(self, view: VehicleView) -> None:
        self._view = view
        self.handlers: Mapping[str, Handler] = {"LANDING_TARGET": self._on_target}

    def _on_target(self, _: Channel, message: Message) -> str | None:
        position_ned_m = self._position(message)
        if position_ned_m is None or not all(abs(c) <= _FARTHEST_M for c in position_ned_m):
            return f"no position in frame {_LOCAL} or {_BODY} in range, and no angles in range"
        v = self._view
        v.autopilot.landing_target.receive(v.enu_from_ned(position_ned_m), _STILL, v.plant.time_us)
        return None

    def _position(self, m: Message) -> Vector3 | None:
        if m.position_valid:
            if m.frame == _LOCAL:
                return (m.x, m.y, m.z)
            return self._beside(m.x, m.y, m.z) if m.frame == _BODY else None
        # Without a distance in the message the rangefinder scales the angles.
        height_m = m.distance if m.distance > 0.0 else self._view.plant.sensors.range_m
        if not max(abs(m.angle_x), abs(m.angle_y)) <= _STEEPEST_RAD or not math.isfinite(height_m):
            return None
        # The image's top points forward: a target below its centre is behind the vehicle.
        forward_m, right_m = -height_m * math.tan(m.angle_y), height_m * math.tan(m.angle_x)
        return self._beside(forward_m, right_m, height_m)

    def _beside(self, forward_m: float, right_m: float, down_m: float) -> Vector3:
        """Return the local NED position of an offset from the vehicle, along its heading."""
        north_m, east_m, below_m = self._view.position_ned_m
        yaw_rad = self._view.rpy_rad[2]
        c, s = math.cos(yaw_rad), math.sin(yaw_rad)
        return (
            north_m + c * forward_m - s * right_m,
            east_m + s * forward_m + c * right_m,
            below_m + down_m,
        )
