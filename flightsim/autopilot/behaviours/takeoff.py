"""Takeoff mode: straight up, then hold or the mission."""

from __future__ import annotations

from autonomy.types import Setpoint, Vector3
from flightsim.autopilot.events import Severity
from flightsim.autopilot.flight_context import FlightContext
from flightsim.autopilot.modes import Mode

_ARRIVED_M = 0.5  # the vehicle itself must be so near, not its reference alone


class Takeoff:
    """Climb to a height, then fly to a place at that height if one is given.

    At the end the vehicle holds, or begins the mission if COM_TAKEOFF_ACT says so and there is one.
    """

    is_landing = False
    may_rest = False

    def __init__(
        self,
        flight: FlightContext,
        height_enu_m: float | None = None,
        yaw_rad: float | None = None,
        place_enu_m: tuple[float, float] | None = None,
    ) -> None:
        """Prepare to take off.

        Args:
            flight: Shared state.
            height_enu_m: ENU height to climb to; None climbs by MIS_TAKEOFF_ALT.
            yaw_rad: Heading to turn to; None keeps the present one.
            place_enu_m: East and north of the final position; None stays above the start.
        """
        self._flight = flight
        self._height_enu_m = height_enu_m
        self._yaw_rad = yaw_rad
        self._place_enu_m = place_enu_m
        self._target_enu_m: Vector3 | None = None
        self.next_mode: Mode | None = None

    def ready_to_lift(self) -> bool:
        """Take off at once."""
        return True

    def start(self) -> None:
        """Set the goal above the point where the vehicle can stop, never below it."""
        flight = self._flight
        x, y, _ = flight.path.stopping_point(flight.limits.takeoff)
        here_m = flight.path.position_enu_m[2]
        height_m = self._height_enu_m
        if height_m is None:
            height_m = here_m + flight.parameters["MIS_TAKEOFF_ALT"]
        elif height_m < here_m and not flight.vehicle.is_landed:
            flight.events.report(Severity.WARNING, "Already higher than takeoff altitude")
        self._target_enu_m = (x, y, max(height_m, here_m))
        flight.heading.goal_yaw_rad = (
            flight.heading.yaw_rad if self._yaw_rad is None else self._yaw_rad
        )

    def update(self) -> Setpoint:
        """Climb to the goal, fly to the place if there is one, and choose the next mode.

        The goal is reached if the reference rests there and the vehicle itself is within 0.5 m of
        its height.
        """
        flight = self._flight
        target = self._target_enu_m
        assert target is not None
        flight.target_enu_m = target
        flight.path.fly_to(target, flight.limits.takeoff)
        setpoint = flight.follow_path()
        left_m = abs(flight.vehicle.position_enu_m[2] - target[2])
        if flight.path.is_at_rest and left_m < _ARRIVED_M and not flight.vehicle.is_landed:
            if self._place_enu_m is not None:
                self._target_enu_m = (*self._place_enu_m, target[2])
                self._place_enu_m = None
                return setpoint
            has_mission = flight.parameters["COM_TAKEOFF_ACT"] == 1 and len(flight.mission) > 0
            self.next_mode = Mode.MISSION if has_mission else Mode.HOLD
        return setpoint
