"""Landing: stop above a place and descend ever more slowly until the ground carries the vehicle."""

from __future__ import annotations

from math import hypot

from autonomy.types import Setpoint, Vector3
from flightsim.autopilot.flight_context import FlightContext
from flightsim.autopilot.modes import Mode
from flightsim.autopilot.vehicle import TICK_S

# The goal of a descent lies so far below that the reference never brakes for it.
_FAR_BELOW_M = 500.0
_ABOVE_PLACE_M = 0.5  # horizontal distance from the place within which the descent may begin
_PATIENCE_S = 20.0
"""Longest time beside the place in one landing; the wind may be too strong to stay there."""


class Land:
    """Descend onto a place, or onto the ground below the point where the vehicle can stop.

    The vehicle first flies above the place, and the speed falls with the height (`landing_speed`).
    Three faults let it descend at once: a lost rotor, an estimate that drifts without a position,
    and wind that keeps it away for too long.
    """

    def __init__(
        self,
        flight: FlightContext,
        place_enu_m: tuple[float, float] | None = None,
        yaw_rad: float | None = None,
    ) -> None:
        """Prepare to land.

        Args:
            flight: Shared state.
            place_enu_m: East and north of the place; None lands here.
            yaw_rad: Heading to turn to; None keeps the present one.
        """
        self._flight = flight
        self._place_enu_m = place_enu_m
        self._yaw_rad = yaw_rad
        self._above_enu_m: Vector3 | None = None
        self._away_s = 0.0
        self.is_landing = False
        self.next_mode: Mode | None = None

    @property
    def may_rest(self) -> bool:
        """True once it descends, so that the rotors may idle at contact."""
        return self.is_landing

    def ready_to_lift(self) -> bool:
        """Never take off."""
        return False

    def start(self) -> None:
        """Choose the point to descend from.

        It lies at the height where the vehicle can stop, above the place or, without one, above
        that point.
        """
        flight = self._flight
        x, y, z = flight.path.stopping_point(flight.limits.automatic)
        if self._place_enu_m is not None:
            x, y = self._place_enu_m
        self._above_enu_m = (x, y, z)
        self._away_s = 0.0
        self.is_landing = False
        flight.heading.goal_yaw_rad = (
            flight.heading.yaw_rad if self._yaw_rad is None else self._yaw_rad
        )

    def update(self) -> Setpoint:
        """Fly to above the place, then descend.

        With a rotor lost it descends at once, and so it does where it is if nothing measures the
        position. It also stops waiting for the place if it has been kept away from there for long.
        """
        flight = self._flight
        above = self._above_enu_m
        assert above is not None
        x, y, z = above
        # Nothing measures the position: a place would be followed along a drifting estimate.
        if flight.vehicle.is_dead_reckoning:
            self.is_landing = True
            flight.target_enu_m = None
            return flight.sink_without_position(landing_speed(flight))
        px, py, _ = flight.vehicle.position_enu_m
        is_near = hypot(px - x, py - y) < _ABOVE_PLACE_M
        # Counted only when the reference waits at the place already: the flight there is no delay.
        if not is_near and (self.is_landing or flight.path.is_at_rest):
            self._away_s += TICK_S
        if flight.vehicle.lost_rotors or self._away_s >= _PATIENCE_S:
            self.is_landing = True
            flight.target_enu_m = (x, y, self._ground_m)
            return flight.sink(landing_speed(flight), (x, y))
        if not self.is_landing:
            flight.target_enu_m = above
            flight.path.fly_to(above, flight.limits.automatic)
            self.is_landing = flight.path.is_at_rest and is_near
            return flight.follow_path()
        flight.target_enu_m = (x, y, self._ground_m)
        flight.path.fly_to((x, y, z - _FAR_BELOW_M), flight.limits.automatic)
        # After `fly_to`, which sets the limit of the line.
        flight.path.speed_limit_mps = landing_speed(flight)
        return flight.follow_path()

    @property
    def _ground_m(self) -> float:
        x, y, _ = self._flight.vehicle.position_enu_m
        return self._flight.terrain_m(x, y)


class Descend:
    """Descend without a position: the last resort.

    The vehicle brakes by its velocity while that is known, and is level otherwise.
    """

    is_landing = True
    may_rest = True

    def __init__(self, flight: FlightContext) -> None:
        self._flight = flight
        self.next_mode: Mode | None = None

    def ready_to_lift(self) -> bool:
        """Never take off."""
        return False

    def start(self) -> None:
        """Keep the present heading."""
        flight = self._flight
        flight.heading.goal_yaw_rad = flight.heading.yaw_rad
        flight.target_enu_m = None

    def update(self) -> Setpoint:
        """Return the setpoint of the descent."""
        flight = self._flight
        return flight.sink_without_position(landing_speed(flight))


def landing_speed(flight: FlightContext) -> float:
    """Descent speed at the present height: MPC_Z_V_AUTO_DN far up, MPC_LAND_CRWL at the end."""
    p = flight.parameters
    slow_mps = p["MPC_LAND_SPEED"]
    height_m = flight.vehicle.height_m
    if height_m is not None and height_m < p["MPC_LAND_ALT3"]:
        return min(slow_mps, p["MPC_LAND_CRWL"])
    # Without the rangefinder the height counts from the terrain, and never from close enough to
    # crawl.
    if height_m is None:
        x, y, z = flight.vehicle.position_enu_m
        height_m = z - flight.terrain_m(x, y)
    fast_mps = max(slow_mps, flight.limits.automatic.speed_down_mps)
    low_m, high_m = p["MPC_LAND_ALT2"], p["MPC_LAND_ALT1"]
    # Linear between both heights of MPC_LAND_ALT; the divisor must not vanish.
    share = (height_m - low_m) / max(high_m - low_m, 1e-3)
    return slow_mps + (fast_mps - slow_mps) * min(max(share, 0.0), 1.0)
