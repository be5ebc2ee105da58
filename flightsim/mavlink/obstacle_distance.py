"""OBSTACLE_DISTANCE: a companion's report of obstacles around, for collision prevention."""

from __future__ import annotations

import math
from collections.abc import Mapping

from flightsim.frames import swap_yaw_enu_ned
from flightsim.mavlink.channel import Channel
from flightsim.mavlink.dialect import dialect as mav
from flightsim.mavlink.parsing import Message
from flightsim.mavlink.service import Handler
from flightsim.mavlink.view import VehicleView

_UNKNOWN = 0xFFFF
_LEAST_STEP_DEG, _MOST_STEP_DEG = 1.0, 120.0
_BODY = mav.MAV_FRAME_BODY_FRD
_NORTH = frozenset({mav.MAV_FRAME_GLOBAL, mav.MAV_FRAME_LOCAL_NED, mav.MAV_FRAME_LOCAL_FRD})


class ObstacleDistanceService:
    """Passes reports on; one with an impossible step or in an unknown frame is dropped whole.

    Its sender gets a text with the reason.
    """

    def __init__(self, view: VehicleView) -> None:
        self._view = view
        self.handlers: Mapping[str, Handler] = {"OBSTACLE_DISTANCE": self._on_distances}

    def _on_distances(self, _: Channel, message: Message) -> str | None:
        v = self._view
        # `increment_f` is finer and comes with MAVLink 2 only; 0 there means "not given".
        step_deg = message.increment_f or float(message.increment)
        is_step = _LEAST_STEP_DEG <= abs(step_deg) <= _MOST_STEP_DEG
        if not is_step or not abs(message.angle_offset) <= 360.0:
            return f"step of {step_deg:g} deg from {message.angle_offset:g} deg is out of range"
        if message.frame not in _NORTH and message.frame != _BODY:
            return f"frame {message.frame}; valid are 0, {_BODY} and local ones"
        ahead_rad = v.rpy_rad[2] if message.frame == _BODY else 0.0
        first_rad = swap_yaw_enu_ned(ahead_rad + math.radians(message.angle_offset))
        v.autopilot.collision_prevention.receive(
            [_distance_m(cm, message.max_distance) for cm in message.distances],
            first_rad,
            # Sectors count clockwise, ENU angles counter-clockwise.
            -math.radians(step_deg),
            v.plant.estimate.position_enu_m,
            v.plant.time_us,
        )
        return None


def _distance_m(distance_cm: int, max_distance_cm: int) -> float:
    """Return the distance of an obstacle in m; infinite if none is in range, NaN if unknown."""
    if distance_cm == _UNKNOWN:
        return math.nan
    return math.inf if distance_cm > max_distance_cm else 0.01 * distance_cm
