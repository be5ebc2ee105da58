"""References along straight lines: smooth, within limits, with exact stops.

A `PathMotion` moves a point towards a goal along a line. Along the line and across it the laws of
`axis` apply, each with the full limits, so that a straight flight from rest stays exactly on its
line and a corner is rounded within its acceptance radius.
"""

from __future__ import annotations

from math import hypot, sqrt

from autonomy.types import ZERO3, Vector3
from flightsim.autopilot.axis import AxisMotion, braking_distance
from flightsim.autopilot.limits import MotionLimits

_EAST: Vector3 = (1.0, 0.0, 0.0)
_NORTH: Vector3 = (0.0, 1.0, 0.0)


class PathMotion:
    """A point on its way to a goal, with its derivatives.

    Attributes:
        position_enu_m: Position of the reference.
        velocity_enu_mps: Its velocity.
        acceleration_enu_mps2: Its acceleration.
        jerk_enu_mps3: Its jerk over the last tick.
        goal_enu_m: Position where it stops, or which it passes at the exit speed.
        speed_limit_mps: Speed along the line; may be changed at any tick.
    """

    def __init__(self) -> None:
        self.position_enu_m: Vector3 = ZERO3
        self.velocity_enu_mps: Vector3 = ZERO3
        self.acceleration_enu_mps2: Vector3 = ZERO3
        self.jerk_enu_mps3: Vector3 = ZERO3
        self.goal_enu_m: Vector3 = ZERO3
        self.speed_limit_mps = 0.0
        self._limits: MotionLimits | None = None
        self._exit_speed_mps = 0.0
        self._axes: tuple[Vector3, Vector3, Vector3] = (_EAST, _NORTH, (0.0, 0.0, 1.0))
        self._along, self._across, self._over = AxisMotion(), AxisMotion(), AxisMotion()
        self._speeds_mps = self._accelerations_mps2 = ZERO3

    @property
    def is_at_rest(self) -> bool:
        """True if the reference has come to rest at the goal."""
        return self._along.is_at_rest and self._across.is_at_rest and self._over.is_at_rest

    def reset(
        self,
        position_enu_m: Vector3,
        velocity_enu_mps: Vector3 = ZERO3,
        acceleration_enu_mps2: Vector3 = ZERO3,
    ) -> None:
        """Put the reference somewhere, without a goal; `fly_to` must follow.

        Args:
            position_enu_m: Position.
            velocity_enu_mps: Velocity from which the next motion continues.
            acceleration_enu_mps2: Acceleration from which it continues.
        """
        self.position_enu_m = self.goal_enu_m = position_enu_m
        self.velocity_enu_mps = velocity_enu_mps
        self.acceleration_enu_mps2 = acceleration_enu_mps2
        self.jerk_enu_mps3 = ZERO3
        self._limits = None
        for axis in (self._along, self._across, self._over):
            axis.x = axis.v = axis.a = axis.j = 0.0

    def fly_to(
        self,
        goal_enu_m: Vector3,
        limits: MotionLimits,
        *,
        line_start_enu_m: Vector3 | None = None,
        exit_speed_mps: float = 0.0,
    ) -> None:
        """Head for a goal; repeating the same goal changes nothing.

        Args:
            goal_enu_m: Position to fly to.
            limits: Limits of the motion.
            line_start_enu_m: Start of the line to follow; None is the present position.
            exit_speed_mps: Speed along the line at which the goal may be passed.
        """
        if (
            # By identity: limits are the same object until one of them changes, see `FlightLimits`.
            limits is self._limits
            and goal_enu_m == self.goal_enu_m
            and exit_speed_mps == self._exit_speed_mps
        ):
            return
        self.goal_enu_m = goal_enu_m
        self._limits = limits
        self._exit_speed_mps = exit_speed_mps
        self._set_line(line_start_enu_m or self.position_enu_m)

    def stopping_point(self, limits: MotionLimits) -> Vector3:
        """Return the position where the present motion can come to rest, ENU m.

        Args:
            limits: Limits of the deceleration.
        """
        v = self.velocity_enu_mps
        speed = sqrt(_dot(v, v))
        if speed < 1e-6:
            return self.position_enu_m
        direction = (v[0] / speed, v[1] / speed, v[2] / speed)
        distance_m = braking_distance(
            speed,
            _dot(self.acceleration_enu_mps2, direction),
            0.0,
            limits.acceleration_along(direction),
            limits.jerk_mps3,
        )
        # At least 1 mm ahead, so that the direction of the line stays defined.
        return _moved(self.position_enu_m, direction, max(distance_m, 1e-3))

    def step(self, dt: float) -> None:
        """Advance by one tick; without a goal the reference stays in place.

        Args:
            dt: Length of the tick, s; a shorter one slows the reference down.
        """
        limits = self._limits
        if limits is None:
            return
        jerk = limits.jerk_mps3
        along, across, over = self._along, self._across, self._over
        acc = self._accelerations_mps2
        along.step_to_goal(self.speed_limit_mps, acc[0], jerk, dt, self._exit_speed_mps)
        u, n, b = self._axes
        # On the line only one axis moves; most ticks of a flight end here.
        if across.is_at_rest and over.is_at_rest:
            self.position_enu_m = _moved(self.goal_enu_m, u, along.x)
            self.velocity_enu_mps = _scaled(u, along.v)
            self.acceleration_enu_mps2 = _scaled(u, along.a)
            self.jerk_enu_mps3 = _scaled(u, along.j)
            return
        across.step_to_goal(self._speeds_mps[1], acc[1], jerk, dt)
        over.step_to_goal(self._speeds_mps[2], acc[2], jerk, dt)
        gx, gy, gz = self.goal_enu_m
        x, y, z = _combined(u, n, b, along.x, across.x, over.x)
        self.position_enu_m = (gx + x, gy + y, gz + z)
        self.velocity_enu_mps = _combined(u, n, b, along.v, across.v, over.v)
        self.acceleration_enu_mps2 = _combined(u, n, b, along.a, across.a, over.a)
        self.jerk_enu_mps3 = _combined(u, n, b, along.j, across.j, over.j)

    def _set_line(self, start_enu_m: Vector3) -> None:
        """Align the axes with the line and express the present motion in them."""
        limits = self._limits
        assert limits is not None
        u = direction_between(start_enu_m, self.goal_enu_m)
        if u is None:
            # No line: keep the direction of motion, or any one at rest.
            u = direction_between(ZERO3, self.velocity_enu_mps) or _EAST
        horizontal = hypot(u[0], u[1])
        # Across the line and level; for a vertical line any level direction will do.
        n = (-u[1] / horizontal, u[0] / horizontal, 0.0) if horizontal > 1e-6 else _NORTH
        b = (u[1] * n[2] - u[2] * n[1], u[2] * n[0] - u[0] * n[2], u[0] * n[1] - u[1] * n[0])
        (px, py, pz), (gx, gy, gz) = self.position_enu_m, self.goal_enu_m
        offset = (px - gx, py - gy, pz - gz)
        for motion, axis in zip((self._along, self._across, self._over), (u, n, b), strict=True):
            motion.x = _dot(offset, axis)
            motion.v = _dot(self.velocity_enu_mps, axis)
            motion.a = _dot(self.acceleration_enu_mps2, axis)
        # Rounding across the line would keep all three axes busy for the whole flight.
        _drop_rounding(self._across, self._over)
        self._axes = (u, n, b)
        self._speeds_mps = (
            limits.speed_along(u),
            limits.speed_along(n),
            # The third axis points up or down with the line, so both vertical limits may apply.
            min(limits.speed_along(b), limits.speed_along(_scaled(b, -1.0))),
        )
        self._accelerations_mps2 = (
            limits.acceleration_along(u),
            limits.acceleration_along(n),
            limits.acceleration_along(b),
        )
        self.speed_limit_mps = self._speeds_mps[0]


