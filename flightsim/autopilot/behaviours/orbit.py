"""Orbit mode: circle a centre, facing it."""

from __future__ import annotations

from math import atan2

from autonomy.types import Setpoint, Vector3
from flightsim.autopilot.circle import CircleMotion
from flightsim.autopilot.flight_context import FlightContext
from flightsim.autopilot.heading import wrap_angle
from flightsim.autopilot.modes import Mode
from flightsim.autopilot.vehicle import TICK_S


class Orbit:
    """Fly to the nearest point of a circle, then around it until another mode is requested.

    The vehicle faces the centre all the time.
    """

    is_landing = False
    may_rest = False

    def __init__(
        self,
        flight: FlightContext,
        centre_enu_m: Vector3,
        radius_m: float,
        speed_mps: float,
        *,
        is_clockwise: bool,
    ) -> None:
        """Prepare to orbit.

        Args:
            flight: Shared state.
            centre_enu_m: Centre, at the height of the circle.
            radius_m: Radius of the circle.
            speed_mps: Speed along the circle; it is cut to the vehicle's limit.
            is_clockwise: Direction, as seen from above.
        """
        self._flight = flight
        self._circle = CircleMotion(centre_enu_m, radius_m, is_clockwise=is_clockwise)
        self._speed_mps = speed_mps
        self._entry_enu_m: Vector3 | None = None
        self.is_circling = False
        self.next_mode: Mode | None = None

    @property
    def turns(self) -> float:
        """Turns flown so far, as a fraction; 0 before the circle is reached.

        A mission counts them to end an item of so many turns.
        """
        return self._circle.turns if self.is_circling else 0.0

    def ready_to_lift(self) -> bool:
        """Take off at once."""
        return True

    def start(self) -> None:
        """Choose the point where to enter the circle."""
        self._entry_enu_m = self._circle.entry_from(self._flight.path.position_enu_m)
        self.is_circling = False

    def update(self) -> Setpoint:
        """Approach the circle, then follow it.

        The vehicle stops at the circle before it goes around, since the circle's own motion starts
        from rest.
        """
        flight, circle = self._flight, self._circle
        entry = self._entry_enu_m
        assert entry is not None
        flight.target_enu_m = circle.centre_enu_m
        self._face_centre()
        if not self.is_circling:
            flight.path.fly_to(entry, flight.limits.automatic)
            # From rest at the entry: the circle's own motion starts without velocity.
            self.is_circling = flight.path.is_at_rest
            return flight.follow_path()
        limits = flight.limits.automatic
        circle.step(min(self._speed_mps, limits.speed_xy_mps), limits, TICK_S)
        position, velocity, acceleration, _ = circle.derivatives()
        flight.turn()
        return flight.follow(position, velocity, acceleration)

    def _face_centre(self) -> None:
        x, y, _ = self._flight.path.position_enu_m
        cx, cy, _ = self._circle.centre_enu_m
        # Within 0.1 m of the centre its direction is not defined.
        if (x - cx) ** 2 + (y - cy) ** 2 > 0.01:
            self._flight.heading.goal_yaw_rad = wrap_angle(atan2(cy - y, cx - x))
