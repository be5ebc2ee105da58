"""Reference motion around a circle, whose speed builds up and fades smoothly."""

from __future__ import annotations

from math import atan2, cos, pi, sin, sqrt

from autonomy.types import Vector3
from flightsim.autopilot.axis import AxisMotion
from flightsim.autopilot.limits import MotionLimits


class CircleMotion:
    """A point that moves on a horizontal circle; its arc length follows the law of `AxisMotion`."""

    def __init__(self, centre_enu_m: Vector3, radius_m: float, *, is_clockwise: bool) -> None:
        self.centre_enu_m = centre_enu_m
        self.radius_m = radius_m
        self._sign = -1.0 if is_clockwise else 1.0
        self._start_rad = 0.0
        self._arc = AxisMotion()
        """Arc length from the start in m, in the direction of flight."""

    @property
    def angle_rad(self) -> float:
        """Direction from the centre to the point, rad counter-clockwise from east."""
        return self._start_rad + self._sign * self._arc.x / self.radius_m

    @property
    def turns(self) -> float:
        """Number of turns flown so far, as a fraction."""
        return self._arc.x / (2.0 * pi * self.radius_m)

    def entry_from(self, position_enu_m: Vector3) -> Vector3:
        """Start at the circle's point nearest to a position, and return that point."""
        x, y, _ = position_enu_m
        cx, cy, cz = self.centre_enu_m
        self._start_rad = atan2(y - cy, x - cx)
        self._arc = AxisMotion()
        return (
            cx + self.radius_m * cos(self._start_rad),
            cy + self.radius_m * sin(self._start_rad),
            cz,
        )

    def step(self, speed_mps: float, limits: MotionLimits, dt: float) -> None:
        """Advance by one tick towards a speed, as far as the centripetal acceleration allows.

        Args:
            speed_mps: Desired speed along the circle, not negative.
            limits: Limits of the motion; the horizontal acceleration is shared between both parts.
            dt: Length of the tick, s.
        """
        # Leave room for the tangential part: 0.8^2 + 0.6^2 = 1.
        speed = min(speed_mps, sqrt(0.8 * limits.acceleration_xy_mps2 * self.radius_m))
        self._arc.step_to_velocity(speed, 0.6 * limits.acceleration_xy_mps2, limits.jerk_mps3, dt)

    def derivatives(self) -> tuple[Vector3, Vector3, Vector3, float]:
        """Position, velocity, acceleration (ENU, SI units) and the rate of the angle, rad/s."""
        angle = self.angle_rad
        c, s = cos(angle), sin(angle)
        v, a, r = self._arc.v * self._sign, self._arc.a * self._sign, self.radius_m
        cx, cy, cz = self.centre_enu_m
        centripetal = v * v / r
        return (
            (cx + r * c, cy + r * s, cz),
            (-v * s, v * c, 0.0),
            (-a * s - centripetal * c, a * c - centripetal * s, 0.0),
            v / r,
        )
