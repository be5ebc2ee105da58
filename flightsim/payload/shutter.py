"""Shutter of the camera: takes pictures once, some times, by the clock or by distance flown.

A series by the clock and a distance may be asked for at once; a picture taken for one counts for
both. All pictures keep a least time between them, since each is rendered and a client's wish must
not stop the simulation.
"""

from __future__ import annotations

import math

from autonomy.types import Vector3
from flightsim.autopilot.results import ACCEPTED, Reply, denied, rejected

SHORTEST_S = 0.5
"""Least time between two pictures, which bounds the cost of a client's wish."""
LONGEST_S = 86_400.0
MAX_PICTURES = 100_000
_ENDLESS = -1


class Shutter:
    """Shutter that decides when to take the pictures that are asked for.

    Attributes:
        interval_s: Time between the pictures of the present series; 0 without one.
        distance_m: Distance between two pictures; 0 without such a wish.
        is_paused: True while neither a series nor a distance takes pictures.
    """

    def __init__(self) -> None:
        self.interval_s = 0.0
        self.distance_m = 0.0
        self.is_paused = False
        self._n_left = 0  # pictures left of the series; negative without end
        self._next_us = 0  # when the series is due next
        self._free_us = 0  # before this no picture is taken
        self._last_enu_m: Vector3 | None = None

    @property
    def is_in_series(self) -> bool:
        """True if pictures are still to come by the clock."""
        return self._n_left != 0

    def shoot(self, now_us: int, n_pictures: int = 1, interval_s: float = 0.0) -> Reply:
        """Take pictures from now on.

        Args:
            now_us: Present time.
            n_pictures: Number of pictures; 0 goes on until `stop`.
            interval_s: Time between them; 0 is as short as it can be.

        Returns:
            Acceptance; a denial of numbers out of range, and a rejection while a series runs.
        """
        if not 0 <= n_pictures <= MAX_PICTURES:
            return denied(f"{n_pictures} pictures; valid are 1 to {MAX_PICTURES}, and 0 for no end")
        # One picture has no interval, so a bad one with it does no harm.
        if n_pictures != 1 and interval_s and not SHORTEST_S <= interval_s <= LONGEST_S:
            valid = f"{SHORTEST_S:g} to {LONGEST_S:g} s"
            return denied(f"a picture each {interval_s:g} s; valid are {valid}")
        if self._n_left or now_us < self._free_us:
            return rejected("the camera is still taking pictures")
        self._n_left = n_pictures or _ENDLESS
        self.interval_s = 0.0 if n_pictures == 1 else interval_s or SHORTEST_S
        self._next_us = now_us
        return ACCEPTED

    def each(self, distance_m: float, *, is_at_once: bool = False) -> Reply:
        """Take a picture after each so many metres; 0 ends that.

        Args:
            distance_m: Distance between two pictures, up to 100 km.
            is_at_once: True takes the first one now.

        Returns:
            Acceptance, or a denial of a distance out of range.
        """
        if not 0.0 <= distance_m <= 1e5:
            return denied(f"a picture each {distance_m:g} m; valid are 0 to 100000 m")
        self.distance_m = distance_m
        self._last_enu_m = None
        if is_at_once and distance_m:
            self._n_left = self._n_left or 1
        return ACCEPTED

    def stop(self) -> None:
        """Take no more pictures by the clock."""
        self._n_left = 0
        self.interval_s = 0.0

    def is_due(self, now_us: int, position_enu_m: Vector3) -> bool:
        """Return True if a picture is to be taken at this tick, and count it; call it once a tick.

        Args:
            now_us: Present time.
            position_enu_m: Present position, for the distance flown.
        """
        if not self._n_left and not self.distance_m:
            return False
        # Distance first: its origin is set at the first call, even while the series is due.
        is_due = self._is_due_by_way(position_enu_m) or self._is_due_by_time(now_us)
        if not is_due or self.is_paused or now_us < self._free_us:
            return False
        self._free_us = now_us + round(1e6 * SHORTEST_S)
        self._last_enu_m = position_enu_m
        if self._n_left and now_us >= self._next_us:
            self._n_left -= 1 if self._n_left > 0 else 0
            self._next_us = now_us + round(1e6 * self.interval_s)
            if not self._n_left:
                self.interval_s = 0.0
        return True

    def _is_due_by_time(self, now_us: int) -> bool:
        return self._n_left != 0 and now_us >= self._next_us

    def _is_due_by_way(self, position_enu_m: Vector3) -> bool:
        if not self.distance_m:
            return False
        # Distance counts from where the vehicle was when it was asked for.
        if self._last_enu_m is None:
            self._last_enu_m = position_enu_m
        return math.dist(position_enu_m, self._last_enu_m) >= self.distance_m
