"""State of the vehicle itself from which a plan made in flight can begin."""

from __future__ import annotations

import math

from autonomy.planning import FlightLimits
from autonomy.types import FlatReference, Vector3
from scenarios.pilot.flight_state import FlightState


def state_at_take_over(flight: FlightState) -> FlatReference:
    """Return the vehicle's state when a plan made now takes over, at its present velocity.

    Its heading is that of the course. Its speed is at most that with which a plan may begin.
    """
    telemetry = flight.telemetry
    lead_s = (flight.take_over_us - flight.time_us) * 1e-6
    (x, y, z), (u, v, w) = telemetry.position_enu_m, telemetry.velocity_enu_mps
    return FlatReference(
        position_enu_m=(x + u * lead_s, y + v * lead_s, z + w * lead_s),
        velocity_enu_mps=_within(flight.mission.surroundings.limits, (u, v, w)),
        yaw_rad=flight.setpoint.yaw_rad,
    )


def _within(limits: FlightLimits, velocity_enu_mps: Vector3) -> Vector3:
    """Return the same velocity, reduced to one that the limits allow."""
    u, v, w = velocity_enu_mps
    share = min(
        1.0,
        limits.speed_horizontal_mps / max(math.hypot(u, v), 1e-6),
        limits.speed_vertical_mps / max(abs(w), 1e-6),
    )
    return (share * u, share * v, share * w)
