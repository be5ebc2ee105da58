"""Waypoint leg of a mission: fly to it, then wait there or continue around the corner."""

from __future__ import annotations

from math import hypot, radians

from autonomy.types import Setpoint, Vector3
from flightsim.autopilot.flight_context import FlightContext
from flightsim.autopilot.limits import corner_speed
from flightsim.autopilot.modes import Mode
from flightsim.autopilot.trajectory import direction_between
from flightsim.autopilot.vehicle import TICK_S

_MAX_LAG_M = 0.5  # the vehicle may be so far behind its reference when the next leg begins


class WaypointLeg:
    """One leg of a mission, to a waypoint.

    `is_done` once the waypoint was accepted and the hold time has passed. A waypoint to be passed
    without a stop is done earlier: once the reference may turn onto the next line, with the vehicle
    close behind.
    """

    is_landing = False
    may_rest = False

    def __init__(
        self,
        flight: FlightContext,
        goal_enu_m: Vector3,
        *,
        radius_m: float,
        hold_s: float = 0.0,
        yaw_rad: float | None = None,
        line_start_enu_m: Vector3 | None = None,
        next_goal_enu_m: Vector3 | None = None,
    ) -> None:
        """Prepare to fly to the waypoint.

        Args:
            flight: Shared state.
            goal_enu_m: The waypoint.
            radius_m: Horizontal distance at which it counts as reached.
            hold_s: Time to stay within that distance.
            yaw_rad: Heading to turn to; None follows MPC_YAW_MODE.
            line_start_enu_m: Start of the line to follow; None is the present reference.
            next_goal_enu_m: Next waypoint if this one is to be passed without a stop.
        """
        self._flight = flight
        self._goal_enu_m = goal_enu_m
        self._radius_m = radius_m
        self._hold_s = hold_s
        self._yaw_rad = yaw_rad
        self._line_start_enu_m = line_start_enu_m
        self._next_goal_enu_m = next_goal_enu_m
        self._turn_radius_m = radius_m
        self._limits = flight.limits.automatic
        self._exit_speed_mps = 0.0
        self._waited_s = 0.0
        self._turned_s = 0.0
        self._is_accepted = False
        self.is_done = False
        self.next_mode: Mode | None = None

    def ready_to_lift(self) -> bool:
        """Take off at once."""
        return True

    def start(self) -> None:
        """Choose the speed at the waypoint, and the heading.

        The speed is 0 if the vehicle is to stop there, else the greatest for the turn
        (`corner_speed`).
        """
        heading = self._flight.heading
        heading.goal_yaw_rad = heading.yaw_rad if self._yaw_rad is None else self._yaw_rad
        self._plan_exit()

    def update(self) -> Setpoint:
        """Fly the leg; sets `is_done` at its end.

        A change of the limits, such as a new cruise speed, plans the rest of the leg anew.
        """
        flight = self._flight
        # Limits are the same object until one changes, so that a new speed replans the exit.
        if flight.limits.automatic is not self._limits:
            self._plan_exit()
        flight.target_enu_m = self._goal_enu_m
        flight.path.fly_to(
            self._goal_enu_m,
            self._limits,
            line_start_enu_m=self._line_start_enu_m,
            exit_speed_mps=self._exit_speed_mps,
        )
        if self._yaw_rad is None:
            flight.face(self._goal_enu_m)
        setpoint = flight.follow_path()
        self.is_done = self._passes() if self._next_goal_enu_m is not None else self._waits()
        return setpoint

    def _plan_exit(self) -> None:
        self._limits = self._flight.limits.automatic
        self._exit_speed_mps = 0.0
        if self._next_goal_enu_m is None:
            return
        start = self._line_start_enu_m or self._flight.path.position_enu_m
        arriving = direction_between(start, self._goal_enu_m)
        leaving = direction_between(self._goal_enu_m, self._next_goal_enu_m)
        if arriving is None or leaving is None:
            return
        # At most half of the line, so that two turns at its ends do not overlap.
        self._turn_radius_m = min(self._radius_m, 0.5 * _distance(start, self._goal_enu_m))
        next_m = _distance(self._goal_enu_m, self._next_goal_enu_m)
        self._exit_speed_mps = corner_speed(
            arriving, leaving, self._turn_radius_m, next_m, self._limits
        )

    def _passes(self) -> bool:
        """Return true if the reference may turn onto the next line, the vehicle close behind."""
        flight = self._flight
        if not self._is_near(self._radius_m + _MAX_LAG_M):
            return False
        reference = flight.path.position_enu_m
        left_m = hypot(reference[0] - self._goal_enu_m[0], reference[1] - self._goal_enu_m[1])
        # An exit speed of 0 stops at the waypoint first, then turns.
        is_in_turn = left_m <= self._turn_radius_m and self._exit_speed_mps > 0.0
        return is_in_turn or flight.path.is_at_rest

    def _waits(self) -> bool:
        """Return true if the waypoint is reached, the heading taken and the hold time over."""
        if not self._is_accepted:
            self._is_accepted = self._is_near(self._radius_m) and self._has_turned()
        if self._is_accepted:
            self._waited_s += TICK_S
        return self._is_accepted and self._waited_s >= self._hold_s

    def _has_turned(self) -> bool:
        if self._yaw_rad is None:
            return True
        p = self._flight.parameters
        self._turned_s += TICK_S
        is_turned = self._flight.heading.remaining_rad <= radians(p["MIS_YAW_ERR"])
        # A negative MIS_YAW_TMT waits for the heading without end.
        return is_turned or 0.0 <= p["MIS_YAW_TMT"] <= self._turned_s

    def _is_near(self, radius_m: float) -> bool:
        x, y, z = self._flight.vehicle.position_enu_m
        gx, gy, gz = self._goal_enu_m
        altitude_m = max(self._flight.parameters["NAV_MC_ALT_RAD"], 0.05)
        return hypot(x - gx, y - gy) <= radius_m and abs(z - gz) <= altitude_m


def _distance(start: Vector3, end: Vector3) -> float:
    return hypot(end[0] - start[0], end[1] - start[1], end[2] - start[2])
