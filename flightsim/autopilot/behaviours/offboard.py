"""Offboard mode: passes a companion's setpoints on, within the vehicle's speed limits."""

from __future__ import annotations

from dataclasses import replace
from math import hypot, isfinite, isnan

from autonomy.types import IDLE, ControlLevel, Setpoint, Vector3
from flightsim.autopilot.flight_context import FlightContext
from flightsim.autopilot.modes import Mode

# Differences that count as up or down: frames of companion and vehicle drift against each other.
_CLIMB_MARGIN_M = 0.15
_CLIMB_MARGIN_MPS = 0.05


class Offboard:
    """Follow the latest offboard setpoint; a failsafe handles the loss of the stream.

    Setpoints pass unchanged, except that velocities are cut to MPC_XY_VEL_MAX and the greatest
    speeds up and down.
    """

    is_landing = False

    def __init__(self, flight: FlightContext) -> None:
        self._flight = flight
        self._seen: Setpoint | None = None
        self._limited: Setpoint = IDLE
        self.next_mode: Mode | None = None

    @property
    def may_rest(self) -> bool:
        """True if the setpoint leads down, by its velocity or its height.

        Only then may contact with the ground be a landing; a companion that hovers near the ground
        flies on.
        """
        setpoint = self._flight.offboard.setpoint
        if setpoint is None or setpoint.level != ControlLevel.TRAJECTORY:
            return False
        z, up_mps = setpoint.position_enu_m[2], setpoint.velocity_enu_mps[2]
        if up_mps < -_CLIMB_MARGIN_MPS:
            return True
        return z < self._flight.vehicle.position_enu_m[2] - _CLIMB_MARGIN_M and not up_mps > 0.0

    def ready_to_lift(self) -> bool:
        """Return true if the setpoint leads up, or commands thrust.

        Small differences do not count, since the frames of companion and vehicle drift against each
        other.
        """
        setpoint = self._flight.offboard.setpoint
        if setpoint is None:
            return False
        if setpoint.level in {ControlLevel.ATTITUDE, ControlLevel.RATE}:
            return setpoint.thrust > 0.0
        if setpoint.level != ControlLevel.TRAJECTORY:
            return False
        z = setpoint.position_enu_m[2]
        up_mps = setpoint.velocity_enu_mps[2]
        if not isnan(z):
            above_m = z - self._flight.vehicle.position_enu_m[2]
            # A place below leads down, whatever its speed: frames drift against each other.
            is_rising = up_mps > _CLIMB_MARGIN_MPS and above_m > -_CLIMB_MARGIN_M
            return above_m > _CLIMB_MARGIN_M or is_rising
        if not isnan(up_mps):
            return up_mps > _CLIMB_MARGIN_MPS
        return setpoint.acceleration_enu_mps2[2] > 0.0

    def start(self) -> None:
        """Do nothing: the stream holds all state."""

    def start_turn(self) -> None:
        """Be ready to turn to a heading that a client asks for, from the vehicle's own heading."""
        if not self._flight.heading.is_asked:
            self._flight.heading.reset(self._flight.vehicle.yaw_rad)

    def update(self) -> Setpoint:
        """Return the latest setpoint, turned to a client's heading if it has none itself.

        A client may ask for a heading beside the stream; a stream with a heading of its own takes
        it over.
        """
        flight = self._flight
        setpoint = flight.offboard.setpoint
        # A stream without any setpoint yet: brake along the path and stay.
        if setpoint is None:
            flight.path.reset(flight.vehicle.position_enu_m, flight.vehicle.velocity_enu_mps)
            return flight.follow_path()
        # Setpoints are immutable, so limits are applied once for each new one.
        if setpoint is not self._seen:
            self._seen = setpoint
            self._limited = self._within_limits(setpoint)
            flight.target_enu_m = _finite(setpoint.position_enu_m)
        heading = flight.heading
        if not heading.is_asked:
            return self._limited
        # A stream that commands a heading takes over from the client's request.
        if not _leaves_heading_free(setpoint):
            heading.forget_request()
            return self._limited
        flight.turn()
        turned = {"yaw_rad": heading.yaw_rad, "yaw_rate_radps": heading.yaw_rate_radps}
        return replace(self._limited, **turned)

    def _within_limits(self, setpoint: Setpoint) -> Setpoint:
        """Limit a setpoint of bare velocity to the vehicle's maxima; others pass unchanged."""
        if setpoint.level != ControlLevel.TRAJECTORY:
            return setpoint
        p = self._flight.parameters
        vx, vy, vz = setpoint.velocity_enu_mps
        speed = hypot(vx, vy)
        # Both parts shrink alike, so that the direction stays; NaN compares false and stays NaN.
        share = p["MPC_XY_VEL_MAX"] / speed if speed > p["MPC_XY_VEL_MAX"] else 1.0
        up = vz if isnan(vz) else min(max(vz, -p["MPC_Z_VEL_MAX_DN"]), p["MPC_Z_VEL_MAX_UP"])
        if share == 1.0 and (up == vz or isnan(vz)):
            return setpoint
        return replace(setpoint, velocity_enu_mps=(vx * share, vy * share, up))


def _leaves_heading_free(setpoint: Setpoint) -> bool:
    is_trajectory = setpoint.level == ControlLevel.TRAJECTORY
    return is_trajectory and isnan(setpoint.yaw_rad) and not setpoint.yaw_rate_radps


def _finite(position_enu_m: Vector3) -> Vector3 | None:
    return position_enu_m if all(isfinite(c) for c in position_enu_m) else None
