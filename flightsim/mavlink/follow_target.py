"""FOLLOW_TARGET: position and velocity of the target that follow mode follows."""

from __future__ import annotations

from collections.abc import Mapping

from flightsim.frames import Geodetic, swap_enu_ned
from flightsim.mavlink.channel import Channel
from flightsim.mavlink.parsing import Message
from flightsim.mavlink.service import Handler
from flightsim.mavlink.view import VehicleView

# Beyond these the report is a mistake, and the vehicle must not set out for it.
_FARTHEST_M = 1e5
_FASTEST_MPS = 100.0
# Bits of est_capabilities.
_HAS_POSITION, _HAS_VELOCITY = 1, 2


class FollowTargetService:
    """Passes the target's reports on; one that is incomplete or out of range is dropped whole.

    Its sender gets a text with the reason.
    """

    def __init__(self, view: VehicleView) -> None:
        self._view = view
        self.handlers: Mapping[str, Handler] = {"FOLLOW_TARGET": self._on_target}

    def _on_target(self, _: Channel, message: Message) -> str | None:
        latitude_deg, longitude_deg = message.lat * 1e-7, message.lon * 1e-7
        is_place = abs(latitude_deg) <= 90.0 and abs(longitude_deg) <= 180.0
        if not message.est_capabilities & _HAS_POSITION or not is_place:
            return "no position in range, or est_capabilities without bit 1"
        place = Geodetic(latitude_deg, longitude_deg, message.alt)
        position_enu_m = self._view.frame.enu_from_geodetic(place)
        if not all(abs(c) <= _FARTHEST_M for c in position_enu_m):
            return f"the target is farther than {_FARTHEST_M / 1e3:g} km away"
        has_velocity = message.est_capabilities & _HAS_VELOCITY
        vx, vy, vz = message.vel if has_velocity else (0.0, 0.0, 0.0)
        if not all(abs(c) <= _FASTEST_MPS for c in (vx, vy, vz)):
            return f"the target is faster than {_FASTEST_MPS:g} m/s"
        self._view.autopilot.follow_target.receive(
            position_enu_m, swap_enu_ned((vx, vy, vz)), self._view.plant.time_us
        )
        return None
