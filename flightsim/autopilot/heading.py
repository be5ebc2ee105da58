"""Yaw reference: turns the shorter way within limits of rate and acceleration."""

from __future__ import annotations

from math import pi

from flightsim.autopilot.axis import AxisMotion

_JERK_PER_ACCELERATION = 4.0
"""Ratio that lets the acceleration build up in a quarter of a second."""


def wrap_angle(angle_rad: float) -> float:
    """Return the same angle in [-pi, pi)."""
    return (angle_rad + pi) % (2.0 * pi) - pi


class HeadingMotion:
    """A heading that turns to a goal; angles are ENU, counter-clockwise from east."""

    def __init__(self) -> None:
        self.yaw_rad = 0.0
        self.goal_yaw_rad = 0.0
        self.rate_limit_radps: float | None = None
        """Rate limit below the usual one, if any."""
        self.is_asked = False
        """True if a client asked for the goal; offboard setpoints without a heading keep to it."""
        self._motion = AxisMotion()

    @property
    def yaw_rate_radps(self) -> float:
        """Present rate, counter-clockwise, rad/s."""
        return self._motion.v

    @property
    def remaining_rad(self) -> float:
        """Angle left to the goal, 0 to pi."""
        return abs(wrap_angle(self.goal_yaw_rad - self.yaw_rad))

    def reset(self, yaw_rad: float) -> None:
        """Rest at a heading, and forget a client's request."""
        self.yaw_rad = self.goal_yaw_rad = yaw_rad
        self.forget_request()
        self._motion = AxisMotion()

    def ask(self, yaw_rad: float, rate_limit_radps: float | None) -> None:
        """Turn to a heading because a client asks for it.

        Args:
            yaw_rad: The heading, ENU.
            rate_limit_radps: Greatest rate of this turn; None uses the usual limit.
        """
        self.goal_yaw_rad, self.rate_limit_radps = yaw_rad, rate_limit_radps
        self.is_asked = True

    def forget_request(self) -> None:
        """Go on as if no client had asked for a heading."""
        self.rate_limit_radps = None
        self.is_asked = False

    def step(self, dt: float, rate_max_radps: float, acceleration_max_radps2: float) -> None:
        """Turn for one tick towards the goal.

        Args:
            dt: Length of the tick, s.
            rate_max_radps: Greatest rate.
            acceleration_max_radps2: Greatest angular acceleration.
        """
        motion = self._motion
        # Relative to the goal and wrapped, so that the law of a line turns the shorter way.
        x = wrap_angle(self.yaw_rad - self.goal_yaw_rad)
        if x == 0.0 and motion.v == 0.0 and motion.a == 0.0:
            return
        motion.x = x
        if self.rate_limit_radps is not None:
            rate_max_radps = min(rate_max_radps, self.rate_limit_radps)
        jerk = _JERK_PER_ACCELERATION * acceleration_max_radps2
        motion.step_to_goal(rate_max_radps, acceleration_max_radps2, jerk, dt)
        self.yaw_rad = wrap_angle(self.goal_yaw_rad + motion.x)

    def step_rate(self, rate_radps: float, dt: float, acceleration_max_radps2: float) -> None:
        """Turn for one tick at a given rate; the goal moves along.

        Args:
            rate_radps: Rate to turn at, counter-clockwise.
            dt: Length of the tick, s.
            acceleration_max_radps2: Greatest angular acceleration.
        """
        motion = self._motion
        motion.x = self.yaw_rad
        jerk = _JERK_PER_ACCELERATION * acceleration_max_radps2
        motion.step_to_velocity(rate_radps, acceleration_max_radps2, jerk, dt)
        self.yaw_rad = self.goal_yaw_rad = wrap_angle(motion.x)
