"""Collision prevention: sticks in position mode stop short of obstacles that a companion reports.

As in PX4, it is off until `CP_DIST` says how far to keep away. Once it is on, a direction without a
report is closed, unless `CP_GO_NO_DATA` opens it. Obstacles are stored as points of the world
rather than as bearings, so that they stay right while the vehicle moves between two reports.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import atan2, cos, hypot, isfinite, isnan, pi, sin

from autonomy.types import Vector3
from flightsim.autopilot.limits import MotionLimits, stoppable_speed
from flightsim.autopilot.parameters import Parameters
from flightsim.autopilot.vehicle import Vehicle

_TIMEOUT_US = 500_000
"""Age beyond which a report no longer counts."""
_REACTION_S = 0.4
"""Time in which the vehicle still moves as before, because it follows its reference with a lag."""
_BRAKE_SHARE = 0.5
"""Fraction of the acceleration that braking counts on: the reference follows a falling limit late.
"""


class CollisionPrevention:
    """The latest reported obstacles around the vehicle, and the speed that they allow."""

    def __init__(self, parameters: Parameters) -> None:
        self._parameters = parameters
        self._obstacles_en_m: list[tuple[float, float]] = []
        self._blind_rad: list[float] = []
        self._half_sector_rad = pi
        self._received_us: int | None = None

    def receive(
        self,
        distances_m: Sequence[float],
        first_rad: float,
        step_rad: float,
        position_enu_m: Vector3,
        time_us: int,
    ) -> None:
        """Accept a report, which replaces the one before.

        Args:
            distances_m: Distance of the nearest obstacle in each sector; infinite for none, NaN
                where nothing is known.
            first_rad: Bearing of the first sector's middle, counter-clockwise from east.
            step_rad: Bearing from one sector to the next, and the width of each; not zero.
            position_enu_m: Position of the vehicle at the time of the report.
            time_us: That time.
        """
        east_m, north_m, _ = position_enu_m
        self._obstacles_en_m.clear()
        self._blind_rad.clear()
        self._half_sector_rad = 0.5 * abs(step_rad)
        # A message may hold more sectors than a turn has; the rest would count bearings twice.
        n_sectors = min(len(distances_m), round(2.0 * pi / abs(step_rad)))
        for sector, distance_m in enumerate(distances_m[:n_sectors]):
            bearing_rad = first_rad + sector * step_rad
            if isnan(distance_m):
                self._blind_rad.append(bearing_rad)
            elif isfinite(distance_m):
                direction = (cos(bearing_rad), sin(bearing_rad))
                self._obstacles_en_m.append(
                    (east_m + distance_m * direction[0], north_m + distance_m * direction[1])
                )
        self._blind_rad += _outside(first_rad, step_rad, n_sectors)
        self._received_us = time_us

    def allowed_share(
        self,
        wished_en_mps: tuple[float, float],
        vehicle: Vehicle,
        limits: MotionLimits,
    ) -> float:
        """Share of a wished horizontal velocity that is safe, 0 to 1.

        The whole velocity is scaled, so that its direction stays as the pilot wishes it.

        Args:
            wished_en_mps: Wished velocity east and north.
            vehicle: Present position and velocity.
            limits: Limits within which the reference can brake.

        Returns:
            1 if CP_DIST is negative (off), 0 if nothing is known of that direction.
        """
        keep_m = self._parameters["CP_DIST"]
        if keep_m < 0.0 or hypot(*wished_en_mps) == 0.0:
            return 1.0
        if self._is_blind(atan2(wished_en_mps[1], wished_en_mps[0]), vehicle.time_us):
            return 0.0
        brake_mps2 = _BRAKE_SHARE * limits.acceleration_xy_mps2
        share = 1.0
        for obstacle_en_m in self._obstacles_en_m:
            distance_m, towards = _direction(vehicle.position_enu_m, obstacle_en_m)
            wished_mps = _along(wished_en_mps, towards)
            if wished_mps > 0.0:
                # Only the present speed towards the obstacle takes up room; moving away gives none
                # back.
                reaction_m = _REACTION_S * max(0.0, _along(vehicle.velocity_enu_mps, towards))
                room_m = distance_m - keep_m - reaction_m
                safe_mps = stoppable_speed(room_m, brake_mps2, limits.jerk_mps3)
                share = min(share, safe_mps / wished_mps)
        return share

    def _is_blind(self, bearing_rad: float, time_us: int) -> bool:
        """Return true if nothing is known of a bearing and blind flight is not allowed."""
        if self._parameters["CP_GO_NO_DATA"]:
            return False
        if self._received_us is None or time_us - self._received_us > _TIMEOUT_US:
            return True
        return any(
            abs((blind_rad - bearing_rad + pi) % (2.0 * pi) - pi) <= self._half_sector_rad
            for blind_rad in self._blind_rad
        )


def _direction(
    position_enu_m: Vector3, obstacle_en_m: tuple[float, float]
) -> tuple[float, tuple[float, float]]:
    """Horizontal distance of an obstacle, and the unit vector to it."""
    east_m, north_m = (obstacle_en_m[i] - position_enu_m[i] for i in (0, 1))
    distance_m = max(hypot(east_m, north_m), 1e-6)  # no division by zero at an obstacle
    return distance_m, (east_m / distance_m, north_m / distance_m)


def _along(velocity: Sequence[float], direction: tuple[float, float]) -> float:
    return velocity[0] * direction[0] + velocity[1] * direction[1]


def _outside(first_rad: float, step_rad: float, n_sectors: int) -> list[float]:
    """Bearings of the middles of the sectors that the report does not cover."""
    n_all = round(2.0 * pi / abs(step_rad))
    return [first_rad + sector * step_rad for sector in range(n_sectors, n_all)]
