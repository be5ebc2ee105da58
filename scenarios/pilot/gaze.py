"""Where the vehicle looks while somebody may come along: around, and not only where it flies.

Who is going to meet the vehicle stays at the same bearing all the while. For a vehicle that
flies at v and somebody at up to w that bearing lies anywhere if v < w, else up to asin(w / v) to
either side of the course. One camera does not cover that unless the vehicle is fast. So it turns
to and fro as far as it must, all round where it stands, and keeps to who was just found or comes
near. Who comes from behind, faster than it flies, it does not see.
"""

from __future__ import annotations

import math
from dataclasses import replace

from autonomy.planning import FlightLimits
from autonomy.planning.yaw import next_rate
from autonomy.types import FlatReference

MOVER_SPEED_MPS = 3.0
"""Of the fastest that are looked out for."""
HALF_VIEW_RAD = math.radians(30.0)
"""To either side of where it looks; the camera has 37 degrees, of which a few are for edges."""
ROUND_RAD = math.radians(300.0)
"""Of turning, after which all that is around came into view."""
MOST_LOOK_S = 8.0
"""After which a look around is over even where something held its gaze; else it takes 4 s."""
MOST_ASIDE_RAD = math.radians(60.0)
"""It turns no farther from its course in flight: there it has to look again soon."""
_OVERSHOOT_RAD = 0.3
_MOST_STEP_S = 0.1


class Gaze:
    """Turns the heading of setpoints, within the limits of the motion.

    Attributes:
        kept_rad: Bearing of what is to be kept in view, None to look around.
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
        self,
        time_us: int,
        setpoint: FlatReference,
        course_rad: float | None,
        *,
        looks_around: bool,
    ) -> FlatReference:
        """A setpoint with the heading to look by; to be called for every one.

        Args:
            time_us: Now.
            setpoint: What is flown; its own heading is where to look if not around.
            course_rad: Where it flies to, None where it stands.
            looks_around: Whether to look out now.
        """
        if self._yaw_rad is None:
            self._yaw_rad, self._time_us = setpoint.yaw_rad, time_us
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
        """Whether what is to be kept in view is, as far as the heading goes; True for nothing."""
        if self.kept_rad is None or self._yaw_rad is None:
            return True
        return abs(math.remainder(self.kept_rad - self._yaw_rad, math.tau)) < HALF_VIEW_RAD

    def has_looked_round(self, time_us: int) -> bool:
        """Whether it looked all around since this was first asked; to be asked until it has."""
        if self._round is None:
            self._round = (time_us, self._turned_rad)
        since_us, since_rad = self._round
        is_over = time_us - since_us > 1e6 * MOST_LOOK_S
        if self._turned_rad - since_rad < ROUND_RAD and not is_over:
            return False
        self._round = None
        return True

    def _left_rad(self, setpoint: FlatReference, course_rad: float | None) -> float:
        """How far it has to turn yet, looking around."""
        assert self._yaw_rad is not None
        if self.kept_rad is not None:
            return math.remainder(self.kept_rad - self._yaw_rad, math.tau)
        u, v, _ = setpoint.velocity_enu_mps
        if course_rad is None:
            return self._side * math.pi / 2
        off_rad = math.remainder(self._yaw_rad - course_rad, math.tau)
        most_rad = max(danger_rad(math.hypot(u, v)) - HALF_VIEW_RAD, 0.0)
        most_rad = min(most_rad, MOST_ASIDE_RAD)
        # It cannot turn back at once.
        rate_radps = self._side * self._rate_radps
        coast_rad = max(rate_radps, 0.0) ** 2 / (2 * self._limits.yaw_acceleration_radps2)
        if self._side * off_rad + coast_rad >= most_rad:
            self._side = -self._side
        return self._side * (most_rad + _OVERSHOOT_RAD) - off_rad


def danger_rad(speed_mps: float) -> float:
    """To either side of the course: how far from it somebody may come who meets the vehicle."""
    return math.pi if speed_mps <= MOVER_SPEED_MPS else math.asin(MOVER_SPEED_MPS / speed_mps)