class VelocityMotion:
    """A point that follows a desired velocity within limits, per axis of the world."""

    def __init__(self) -> None:
        self.axes = (AxisMotion(), AxisMotion(), AxisMotion())

    def reset(
        self,
        position_enu_m: Vector3,
        velocity_enu_mps: Vector3 = ZERO3,
        acceleration_enu_mps2: Vector3 = ZERO3,
    ) -> None:
        """Put the point at a position, without a jerk.

        Args:
            position_enu_m: New position.
            velocity_enu_mps: Velocity to continue with; by default it rests.
            acceleration_enu_mps2: Acceleration to continue with.
        """
        for i, axis in enumerate(self.axes):
            axis.x, axis.v, axis.a = (
                position_enu_m[i],
                velocity_enu_mps[i],
                acceleration_enu_mps2[i],
            )
            axis.j = 0.0

    def step(self, velocity_enu_mps: Vector3, limits: MotionLimits, dt: float) -> None:
        """Advance by one tick towards a velocity.

        Args:
            velocity_enu_mps: Desired velocity.
            limits: Limits of acceleration and jerk; speeds are not limited here.
            dt: Length of the tick, s.
        """
        x, y, z = self.axes
        x.step_to_velocity(velocity_enu_mps[0], limits.acceleration_xy_mps2, limits.jerk_mps3, dt)
        y.step_to_velocity(velocity_enu_mps[1], limits.acceleration_xy_mps2, limits.jerk_mps3, dt)
        vertical = min(limits.acceleration_up_mps2, limits.acceleration_down_mps2)
        z.step_to_velocity(velocity_enu_mps[2], vertical, limits.jerk_mps3, dt)


def direction_between(start: Vector3, end: Vector3) -> Vector3 | None:
    """Return the unit vector from one point to another; None if they are within 0.1 mm."""
    dx, dy, dz = end[0] - start[0], end[1] - start[1], end[2] - start[2]
    length = sqrt(dx * dx + dy * dy + dz * dz)
    return (dx / length, dy / length, dz / length) if length > 1e-4 else None


def _drop_rounding(*motions: AxisMotion) -> None:
    for motion in motions:
        if abs(motion.x) < 1e-9 and abs(motion.v) < 1e-9 and abs(motion.a) < 1e-9:
            motion.x = motion.v = motion.a = motion.j = 0.0


def _dot(p: Vector3, q: Vector3) -> float:
    return p[0] * q[0] + p[1] * q[1] + p[2] * q[2]


def _moved(p: Vector3, direction: Vector3, distance: float) -> Vector3:
    return (
        p[0] + direction[0] * distance,
        p[1] + direction[1] * distance,
        p[2] + direction[2] * distance,
    )


def _scaled(p: Vector3, k: float) -> Vector3:
    return (p[0] * k, p[1] * k, p[2] * k)


def _combined(u: Vector3, n: Vector3, b: Vector3, x: float, y: float, z: float) -> Vector3:
    return (
        u[0] * x + n[0] * y + b[0] * z,
        u[1] * x + n[1] * y + b[1] * z,
        u[2] * x + n[2] * y + b[2] * z,
    )
