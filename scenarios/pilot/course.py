"""Course of the vehicle: one trajectory after another, or the last stretch of a landing."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from autonomy.planning import Trajectory
from autonomy.types import FlatReference, Vector3
from flightsim.mavlink.client.telemetry import Telemetry

TOUCHDOWN_SPEED_MPS = 0.4
_CONTACT_SPEED_MPS = 0.3
"""Speed over the last `_SLOW_M` above the surface: a gust adds to it."""
_SLOW_M = 0.2
_PRESS_M = 0.4
"""Depth of the last setpoints below the surface, so that the rotors unload."""
_AT_PLACE_M = 0.25
_AT_REST_MPS = 0.2
_SOON_US = 1_500_000
_PAUSE_US = 100_000
_ENDING_S = 1.0


class Course:
    """Setpoints over time.

    Attributes:
        trajectory: The present or next trajectory, or the last one before the last stretch.
    """

    def __init__(self, trajectory: Trajectory) -> None:
        self.trajectory = trajectory
        self._begun_us: int | None = None
        self._before: tuple[Trajectory, int] | None = None
        self._touchdown: tuple[int, FlatReference, float] | None = None

    @property
    def has_begun(self) -> bool:
        """Whether there is anything to follow yet."""
        return self._begun_us is not None

    @property
    def is_touching_down(self) -> bool:
        """Whether the vehicle is in the last stretch."""
        return self._touchdown is not None

    def fly(self, trajectory: Trajectory, begin_us: int) -> None:
        """Follow a trajectory from a given time on, and the previous one until then.

        Without a previous trajectory, that time must be the present.
        """
        if self._begun_us is not None:
            self._before = (self.trajectory, self._begun_us)
        self.trajectory = trajectory
        self._begun_us = begin_us
        self._touchdown = None

    def touch_down(self, time_us: int, resting_height_m: float) -> None:
        """Sink from the present setpoint onto a surface.

        Args:
            time_us: Present time.
            resting_height_m: Height of the vehicle's origin when it stands on the surface.
        """
        self._touchdown = (time_us, self.reference(time_us), resting_height_m)

    def pause(self, time_us: int) -> None:
        """Sink no further for a moment; call it again to stay at a height for longer."""
        if self._touchdown is not None:
            begin = replace(self.reference(time_us), velocity_enu_mps=(0.0, 0.0, 0.0))
            self._touchdown = (time_us + _PAUSE_US, begin, self._touchdown[2])

    def reference(self, time_us: int) -> FlatReference:
        """Setpoint at a given time."""
        if self._touchdown is not None:
            return _sinking(time_us, *self._touchdown)
        if self._before is not None and self._begun_us is not None and time_us < self._begun_us:
            trajectory, begun_us = self._before
            return trajectory.sample((time_us - begun_us) * 1e-6)
        return self.trajectory.sample(self.elapsed_s(time_us))

    def heading_rad(self, time_us: int) -> float | None:
        """Direction of the coming motion; None where it is hardly horizontal."""
        now, soon = (self.reference(t).position_enu_m for t in (time_us, time_us + _SOON_US))
        x, y, _ = np.subtract(soon, now).tolist()
        return math.atan2(y, x) if math.hypot(x, y) > _AT_PLACE_M else None

    def has_arrived(self, time_us: int, telemetry: Telemetry) -> bool:
        """Whether the trajectory is over and the vehicle rests at its end."""
        if self.is_under_way(time_us):
            return False
        away_m = math.dist(telemetry.position_enu_m, self.reference(time_us).position_enu_m)
        return away_m < _AT_PLACE_M and math.hypot(*telemetry.velocity_enu_mps) < _AT_REST_MPS

    def is_slower_than_touchdown(self, time_us: int) -> bool:
        """Whether the trajectory has slowed to where the last stretch can go on from it."""
        speed_mps = math.hypot(*self.reference(time_us).velocity_enu_mps)
        return self.ends_within(time_us, _ENDING_S) and speed_mps <= TOUCHDOWN_SPEED_MPS

    def ends_within(self, time_us: int, seconds: float) -> bool:
        """Whether at most some time of the trajectory is left."""
        return self.trajectory.duration_s - self.elapsed_s(time_us) <= seconds

    def is_under_way(self, time_us: int) -> bool:
        """Whether the trajectory is not over yet."""
        return self.elapsed_s(time_us) < self.trajectory.duration_s

    def elapsed_s(self, time_us: int) -> float:
        """Time within the trajectory; negative before it takes over."""
        return 0.0 if self._begun_us is None else (time_us - self._begun_us) * 1e-6


def _sinking(
    time_us: int, begun_us: int, begin: FlatReference, resting_height_m: float
) -> FlatReference:
    """Vertical descent, slower at the end, to a little below the surface."""
    if time_us < begun_us:
        return begin
    x, y, z = begin.position_enu_m
    lowest_m, slow_m = resting_height_m - _PRESS_M, resting_height_m + _SLOW_M
    speed_mps = TOUCHDOWN_SPEED_MPS
    height_m = z - speed_mps * (time_us - begun_us) * 1e-6
    if height_m < slow_m:
        speed_mps = _CONTACT_SPEED_MPS
        height_m = slow_m - (slow_m - height_m) * speed_mps / TOUCHDOWN_SPEED_MPS
    position_enu_m: Vector3 = (x, y, max(height_m, lowest_m))
    return FlatReference(
        position_enu_m=position_enu_m,
        velocity_enu_mps=(0.0, 0.0, -speed_mps if height_m > lowest_m else 0.0),
        yaw_rad=begin.yaw_rad,
    )
