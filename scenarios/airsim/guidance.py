"""References that lead a vehicle where AirSim's calls want it: smooth, and within its limits.

AirSim's own flight controller follows bare velocities. Ours gets a point that moves, with its
velocity and acceleration, because it then keeps to lines and heights in wind.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from autonomy.types import ZERO3, FlatReference, Vector3
from flightsim.autopilot.heading import HeadingMotion
from flightsim.autopilot.limits import MotionLimits, corner_speed
from flightsim.autopilot.trajectory import PathMotion, VelocityMotion, direction_between
from flightsim.frames import swap_yaw_enu_ned
from scenarios.airsim.messages import YawMode

FASTEST_XY_MPS, FASTEST_UP_MPS, FASTEST_DOWN_MPS = 12.0, 3.0, 1.5
"""Greatest speeds of the autopilot, as its parameters MPC_XY_VEL_MAX and MPC_Z_VEL_MAX_* say."""
FORWARD_ONLY = 1
"""Value of AirSim's DrivetrainType with which the nose points along the flight."""
TICK_S = 0.02

_YAW_RATE_RADPS, _YAW_ACCELERATION_RADPS2 = math.radians(90.0), math.radians(180.0)
_LEAST_SPEED_MPS = 0.3
"""Slower than this, the direction of flight turns no nose."""
_GREATEST_GAP_M = 3.0
"""The reference waits for a vehicle that is farther away, because something is in its path."""
_HOLDING = YawMode()
_CORNER_M = 2.0
"""Distance from a point of a path at which the next line may take over."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Facing:
    """Direction of the nose during a move."""

    mode: YawMode = _HOLDING
    drivetrain: int = 0


def limits_of(speed_mps: float) -> MotionLimits:
    """Limits of a move at a speed, never above what the autopilot flies."""
    speed = max(speed_mps, 0.05)
    return MotionLimits(
        speed_xy_mps=min(speed, FASTEST_XY_MPS),
        speed_up_mps=min(speed, FASTEST_UP_MPS),
        speed_down_mps=min(speed, FASTEST_DOWN_MPS),
        acceleration_xy_mps2=3.0,
        acceleration_up_mps2=3.0,
        acceleration_down_mps2=3.0,
        jerk_mps3=6.0,
    )


class Guidance:
    """A reference that moves by 20 ms a step.

    Attributes:
        heading: Its heading.
    """

    def __init__(self) -> None:
        self.heading = HeadingMotion()
        self._path, self._free = PathMotion(), VelocityMotion()
        self._position = self._velocity = self._acceleration = ZERO3

    def reset(self, position_enu_m: Vector3, velocity_enu_mps: Vector3, yaw_rad: float) -> None:
        """Begin where the vehicle is."""
        self._put(position_enu_m, velocity_enu_mps, ZERO3)
        self.heading.reset(yaw_rad)

    def _put(self, position: Vector3, velocity: Vector3, acceleration: Vector3) -> None:
        self._position, self._velocity, self._acceleration = position, velocity, acceleration
        self._path.reset(position, velocity, acceleration)

    @property
    def reference(self) -> FlatReference:
        """The reference now."""
        return FlatReference(
            position_enu_m=self._position,
            velocity_enu_mps=self._velocity,
            acceleration_enu_mps2=self._acceleration,
            yaw_rad=self.heading.yaw_rad,
            yaw_rate_radps=self.heading.yaw_rate_radps,
        )

    @property
    def position_enu_m(self) -> Vector3:
        """Position of the reference."""
        return self._position

    @property
    def is_at_rest(self) -> bool:
        """True if the reference rests at its goal."""
        return self._path.is_at_rest

    def fly_to(
        self,
        goal_enu_m: Vector3,
        speed_mps: float,
        *,
        line_start_enu_m: Vector3 | None = None,
        exit_speed_mps: float = 0.0,
    ) -> None:
        """Head for a goal; `step_path` moves the reference."""
        self._put(self._position, self._velocity, self._acceleration)
        self._path.fly_to(
            goal_enu_m,
            limits_of(speed_mps),
            line_start_enu_m=line_start_enu_m,
            exit_speed_mps=exit_speed_mps,
        )
        self._path.speed_limit_mps = min(self._path.speed_limit_mps, max(speed_mps, 0.05))

    def stop(self) -> None:
        """Head for the nearest point at which the reference can rest."""
        limits = limits_of(FASTEST_XY_MPS)
        self._put(self._position, self._velocity, self._acceleration)
        self._path.fly_to(self._path.stopping_point(limits), limits)

    def step_path(self) -> None:
        """Move towards the goal."""
        path = self._path
        path.step(TICK_S)
        self._position, self._velocity = path.position_enu_m, path.velocity_enu_mps
        self._acceleration = path.acceleration_enu_mps2

    def step_velocity(self, velocity_enu_mps: Vector3, height_m: float | None = None) -> None:
        """Move at a velocity; with a height, the vertical part leads there."""
        limits = limits_of(FASTEST_XY_MPS)
        vx, vy, vz = velocity_enu_mps
        speed = math.hypot(vx, vy)
        share = FASTEST_XY_MPS / speed if speed > FASTEST_XY_MPS else 1.0
        vz = min(max(vz, -FASTEST_DOWN_MPS), FASTEST_UP_MPS)
        self._free.reset(self._position, self._velocity, self._acceleration)
        x, y, z = self._free.axes
        for axis, v in ((x, vx * share), (y, vy * share)):
            axis.step_to_velocity(v, limits.acceleration_xy_mps2, limits.jerk_mps3, TICK_S)
        if height_m is None:
            z.step_to_velocity(vz, limits.acceleration_up_mps2, limits.jerk_mps3, TICK_S)
        else:
            fastest = FASTEST_UP_MPS if height_m > z.x else FASTEST_DOWN_MPS
            z.x -= height_m
            z.step_to_goal(fastest, limits.acceleration_up_mps2, limits.jerk_mps3, TICK_S)
            z.x += height_m
        self._position = (x.x, y.x, z.x)
        self._velocity = (x.v, y.v, z.v)
        self._acceleration = (x.a, y.a, z.a)

    def wait_for(self, position_enu_m: Vector3, velocity_enu_mps: Vector3) -> bool:
        """Return to a vehicle that cannot follow; whether that was necessary."""
        if math.dist(position_enu_m, self._position) <= _GREATEST_GAP_M:
            return False
        self._put(position_enu_m, velocity_enu_mps, ZERO3)
        return True

    def turn(self, facing: Facing) -> None:
        """Turn the nose for one step."""
        mode, heading = facing.mode, self.heading
        if mode.is_rate:
            # AirSim's rates turn clockwise.
            rate = -math.radians(mode.yaw_or_rate)
            rate = min(max(rate, -_YAW_RATE_RADPS), _YAW_RATE_RADPS)
            heading.step_rate(rate, TICK_S, _YAW_ACCELERATION_RADPS2)
            return
        goal: float | None = swap_yaw_enu_ned(math.radians(mode.yaw_or_rate))
        if facing.drivetrain == FORWARD_ONLY:
            east, north, _ = self._velocity
            goal = None
            if math.hypot(east, north) > _LEAST_SPEED_MPS:
                goal = math.atan2(north, east) - math.radians(mode.yaw_or_rate)
        if goal is not None:
            heading.goal_yaw_rad = goal
        heading.step(TICK_S, _YAW_RATE_RADPS, _YAW_ACCELERATION_RADPS2)


@dataclass(frozen=True, kw_only=True, slots=True)
class Leg:
    """A line of a path."""

    start_enu_m: Vector3 | None
    """Beginning of the line; None for the place of the reference."""
    goal_enu_m: Vector3
    radius_m: float
    """Distance from the goal at which the next line takes over; 0 stops there."""
    exit_speed_mps: float


def legs_through(
    start_enu_m: Vector3, points_enu_m: Sequence[Vector3], speed_mps: float
) -> list[Leg]:
    """Lines of a path whose corners are rounded, at speeds that allow it."""
    distinct = [start_enu_m]
    for point in points_enu_m:
        if math.dist(point, distinct[-1]) > 1e-3:
            distinct.append(point)
    legs: list[Leg] = []
    limits = limits_of(speed_mps)
    for i in range(1, len(distinct)):
        before, here = distinct[i - 1], distinct[i]
        radius = exit_speed = 0.0
        if i + 1 < len(distinct):
            after = distinct[i + 1]
            arriving, leaving = direction_between(before, here), direction_between(here, after)
            assert arriving is not None
            assert leaving is not None
            length = math.dist(here, after)
            radius = min(_CORNER_M, 0.4 * math.dist(before, here), 0.4 * length)
            exit_speed = corner_speed(arriving, leaving, radius, length, limits)
        legs.append(
            Leg(
                start_enu_m=before if i > 1 else None,
                goal_enu_m=here,
                radius_m=radius,
                exit_speed_mps=exit_speed,
            )
        )
    return legs
