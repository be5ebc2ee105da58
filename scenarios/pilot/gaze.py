"""Gaze of the vehicle: it turns to look for approaching movers, not only along its course.

A mover on a collision course stays at a constant bearing. For a vehicle that flies at v and movers
of speed up to w, that bearing is arbitrary if v < w, else up to asin(w / v) to either side of the
course. One camera does not cover that unless the vehicle is fast. So the vehicle turns to and fro
as far as necessary, all round while it stands, and keeps a mover in view that was just found or
comes near. It does not see movers that approach from behind, faster than it flies.
"""

from __future__ import annotations

import math
from dataclasses import replace

from autonomy.planning import FlightLimits
from autonomy.planning.yaw import next_rate
from autonomy.types import FlatReference

MOVER_SPEED_MPS = 3.0
"""Greatest speed of the movers to look out for."""
HALF_VIEW_RAD = math.radians(30.0)
"""Usable half angle of view; the camera has 37 degrees, less a few for the edges."""
ROUND_RAD = math.radians(300.0)
"""Angle of turning that brings the whole surroundings into view."""
MOST_LOOK_S = 8.0
"""Longest look around, even if something holds the gaze; otherwise it takes 4 s."""
MOST_ASIDE_RAD = math.radians(60.0)
"""Greatest turn from the course in flight, which soon has to be viewed again."""
_OVERSHOOT_RAD = 0.3  # aimed beyond the turning point, so that the turn keeps its speed up to there
_MOST_STEP_S = 0.1  # longest step between calls, against a jump of the heading


class Gaze:
    """Turns the heading of set points, within the limits of the motion.

    Attributes:
        kept_rad: Bearing to keep in view, None to look around.
    """

    def __init__(self, limits: FlightLimits) -> None:
        self._limits = limits
        self.kept_rad: float | None = None
        self._turned_rad = 0.0
        self._round: tuple[int, float] | None = None
        self._yaw_rad: float | None = None
        self._rate_radps = 0.0
        self._time_us = 0
        self._side = 1.0

    def turn(
        self, time_us: int, setpoint: FlatReference, course_rad: float | None, *, looks_around: bool
    ) -> FlatReference:
        """Return the set point with the heading of the gaze; call it for every set point.

        Args:
            time_us: Present time.
            setpoint: Present set point; its own heading is used when not looking around.
            course_rad: Direction of flight, None at rest.
            looks_around: True to look around now.
        """
        if self._yaw_rad is None:
            self._yaw_rad, self._time_us = setpoint.yaw_rad, time_us
        # After a pause in the calls, the heading must not leap.
        step_s = min((time_us - self._time_us) * 1e-6, _MOST_STEP_S)
        self._time_us = time_us
        if looks_around:
            left_rad = self._left_rad(setpoint, course_rad)
        else:
            left_rad = math.remainder(setpoint.yaw_rad - self._yaw_rad, math.tau)
        limits = self._limits
        self._rate_radps = next_rate(
            self._rate_radps,
            left_rad,
            step_s,
            limits.yaw_rate_radps,
            limits.yaw_acceleration_radps2,
        )
        self._yaw_rad += self._rate_radps * step_s
        self._turned_rad += abs(self._rate_radps) * step_s
        return replace(setpoint, yaw_rad=self._yaw_rad, yaw_rate_radps=self._rate_radps)

    @property
    def is_on_it(self) -> bool:
        """True if the heading has the bearing to keep in view, or if there is no such bearing."""
        if self.kept_rad is None or self._yaw_rad is None:
            return True
        return abs(math.remainder(self.kept_rad - self._yaw_rad, math.tau)) < HALF_VIEW_RAD

    def has_looked_round(self, time_us: int) -> bool:
        """Return whether the gaze went all round since the first call; call it until it has."""
        if self._round is None:
            self._round = (time_us, self._turned_rad)
        since_us, since_rad = self._round
        is_over = time_us - since_us > 1e6 * MOST_LOOK_S
        if self._turned_rad - since_rad < ROUND_RAD and not is_over:
            return False
        self._round = None
        return True

    def _left_rad(self, setpoint: FlatReference, course_rad: float | None) -> float:
        """Angle left to turn while looking around, rad; positive to the left."""
        assert self._yaw_rad is not None
        if self.kept_rad is not None:
            return math.remainder(self.kept_rad - self._yaw_rad, math.tau)
        u, v, _ = setpoint.velocity_enu_mps
        if course_rad is None:
            # At rest: a target that moves along turns the vehicle round and round.
            return self._side * math.pi / 2
        off_rad = math.remainder(self._yaw_rad - course_rad, math.tau)
        most_rad = max(danger_rad(math.hypot(u, v)) - HALF_VIEW_RAD, 0.0)
        most_rad = min(most_rad, MOST_ASIDE_RAD)
        # The rotation cannot reverse at once.
        rate_radps = self._side * self._rate_radps
        coast_rad = max(rate_radps, 0.0) ** 2 / (2 * self._limits.yaw_acceleration_radps2)
        if self._side * off_rad + coast_rad >= most_rad:
            self._side = -self._side
        return self._side * (most_rad + _OVERSHOOT_RAD) - off_rad


def danger_rad(speed_mps: float) -> float:
    """Largest angle between the course and the bearing of a mover that may collide."""
    return math.pi if speed_mps <= MOVER_SPEED_MPS else math.asin(MOVER_SPEED_MPS / speed_mps)
