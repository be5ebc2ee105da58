"""Precision landing onto a target whose place a companion reports, such as a marker in its images.

While the target is seen, the vehicle goes above it before it goes down. If the target is lost on
the way, the vehicle assumes that it stays where it was. If it is not seen at all, the vehicle waits
for it or lands in the ordinary way.
"""

from __future__ import annotations

from enum import IntEnum, unique
from math import hypot

from autonomy.types import Setpoint, Vector3
from flightsim.autopilot.behaviours.land import Land, landing_speed
from flightsim.autopilot.events import Severity
from flightsim.autopilot.flight_context import FlightContext
from flightsim.autopilot.modes import Mode
from flightsim.autopilot.vehicle import TICK_S

_AHEAD_M = 2.0
"""Distance below the reference at which the descent aims, so that it follows a target that moves.
"""
_DESCENDING_FACTOR = 2.0
"""Factor on the offset at which a descent begins; beyond it the descent is interrupted. It is above
1, so that the vehicle does not alternate between both at the edge."""


@unique
class Precision(IntEnum):
    """Dependence of a landing on the target, by the numbers of MAVLink's PRECISION_LAND_MODE."""

    NONE = 0
    OPPORTUNISTIC = 1
    """Land on the target if it is seen at the start."""
    REQUIRED = 2
    """Land on the target, and wait for it."""


class PrecisionLand:
    """Land on the target of `flight.landing_target`.

    The descent begins within PLD_HACC_RAD of the target, and is interrupted beyond twice that.
    """

    def __init__(
        self,
        flight: FlightContext,
        place_enu_m: tuple[float, float] | None = None,
        *,
        is_required: bool = True,
    ) -> None:
        """Prepare to land.

        Args:
            flight: Shared state.
            place_enu_m: East and north where the target is expected; None is here.
            is_required: True waits for a target that is not seen, for PLD_SRCH_TOUT.
        """
        self._flight = flight
        self._expected_enu_m = place_enu_m
        self._is_required = is_required
        self._waited_s = 0.0
        self._height_enu_m = 0.0
        self._blind: Land | None = None
        self._is_descending = False
        self.next_mode: Mode | None = None

    @property
    def is_landing(self) -> bool:
        """True while it descends."""
        return self._is_descending if self._blind is None else self._blind.is_landing

    @property
    def may_rest(self) -> bool:
        """True once it descends, so that the rotors may idle at contact."""
        return self.is_landing

    def ready_to_lift(self) -> bool:
        """Never take off."""
        return False

    def start(self) -> None:
        """Choose where to wait for the target: at this height, above its expected place."""
        flight = self._flight
        x, y, self._height_enu_m = flight.path.stopping_point(flight.limits.automatic)
        self._expected_enu_m = self._expected_enu_m or (x, y)
        self._blind, self._is_descending, self._waited_s = None, False, 0.0
        flight.heading.goal_yaw_rad = flight.heading.yaw_rad

    def update(self) -> Setpoint:
        """Fly above the target and down, or land where it was expected if it is not seen.

        Once it has given the target up, it lands as `Land` does and takes no notice of later
        reports.
        """
        if self._blind is not None:
            return self._blind.update()
        target = self._flight.landing_target.at(self._flight.vehicle.time_us)
        if target is not None:
            return self._approach(target)
        return self._wait()

    def _approach(self, target_enu_m: Vector3) -> Setpoint:
        flight = self._flight
        x, y, _ = target_enu_m
        self._expected_enu_m = (x, y)
        px, py, _ = flight.vehicle.position_enu_m
        near_m = flight.parameters["PLD_HACC_RAD"]
        near_m *= _DESCENDING_FACTOR if self._is_descending else 1.0
        was_descending, self._is_descending = self._is_descending, hypot(px - x, py - y) < near_m
        z = flight.path.position_enu_m[2]
        # Interrupted: wait at this height until the vehicle is above the target again.
        if was_descending and not self._is_descending:
            self._height_enu_m = z
        goal = (x, y, z - _AHEAD_M if self._is_descending else self._height_enu_m)
        flight.target_enu_m = goal
        flight.path.fly_to(goal, flight.limits.automatic)
        if self._is_descending:
            flight.path.speed_limit_mps = landing_speed(flight)
        return flight.follow_path()

    def _wait(self) -> Setpoint:
        """Wait where the target is expected; land there when that takes too long."""
        flight, place = self._flight, self._expected_enu_m
        assert place is not None
        goal = (*place, self._height_enu_m)
        # Lost on the way down: no search, because the descent has brought the vehicle above it.
        is_seen_before = self._is_descending
        if not is_seen_before and self._is_required:
            flight.target_enu_m = goal
            flight.path.fly_to(goal, flight.limits.automatic)
            if flight.path.is_at_rest:
                self._waited_s += TICK_S
            if self._waited_s < flight.parameters["PLD_SRCH_TOUT"]:
                return flight.follow_path()
        flight.events.report(Severity.WARNING, "Landing target not seen: landing without it")
        self._blind = Land(flight, place)
        self._blind.start()
        return self._blind.update()
