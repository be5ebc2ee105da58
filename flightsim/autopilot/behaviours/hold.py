"""Hold mode: stay, or go to a place and stay there."""

from __future__ import annotations

from math import isnan

from autonomy.types import Setpoint, Vector3
from flightsim.autopilot.flight_context import FlightContext
from flightsim.autopilot.modes import Mode

_TAKEOFF_MARGIN_M = 0.5
"""Height of a target above a landed vehicle that makes it take off."""


class Hold:
    """Stop and stay, or fly straight to a target and stay there.

    On the way the vehicle faces the target, unless a heading is given or a client asks for one.
    """

    is_landing = False
    may_rest = False

    def __init__(
        self,
        flight: FlightContext,
        target_enu_m: Vector3 | None = None,
        yaw_rad: float | None = None,
    ) -> None:
        """Prepare to hold.

        Args:
            flight: Shared state.
            target_enu_m: Position to fly to; NaN keeps that coordinate. None stays.
            yaw_rad: Heading to turn to; None faces the target.
        """
        self._flight = flight
        self._target_enu_m = target_enu_m
        self._yaw_rad = yaw_rad
        self._faces_target = target_enu_m is not None and yaw_rad is None
        self.next_mode: Mode | None = None

    def ready_to_lift(self) -> bool:
        """Take off only for a target well above the vehicle.

        A target at the vehicle's own height, such as a repeated request to hold, leaves it on the
        ground.
        """
        target = self._target_enu_m
        if target is None:
            return False
        return target[2] > self._flight.vehicle.position_enu_m[2] + _TAKEOFF_MARGIN_M

    def start_turn(self) -> None:
        """Stop facing the target, because a client asks for a heading."""
        self._faces_target = False

    def start(self) -> None:
        """Set the goal of the flight: the target, or the point where the vehicle can stop.

        The heading stays, unless one was given.
        """
        flight = self._flight
        here = flight.path.position_enu_m
        target = self._target_enu_m
        if target is None:
            target = flight.path.stopping_point(flight.limits.automatic)
        else:
            x, y, z = (h if isnan(t) else t for t, h in zip(target, here, strict=True))
            target = (x, y, z)
        self._target_enu_m = target
        flight.heading.goal_yaw_rad = flight.heading.yaw_rad
        if self._yaw_rad is not None:
            flight.heading.goal_yaw_rad = self._yaw_rad

    def update(self) -> Setpoint:
        """Fly to the goal and stay there."""
        flight = self._flight
        target = self._target_enu_m
        assert target is not None
        flight.target_enu_m = target
        flight.path.fly_to(target, flight.limits.automatic)
        if self._faces_target:
            flight.face(target)
        return flight.follow_path()
