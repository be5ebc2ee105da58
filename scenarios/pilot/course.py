"""Course of the vehicle: one trajectory after another, or the last stretch of a landing.

A plan made in flight takes over a little later, at the point where the present plan has the vehicle
then. The course therefore keeps two trajectories and the time at which one hands over to the other.
The last stretch is no trajectory, because it may wait for gusts to pass.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from autonomy.planning import Trajectory
from autonomy.types import FlatReference, Vector3
from flightsim.mavlink.client.telemetry import Telemetry

_CONTACT_SPEED_MPS = 0.3
"""Speed over the last `_SLOW_M` above the surface. It is low because a gust adds to it."""
_SLOW_M = 0.2  # above the surface on which the vehicle rests
_SLOWING_PER_S = 2.0
"""Speed that is lost for each metre on the way down to `_SLOW_M`."""
_PRESS_M = 0.4
"""Depth of the last set points below the surface, so that the rotors unload."""
AT_PLACE_M, AT_REST_MPS = 0.25, 0.2
"""Distance and speed below which a vehicle is at a place, unless it is known to hover less well."""
_SOON_US = 1_500_000  # look-ahead that gives the direction of the coming motion
_PAUSE_US = 100_000  # one call of `pause` lasts so long; ticks come more often
_RISE_M = 0.01
"""Rise in a tick: 0.5 m/s."""
_ENDING_S = 1.0  # before its end a trajectory may be left early


@dataclass(frozen=True, slots=True)
class _Stretch:
    """Last stretch of a landing: a vertical descent to a little below the surface.

    Its speed falls in proportion to the height, to that of contact `_SLOW_M` above the surface.
    """

    begun_us: int
    begin: FlatReference
    resting_height_m: float
    speed_mps: float
    """Greatest speed."""

    def reference(self, time_us: int) -> FlatReference:
        """Set point at a given time."""
        if time_us < self.begun_us:
            return self.begin
        x, y, z = self.begin.position_enu_m
        slow_m, lowest_m = self.resting_height_m + _SLOW_M, self.resting_height_m - _PRESS_M
        above_m, speed_mps = self._sunk(z - slow_m, (time_us - self.begun_us) * 1e-6)
        # Down to below the surface, where the set point stays.
        height_m = max(slow_m + above_m, lowest_m)
        position_enu_m: Vector3 = (x, y, height_m)
        return FlatReference(
            position_enu_m=position_enu_m,
            velocity_enu_mps=(0.0, 0.0, -speed_mps if height_m > lowest_m else 0.0),
            yaw_rad=self.begin.yaw_rad,
        )

    def _sunk(self, above_m: float, elapsed_s: float) -> tuple[float, float]:
        """Height above the slow part, and speed, some time after a start `above_m` over it.

        Three parts follow each other: constant speed, a speed that falls in proportion to the
        height, and the constant speed of contact.
        """
        slowing_m = (self.speed_mps - _CONTACT_SPEED_MPS) / _SLOWING_PER_S
        fast_s = max(0.0, (above_m - slowing_m) / self.speed_mps)
        if elapsed_s < fast_s:
            return above_m - self.speed_mps * elapsed_s, self.speed_mps
        above_m, elapsed_s = min(above_m, slowing_m), elapsed_s - fast_s
        if above_m > 0.0:
            first_mps = _CONTACT_SPEED_MPS + _SLOWING_PER_S * above_m
            slowing_s = math.log(first_mps / _CONTACT_SPEED_MPS) / _SLOWING_PER_S
            if elapsed_s < slowing_s:
                speed_mps = first_mps * math.exp(-_SLOWING_PER_S * elapsed_s)
                return (speed_mps - _CONTACT_SPEED_MPS) / _SLOWING_PER_S, speed_mps
            above_m, elapsed_s = 0.0, elapsed_s - slowing_s
        return above_m - _CONTACT_SPEED_MPS * elapsed_s, _CONTACT_SPEED_MPS


class Course:
    """Set points over time.

    Attributes:
        trajectory: The present or next trajectory, or the last one before the last stretch.
    """

    def __init__(self, trajectory: Trajectory) -> None:
        self.trajectory = trajectory
        self._begun_us: int | None = None
        self._before: tuple[Trajectory, int] | None = None
        self._touchdown: _Stretch | None = None

    @property
    def has_begun(self) -> bool:
        """True once there is anything to follow."""
        return self._begun_us is not None

    @property
    def is_touching_down(self) -> bool:
        """True while the vehicle is in the last stretch."""
        return self._touchdown is not None

    def fly(self, trajectory: Trajectory, begin_us: int) -> None:
        """Follow a trajectory from a given time on, and the previous one until then.

        Without a previous trajectory, that time must be the present.
        """
        if self._begun_us is not None:
            # Until the new one takes over, set points come from the old one.
            self._before = (self.trajectory, self._begun_us)
        self.trajectory = trajectory
        self._begun_us = begin_us
        self._touchdown = None

    def touch_down(self, time_us: int, resting_height_m: float, speed_mps: float) -> None:
        """Sink from the present set point onto a surface.

        Args:
            time_us: Present time.
            resting_height_m: Height of the vehicle's origin when it stands on the surface.
            speed_mps: Speed at first; it falls to that of contact.
        """
        self._touchdown = _Stretch(time_us, self.reference(time_us), resting_height_m, speed_mps)

    def pause(self, time_us: int, rise_to_m: float = -math.inf) -> None:
        """Sink no further for a moment; call it again to stay at a height for longer.

        Args:
            time_us: Present time.
            rise_to_m: Height up to which it rises meanwhile, a little at each call.
        """
        if self._touchdown is not None:
            x, y, z = self.reference(time_us).position_enu_m
            begin = replace(
                self.reference(time_us),
                position_enu_m=(x, y, max(z, min(z + _RISE_M, rise_to_m))),
                velocity_enu_mps=(0.0, 0.0, 0.0),
            )
            # The stretch begins anew after the pause, from the height reached.
            later_us = time_us + _PAUSE_US
            self._touchdown = replace(self._touchdown, begun_us=later_us, begin=begin)

    def sink_from(self, time_us: int, here_enu_m: Vector3, resting_height_m: float) -> None:
        """Continue the descent above another place.

        Args:
            time_us: Present time.
            here_enu_m: Set point to continue from.
            resting_height_m: Height of the vehicle's origin when it stands on the surface there.
        """
        if self._touchdown is not None:
            begin = replace(self.reference(time_us), position_enu_m=here_enu_m)
            self._touchdown = replace(
                self._touchdown, begun_us=time_us, begin=begin, resting_height_m=resting_height_m
            )

    def reference(self, time_us: int) -> FlatReference:
        """Set point at a given time, of whichever motion is in force then."""
        if self._touchdown is not None:
            return self._touchdown.reference(time_us)
        if self._before is not None and self._begun_us is not None and time_us < self._begun_us:
            trajectory, begun_us = self._before
            return trajectory.sample((time_us - begun_us) * 1e-6)
        return self.trajectory.sample(self.elapsed_s(time_us))

    def heading_rad(self, time_us: int) -> float | None:
        """Direction of the coming motion; None if it is hardly horizontal."""
        now, soon = (self.reference(t).position_enu_m for t in (time_us, time_us + _SOON_US))
        x, y, _ = np.subtract(soon, now).tolist()
        return math.atan2(y, x) if math.hypot(x, y) > AT_PLACE_M else None

    def has_arrived(
        self,
        time_us: int,
        telemetry: Telemetry,
        *,
        within_m: float = AT_PLACE_M,
        most_mps: float = AT_REST_MPS,
    ) -> bool:
        """Return whether the trajectory is over and the vehicle rests at its end.

        Args:
            time_us: Time now.
            telemetry: Position and velocity of the vehicle.
            within_m: Distance from the end that counts as being there.
            most_mps: Speed that counts as rest.
        """
        if self.is_under_way(time_us):
            return False
        away_m = math.dist(telemetry.position_enu_m, self.reference(time_us).position_enu_m)
        return away_m < within_m and math.hypot(*telemetry.velocity_enu_mps) < most_mps

    def is_slower_than(self, most_mps: float, time_us: int) -> bool:
        """Return whether the trajectory is in its last second and slower than a limit.

        Another motion can then go on from there without a stop.
        """
        speed_mps = math.hypot(*self.reference(time_us).velocity_enu_mps)
        return self.ends_within(time_us, _ENDING_S) and speed_mps <= most_mps

    def ends_within(self, time_us: int, seconds: float) -> bool:
        """Return whether at most some time of the trajectory is left."""
        return self.trajectory.duration_s - self.elapsed_s(time_us) <= seconds

    def is_under_way(self, time_us: int) -> bool:
        """Return whether the trajectory is not over yet."""
        return self.elapsed_s(time_us) < self.trajectory.duration_s

    def elapsed_s(self, time_us: int) -> float:
        """Time within the trajectory, s; negative before it takes over."""
        return 0.0 if self._begun_us is None else (time_us - self._begun_us) * 1e-6
